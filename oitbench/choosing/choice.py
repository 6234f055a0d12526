"""The methods that fit a platform, and what each loses, from the records of results folders."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from oitbench.choosing.constraints import Constraints
from oitbench.errors import UsageError, unknown
from oitbench.image import metrics
from oitbench.image.ties import Errors, clear_difference, clear_mean_difference
from oitbench.results.ranking import Ranking, ranking
from oitbench.results.records import Panel, Results, parts
from oitbench.results.schema import CellKey, Record

METRIC = metrics.FLIP_LDR
"""The error by which methods are chosen."""


@dataclass(frozen=True)
class Candidate:
    """A method in one scene.

    Parameters
    ----------
    cell : Record
    reasons : tuple of str
        Why it does not fit; empty if it does.
    errors : Errors or None
        Against the truth that ranks the scene; None if there is none.
    loss : float or None
        By how much the error clearly exceeds that of the best method of the scene, whether that one
        fits or not; 0 for a tie.
    """

    cell: Record
    reasons: tuple[str, ...]
    errors: Errors | None
    loss: float | None

    @property
    def fits(self) -> bool:
        """Whether it meets all constraints."""
        return not self.reasons

    def error(self, truth: str) -> float | None:
        """Return its error against any truth, or None."""
        return self.cell.metric(truth, METRIC)


@dataclass(frozen=True)
class SceneChoice:
    """The candidates in one scene, lowest error first and those without an error last.

    `truth` ranks them. `best` are the methods with the lowest error of all and those that tie with
    it, and `chosen` those among the methods that fit.
    """

    title: str
    truth: str
    candidates: tuple[Candidate, ...]
    best: tuple[str, ...]
    chosen: tuple[str, ...]


@dataclass(frozen=True)
class Mean:
    """A method that fits in all scenes: its mean error, mean loss, and largest loss."""

    method: str
    error: float
    loss: float
    worst: float


@dataclass(frozen=True)
class Choice:
    """The answer.

    Parameters
    ----------
    renderer : str
    software : bool
        Whether it runs on the CPU.
    constraints : Constraints
    scenes : tuple of SceneChoice
    means : tuple of Mean
        Methods that fit, and have an error, in all scenes; lowest mean error first.
    chosen : tuple of str
        The first of them, and those that tie with it.
    """

    renderer: str
    software: bool
    constraints: Constraints
    scenes: tuple[SceneChoice, ...]
    means: tuple[Mean, ...]
    chosen: tuple[str, ...]

    @property
    def fits(self) -> bool:
        """Whether any method fits in any scene."""
        return any(item.fits for scene in self.scenes for item in scene.candidates)

    def misfits(self) -> dict[str, dict[str, list[str]]]:
        """Return the titles of scenes by reason, for each method that does not fit in all."""
        found: dict[str, dict[str, list[str]]] = {}
        methods = [item.cell.method for scene in self.scenes for item in scene.candidates]
        for scene in self.scenes:
            known = {item.cell.method: item.reasons for item in scene.candidates}
            for method in dict.fromkeys(methods):
                for reason in known.get(method, ("was not run",)):
                    reasons = found.setdefault(method, {})
                    reasons.setdefault(reason, []).append(scene.title)
        return found


def choose(
    folders: Sequence[Path],
    scenes: Iterable[str] = (),
    constraints: Constraints | None = None,
    renderer: str = "",
) -> Choice:
    """Return which methods fit, what each loses, and which is the best.

    Parameters
    ----------
    folders : sequence of path
        Results folders, also merged ones.
    scenes : iterable of str
        Labels of scenes, or names of scenes with any parameters and views. Default: all.
    constraints : Constraints, optional
    renderer : str
        Part of the name of the OpenGL renderer, if the results have several.

    Raises
    ------
    UsageError
        A folder holds no results, a scene or the renderer is unknown or ambiguous, or a limit of
        time is given and no cell was timed.
    """
    limits = constraints or Constraints()
    results = _load(folders, renderer)
    panels = _select(results.panels(), list(scenes))
    cells = [cell for panel in panels for cell in panel.cells]
    if limits.milliseconds is not None and all(cell.time is None for cell in cells):
        raise UsageError(
            "no cell of these scenes was timed; leave --time out, or run them with a preset that"
            " measures times"
        )
    found = tuple(_scene_choice(panel, limits) for panel in panels)
    means, chosen = _overall(found)
    return Choice(results.renderer, results.software, limits, found, means, chosen)


def _load(folders: Sequence[Path], renderer: str) -> Results:
    """Return the cells of one renderer in all folders."""
    loaded = [Results.load(part) for folder in folders for part in parts(folder)]
    names = {cell.gl.renderer for found in loaded for cell in found.records if cell.gl is not None}
    name = _renderer(sorted(names), renderer)
    cells: dict[CellKey, Record] = {}
    for found in loaded:
        for cell in found.records:
            if cell.gl is not None and cell.gl.renderer != name:
                continue
            if cell.key in cells:
                raise UsageError(
                    f"{cell.seen} {cell.method} is in {found.folder} and in an earlier folder;"
                    " give one of them"
                )
            cells[cell.key] = cell
    return Results(loaded[0].folder, tuple(cells.values()), loaded[0].facts)


def _renderer(names: Sequence[str], text: str) -> str:
    matching = [name for name in names if text.lower() in name.lower()]
    matching = [name for name in matching if name.lower() == text.lower()] or matching
    if text and not matching:
        raise unknown("renderer", text, names)
    if len(matching) > 1:
        listed = ", ".join(f"'{name}'" for name in matching)
        raise UsageError(f"times of {listed} share no axis; choose one by --renderer NAME")
    return matching[0] if matching else ""


def _select(panels: Sequence[Panel], scenes: Sequence[str]) -> list[Panel]:
    if not scenes:
        return list(panels)
    known: dict[str, list[Panel]] = {}
    for panel in panels:
        cell = panel.cells[0]
        # A label without its view stands for all views, and a bare name for all parameters, too.
        for name in {cell.seen, cell.scene, cell.scene.partition("[")[0]}:
            known.setdefault(name, []).append(panel)
    for name in scenes:
        if name not in known:
            raise unknown("scene", name, known)
    wanted = {id(panel) for name in scenes for panel in known[name]}
    return [panel for panel in panels if id(panel) in wanted]


def _scene_choice(panel: Panel, constraints: Constraints) -> SceneChoice:
    ranked = ranking(panel, METRIC)
    best = next(iter(ranked.errors.values()), None)
    items = []
    for cell in panel.cells:
        errors = ranked.errors.get(cell.method)
        loss = None if errors is None or best is None else clear_difference(errors, best)
        items.append(Candidate(cell, tuple(constraints.unmet(cell)), errors, loss))
    order = {method: place for place, method in enumerate(ranked.errors)}
    items.sort(key=lambda item: order.get(item.cell.method, len(order)))
    fitting = {item.cell.method: item.errors for item in items if item.fits and item.errors}
    chosen = Ranking(panel.truth, fitting, None).best
    return SceneChoice(panel.title, panel.truth, tuple(items), tuple(ranked.best), tuple(chosen))


def _overall(scenes: Sequence[SceneChoice]) -> tuple[tuple[Mean, ...], tuple[str, ...]]:
    """Return the means of methods that fit in all scenes, and the best of them with its ties."""
    found: dict[str, list[Candidate]] = {}
    for scene in scenes:
        for item in scene.candidates:
            if item.fits and item.errors is not None:
                found.setdefault(item.cell.method, []).append(item)
    everywhere = {method: items for method, items in found.items() if len(items) == len(scenes)}
    errors = {method: _errors(items) for method, items in everywhere.items()}
    means = sorted(
        (_mean(method, items) for method, items in everywhere.items()), key=lambda item: item.error
    )
    if not means:
        return (), ()
    first = errors[means[0].method]
    ties = [m.method for m in means if clear_mean_difference(errors[m.method], first) == 0]
    return tuple(means), tuple(ties)


def _errors(items: Iterable[Candidate]) -> list[Errors]:
    return [item.errors for item in items if item.errors is not None]


def _mean(method: str, items: Sequence[Candidate]) -> Mean:
    errors = [item.error for item in _errors(items)]
    losses = [item.loss or 0.0 for item in items]
    return Mean(method, sum(errors) / len(errors), sum(losses) / len(losses), max(losses))
