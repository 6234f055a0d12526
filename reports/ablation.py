"""Every picture against the same picture with one effect left out.

The cost of an effect is the frame time, memory and traffic that leaving it out saves, including
shared shading such as shadow maps. Its gain is the increase of the error when it is left out,
against the truth that ranks the scene with all effects. A gain that is not clearly different from
zero, by a jackknife over the parts of a reference with noise, is a tie.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from oitbench.effects import Effect, names
from oitbench.report import (
    Artifact,
    Column,
    Figure,
    Note,
    ReportContext,
    columns,
    figures,
    labels,
    palette,
    times,
    write_table,
)
from oitbench.report.artifacts import Row, Value
from oitbench.report.cells import effect_label, effect_labels, most_complete
from oitbench.report.effect_costs import EffectCost, effect_costs
from oitbench.results.records import Panel
from oitbench.results.table import MEBIBYTE
from oitbench.results.times import Interval

if TYPE_CHECKING:
    from matplotlib.axes import Axes

title = "Cost and gain of each effect"
order = 35

_COLUMNS_OF_AXES = 3
# Inches of the axes of one scene with their labels.
_WIDTH, _HEIGHT = 3.13, 2.9
# Room for labels beside the outermost marks, relative to the range of the marks.
_ROOM = 0.35


@dataclass(frozen=True)
class Mark:
    """The mark of an effect; `chosen` marks are filled and have a name."""

    cost: EffectCost
    time: Interval
    gain: float
    color: str
    chosen: bool = False

    @property
    def place(self) -> tuple[float, float]:
        """Cost in milliseconds, and gain."""
        return self.time.median, self.gain


def build(context: ReportContext) -> list[Artifact]:
    """Draw gain against cost, and list both."""
    flip = context.flip
    costs = [(panel, list(effect_costs(panel, flip))) for panel in context.results.panels()]
    rows = [row for panel, found in costs for row in _rows(panel, found, flip)]
    if not rows:
        return [
            Note("No cell leaves an effect out; 'oitbench run --effects each' adds such cells.")
        ]
    marks = [(panel, shown) for panel, found in costs if (shown := _marks(found, flip))]
    drawn: Artifact = Note("No effect has both a cost in frame time and a gain yet.")
    if marks:
        drawn = _figure(context, marks)
    return [drawn, _table(context, rows)]


def _marks(costs: Sequence[EffectCost], flip: str) -> list[Mark]:
    """Return the effects with a cost in time and a gain, those of the chosen method last."""
    colors = palette.categories(map(effect_label, names(~Effect.NONE)))
    marks = [
        Mark(cost, cost.time, cost.gain, colors.get(cost.effect, figures.QUIET))
        for cost in costs
        if cost.time is not None and cost.gain is not None
    ]
    chosen = most_complete((mark.cost.ablation.complete for mark in marks), flip)
    marks = [replace(mark, chosen=mark.cost.ablation.complete is chosen) for mark in marks]
    return sorted(marks, key=lambda mark: mark.chosen)


def _figure(context: ReportContext, marks: Sequence[tuple[Panel, Sequence[Mark]]]) -> Figure:
    across = min(_COLUMNS_OF_AXES, len(marks))
    down = math.ceil(len(marks) / across)
    with figures.canvas(_WIDTH * across, _HEIGHT * down) as figure:
        grid = list(figure.subplots(down, across, squeeze=False).flat)
        for axes in grid[len(marks) :]:
            axes.remove()
        for axes, (panel, shown) in zip(grid, marks, strict=False):
            _draw(axes, shown)
            axes.set_title(panel.title)
            axes.set_xlabel("cost, ms per frame, lower is better")
            axes.set_ylabel(f"gain in {context.flip_name}, higher is better")
        figures.share_rows(grid[: len(marks)], across)
        # Labels need the final layout.
        for axes, (_, shown) in zip(grid, marks, strict=False):
            _add_labels(axes, shown)
        chosen = (mark.cost.method for _, shown in marks for mark in shown if mark.chosen)
        floors = [mark.cost.noise_floor for _, shown in marks for mark in shown]
        ties = "Shaded: gains within the noise floor. " if any(floors) else ""
        methods = ", ".join(dict.fromkeys(chosen))
        caption = (
            "Each mark is one effect. Cost: the frame time in ms that leaving the effect out saves,"
            f" with its interval. Gain: the increase of the mean {context.flip_name} "
            "against the ranking truth when the effect is left out; above zero, the picture is "
            f"better with the effect. {ties}Filled marks with names: the method that misses the "
            f"fewest effects of a scene ({methods}); hollow marks: the other methods."
            + times.explain(mark.cost.ablation.complete for _, shown in marks for mark in shown)
        )
        return figures.save(
            figure, context.out / "ablation", title="Gain and cost", caption=caption
        )


def _draw(axes: Axes, marks: Sequence[Mark]) -> None:
    axes.grid(True, axis="both")
    axes.axhline(0, color=figures.QUIET, linewidth=0.8, zorder=1.5)
    axes.axvline(0, color=figures.QUIET, linewidth=0.8, zorder=1.5)
    for mark in marks:
        figures.add_mark(
            axes,
            mark.place,
            mark.time.ends if mark.chosen else None,
            marker="o",
            size=7 if mark.chosen else 5,
            color=mark.color,
            fill=mark.color if mark.chosen else "none",
            edge="white" if mark.chosen else mark.color,
            edge_width=0.6 if mark.chosen else 0.9,
        )
    floor = max(mark.cost.noise_floor or 0.0 for mark in marks)
    if floor:
        text = f"shaded: within the noise floor of {floor:.2g}"
        figures.add_band(axes, -floor, floor, text, at_top=False)
    _set_limits(axes, marks)


def _set_limits(axes: Axes, marks: Sequence[Mark]) -> None:
    """Include all marks and zero, with room for labels."""
    ends = [end for mark in marks for end in mark.time.span]
    gains = [mark.gain for mark in marks]
    left, right = min(0.0, *ends), max(0.0, *ends)
    bottom, top = min(0.0, *gains), max(0.0, *gains)
    width, height = right - left or 1.0, top - bottom or 1.0
    axes.set_xlim(left - _ROOM / 2 * width, right + _ROOM * width)
    axes.set_ylim(bottom - _ROOM * height, top + _ROOM / 2 * height)


def _add_labels(axes: Axes, marks: Sequence[Mark]) -> None:
    written = [
        labels.Label(
            *mark.place,
            times.signed(mark.cost.effect, mark.cost.disturbed),
            palette.ink(mark.color),
            *mark.time.span,
            bold=mark.cost.verdict != "tie",
        )
        for mark in marks
        if mark.chosen
    ]
    # Labels keep away from hollow marks, too.
    others = [(mark.time.span, (mark.gain,) * 2) for mark in marks if not mark.chosen]
    labels.place(axes, written, lines=others)


def _rows(panel: Panel, costs: Sequence[EffectCost], flip: str) -> Iterator[Row]:
    for cost in costs:
        ablation = cost.ablation
        yield (
            panel.title,
            cost.method,
            cost.effect,
            effect_labels(ablation.implied),
            *_saved(cost),
            cost.memory / MEBIBYTE,
            cost.traffic / MEBIBYTE,
            ablation.complete.metric(ablation.complete.ranking_truth, flip),
            ablation.reduced.metric(ablation.reduced.whole_truth, flip),
            cost.gain,
            ablation.complete.ranking_truth,
            cost.noise_floor,
            cost.verdict,
        )


def _saved(cost: EffectCost) -> list[Value]:
    """Return the saved time, its interval, and whether other processes disturbed it."""
    saved = cost.time
    median, low, high = (saved.median, saved.low, saved.high) if saved else (None, None, None)
    numbers = {"saved_ms": median, "saved_ms_low": low, "saved_ms_high": high}
    return list(times.marked(numbers, cost.disturbed).values())


def _table(context: ReportContext, rows: Sequence[Row]) -> Artifact:
    flip = context.flip
    traced = f"mean {flip} against the truth that ranks the scene"
    heading = (
        columns.SCENE,
        columns.METHOD,
        Column("left_out", "Left out", kind="text"),
        Column("also_left_out", "Also left out", kind="text", help="depends on the effect"),
        Column("saved_ms", "Saves", "ms", help="median difference of the frame times"),
        Column("saved_ms_low", "Low", "ms", help="lower end of its interval"),
        Column("saved_ms_high", "High", "ms", help="upper end of its interval"),
        columns.DISTURBED,
        Column("saved_mib", "Memory", "MiB", help="saved memory, shared shading included"),
        Column("saved_traffic_mib", "Traffic", "MiB", help="saved per frame; with shared shading"),
        Column(f"with.{flip}", "FLIP with", decimals=4, help=f"{traced}, with the effect"),
        Column(f"without.{flip}", "FLIP without", decimals=4, help=f"{traced}, without the effect"),
        Column(f"gain.{flip}", "Gain", decimals=4, help="FLIP without the effect minus FLIP with"),
        columns.RANKING_TRUTH,
        Column(f"noise_floor.{flip}", "Noise floor", decimals=4, help="of that truth"),
        Column("verdict", "With the effect", kind="text"),
    )
    caption = (
        "Savings in frame time, memory and traffic when one effect is left out, and the gain in "
        f"{context.flip_name} against the truth that ranks the scene. Negative savings are costs; "
        "small differences in time are noise, as their intervals show."
        + times.explain(context.results.records)
    )
    return write_table(
        context.out / "ablation.csv",
        heading,
        rows,
        title="Cost and gain by effect",
        caption=caption,
    )
