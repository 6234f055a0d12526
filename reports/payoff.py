"""Path-traced error of the methods that express all effects of a scene and of those that miss some.

Only scenes appear that request colored transmission, refraction, diffusion or colored shadows.
Differences within the noise floor of the path-traced reference are ties.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from oitbench.report import Artifact, Column, Note, ReportContext, columns, fixed, write_table
from oitbench.report.artifacts import Row
from oitbench.report.cells import effect_labels, largest_noise_floor
from oitbench.results.records import Panel
from oitbench.results.schema import PATH_TRACED, Record

title = "Benefit of expressing more effects"
order = 25

_PHENOMENA = ("COLORED_TRANSMISSION", "REFRACTION", "DIFFUSION", "COLORED_SHADOWS")


@dataclass(frozen=True)
class Scored:
    """A cell with its path-traced error."""

    cell: Record
    error: float

    @property
    def misses(self) -> str:
        """The missing effects in words."""
        missing = self.cell.missing_effects
        return f"misses {effect_labels(missing)}" if missing else "expresses all"

    @property
    def text(self) -> str:
        """Error, method and missing effects in words."""
        return f"{fixed(self.error, 4)} for {self.cell.method} ({self.misses})"


@dataclass(frozen=True)
class Payoff:
    """The best of the methods that miss the fewest effects against the best of the others.

    Parameters
    ----------
    scene : str
    more, less : Scored
        The method that expresses more effects, and the other one.
    noise_floor : float
        Of the path-traced reference.
    """

    scene: str
    more: Scored
    less: Scored
    noise_floor: float

    @property
    def gain(self) -> float:
        """Difference of the errors; positive if expressing more effects is better."""
        return self.less.error - self.more.error

    @property
    def tied(self) -> bool:
        """Whether the errors differ by no more than the noise floor."""
        return abs(self.gain) <= self.noise_floor

    @property
    def sentence(self) -> str:
        """Comparison of both in words."""
        verdict = "lower" if self.gain > 0 else "no lower"
        result = f"{verdict} error with more effects"
        if self.tied:
            result = f"a tie within the noise floor of {fixed(self.noise_floor, 4)}"
        return f"{self.scene}: {result}: {self.more.text}, {self.less.text}."


def build(context: ReportContext) -> list[Artifact]:
    """Write a table of all such scenes, and compare the best methods of each scene."""
    rows: list[Row] = []
    found: list[Payoff] = []
    for panel in context.results.panels():
        scored = _scored(panel, context.flip)
        requested = {name for item in scored for name in item.cell.requested_effects}
        if not requested.isdisjoint(_PHENOMENA):
            floor = largest_noise_floor(panel.finished, context.flip)
            rows += _rows(panel, scored, floor)
            payoff = payoff_of(panel.title, scored, floor or 0.0)
            found += [] if payoff is None else [payoff]
    if not rows:
        return [
            Note(
                "No cell with a path-traced error requests any of these effects: "
                f"{effect_labels(_PHENOMENA)}."
            )
        ]
    notes = [_summary(found, context.flip), *(payoff.sentence for payoff in found)]
    return [_table(context, rows), *map(Note, notes)]


def payoff_of(scene: str, scored: Sequence[Scored], noise_floor: float) -> Payoff | None:
    """Compare the cells that miss the fewest effects with all others.

    Parameters
    ----------
    scene : str
    scored : sequence of Scored
        At least one, lowest error first.
    noise_floor : float

    Returns
    -------
    Payoff or None
        None if all cells miss the same number of effects.
    """
    counts = [len(item.cell.missing_effects) for item in scored]
    fewest = min(counts)
    more = next(item for item, count in zip(scored, counts, strict=True) if count == fewest)
    for item, count in zip(scored, counts, strict=True):
        if count > fewest:
            return Payoff(scene, more, item, noise_floor)
    return None


def _summary(payoffs: Sequence[Payoff], flip: str) -> str:
    """Return a sentence about the scenes in which expressing more effects is no better."""
    if not payoffs:
        return "All methods miss the same number of effects, so there is nothing to compare."
    lost = [
        f"{payoff.scene} (tied)" if payoff.tied else payoff.scene
        for payoff in payoffs
        if payoff.gain <= 0
    ]
    if not lost:
        return f"Methods that express more effects have the lower {flip} in every scene."
    return f"Methods that express more effects do not have the lower {flip} in {', '.join(lost)}."


def _scored(panel: Panel, flip: str) -> list[Scored]:
    """Return the cells that have a path-traced error, lowest error first."""
    errors = [(cell, cell.metric(PATH_TRACED, flip)) for cell in panel.finished]
    known = [Scored(cell, error) for cell, error in errors if error is not None]
    return sorted(known, key=lambda item: item.error)


def _rows(panel: Panel, scored: Sequence[Scored], floor: float | None) -> Iterator[Row]:
    for item in scored:
        tied = item.error - scored[0].error <= (floor or 0.0)
        mark = "best" if item is scored[0] else "tied with the best" if tied else ""
        yield panel.title, item.cell.method, item.misses, item.error, floor, mark


def _table(context: ReportContext, rows: Sequence[Row]) -> Artifact:
    flip = context.flip
    heading = (
        columns.SCENE,
        columns.METHOD,
        Column("effects", "Effects", kind="text", help="of the effects that the scene requests"),
        columns.path_traced_error(flip),
        columns.noise_floor(flip),
        Column("mark", "Best", kind="text"),
    )
    caption = (
        f"Methods of each scene by mean {flip} against path tracing, lowest first. Below, for each "
        "scene: the best of the methods that miss the fewest effects, and the best of the others."
    )
    return write_table(
        context.out / "payoff.csv",
        heading,
        rows,
        title="Path-traced error by effects",
        caption=caption,
    )
