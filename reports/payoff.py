"""Errors of the methods that express all effects of a scene and of those that miss some.

Only scenes appear that request colored transmission, refraction, diffusion, fog or colored shadows.
Errors are those against the truth that ranks the scene. Differences that are not clearly different
from zero, by a jackknife over the parts of a reference with noise, are ties.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from oitbench.image.ties import Errors, clear_difference
from oitbench.report import Artifact, Column, Note, ReportContext, columns, fixed, write_table
from oitbench.report.artifacts import Row
from oitbench.report.cells import effect_labels
from oitbench.results.ranking import ranking
from oitbench.results.records import Panel
from oitbench.results.schema import Record

title = "Benefit of expressing more effects"
order = 25

_PHENOMENA = ("COLORED_TRANSMISSION", "REFRACTION", "DIFFUSION", "VOLUME", "COLORED_SHADOWS")


@dataclass(frozen=True)
class Scored:
    """A cell with its error against the ranking truth."""

    cell: Record
    errors: Errors

    @property
    def error(self) -> float:
        """The error itself."""
        return self.errors.error

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
    """

    scene: str
    more: Scored
    less: Scored

    @property
    def gain(self) -> float:
        """Difference of the errors; positive if expressing more effects is better."""
        return self.less.error - self.more.error

    @property
    def tied(self) -> bool:
        """Whether the errors do not clearly differ."""
        return clear_difference(self.less.errors, self.more.errors) == 0

    @property
    def sentence(self) -> str:
        """Comparison of both in words."""
        verdict = "lower" if self.gain > 0 else "no lower"
        result = f"{verdict} error with more effects"
        if self.tied:
            result = "a tie"
        return f"{self.scene}: {result}: {self.more.text}, {self.less.text}."


def build(context: ReportContext) -> list[Artifact]:
    """Write a table of all such scenes, and compare the best methods of each scene."""
    rows: list[Row] = []
    found: list[Payoff] = []
    for panel in context.results.panels():
        scored = _scored(panel, context.flip)
        requested = {name for item in scored for name in item.cell.requested_effects}
        if not requested.isdisjoint(_PHENOMENA):
            rows += _rows(context, panel, scored)
            payoff = payoff_of(panel.title, scored)
            found += [] if payoff is None else [payoff]
    if not rows:
        return [
            Note(
                "No cell with an error against its ranking truth requests any of these effects: "
                f"{effect_labels(_PHENOMENA)}."
            )
        ]
    notes = [_summary(found, context.flip_name), *(payoff.sentence for payoff in found)]
    return [_table(context, rows), *map(Note, notes)]


def payoff_of(scene: str, scored: Sequence[Scored]) -> Payoff | None:
    """Compare the cells that miss the fewest effects with all others.

    Parameters
    ----------
    scene : str
    scored : sequence of Scored
        At least one, lowest error first.

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
            return Payoff(scene, more, item)
    return None


def _summary(payoffs: Sequence[Payoff], name: str) -> str:
    """Return a sentence about the scenes in which expressing more effects is no better."""
    if not payoffs:
        return "All methods miss the same number of effects, so there is nothing to compare."
    lost = [
        f"{payoff.scene} (tied)" if payoff.tied else payoff.scene
        for payoff in payoffs
        if payoff.gain <= 0
    ]
    if not lost:
        return f"Methods that express more effects have the lower {name} in every scene."
    return f"Methods that express more effects do not have the lower {name} in {', '.join(lost)}."


def _scored(panel: Panel, flip: str) -> list[Scored]:
    """Return the cells that have an error against the ranking truth, lowest error first."""
    found = [(cell, cell.errors(panel.truth, flip)) for cell in panel.finished]
    known = [Scored(cell, errors) for cell, errors in found if errors is not None]
    return sorted(known, key=lambda item: item.error)


def _rows(context: ReportContext, panel: Panel, scored: Sequence[Scored]) -> Iterator[Row]:
    found = ranking(panel, context.flip)
    for item in scored:
        tied = item.cell.method in found.best
        mark = "best" if item is scored[0] else "tied with the best" if tied else ""
        method = item.cell.method
        yield panel.title, method, item.misses, item.error, panel.truth, found.noise_floor, mark


def _table(context: ReportContext, rows: Sequence[Row]) -> Artifact:
    flip = context.flip
    heading = (
        columns.SCENE,
        columns.METHOD,
        Column("effects", "Effects", kind="text", help="of the effects that the scene requests"),
        Column(flip, "FLIP", decimals=4, help=f"mean {flip} against the ranking truth"),
        columns.RANKING_TRUTH,
        Column(f"noise_floor.{flip}", "Noise floor", decimals=4, help="of that truth"),
        Column("mark", "Best", kind="text"),
    )
    caption = (
        f"Methods of each scene by mean {context.flip_name} against the truth that ranks them, "
        "lowest first. Below, for each scene: the best of the methods that miss the fewest "
        "effects, and the best of the others."
    )
    return write_table(
        context.out / "payoff.csv",
        heading,
        rows,
        title="Error by effects",
        caption=caption,
    )
