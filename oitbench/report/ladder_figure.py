"""Ladders as a figure: for each scene, distances of its methods to truths, and their causes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from oitbench.method.families import FAMILIES
from oitbench.parameters import natural
from oitbench.report import error_axis, figures, palette
from oitbench.report.artifacts import Figure
from oitbench.report.context import ReportContext
from oitbench.report.ladder import TERMS, Ladder, Split
from oitbench.truths import FULL, MATCHED, TRUTHS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

SCENES = 4
"""Scenes in one figure."""
_ACROSS = 2
# Inches: a row, and the room above and below all rows of a scene, and for the legend.
_ROW, _AROUND, _LEGEND = 0.135, 0.62, 0.55
_LEAST_ROWS = 7
_BANDS = {MATCHED: 0.13, FULL: 0.06}
# Points.
_BAR = 6.4
# Ends of the axis of shares, at most; longer bars end in an arrow.
_LEAST, _MOST = -2.0, 3.0


def draw(context: ReportContext, ladders: Sequence[Ladder], path: Path, title: str) -> Figure:
    """Draw at most `SCENES` scenes.

    Parameters
    ----------
    context : ReportContext
    ladders : sequence of Ladder
    path : Path
        File without its suffix.
    title : str
    """
    rows = _methods(context, ladders)
    down = math.ceil(len(ladders) / _ACROSS)
    across = min(_ACROSS, len(ladders))
    height = down * (_AROUND + _ROW * max(_LEAST_ROWS, len(rows))) + _LEGEND
    with figures.canvas(figures.WIDTH, height) as figure:
        grid = figure.subplots(down, 2 * across, squeeze=False).reshape(-1, 2)
        highest = max((d for ladder in ladders for d in _distances(ladder)), default=0.0)
        ends = _ends([split for ladder in ladders for split in ladder.splits.values()])
        for (left, right), ladder in zip(grid, ladders, strict=False):
            _draw_distances(left, ladder, rows, highest)
            _draw_shares(right, ladder, rows, ends)
        for left, right in grid[len(ladders) :]:
            left.set_visible(False)
            right.set_visible(False)
        for left, _ in grid[::across]:
            _label_rows(context, left, rows)
        _add_legend(figure, [truth for truth in TRUTHS if any(truth in x.truths for x in ladders)])
        return figures.save(figure, path, title=title, caption=CAPTION)


CAPTION = (
    "Left of each pair: mean FLIP of a method against each truth. FLIP is no sum of parts, so each "
    "distance stands for itself; gray bands are what the noise of the traced truths alone causes. "
    "Right: the mean squared error of linear radiance against the last truth, without its noise, "
    "as the sum of its parts: squares to the right, and cross terms, which are negative where "
    "errors cancel. The vertical line is 100 %. No bar: the error is below half a step of 8 bits, "
    "or below the noise."
)


def _methods(context: ReportContext, ladders: Sequence[Ladder]) -> list[str]:
    """Return all methods by family."""
    labels = {cell.method: cell.name for ladder in ladders for cell in ladder.panel.finished}
    order = list(FAMILIES)

    def place(label: str) -> tuple[int, object]:
        family = context.families.get(labels[label], "")
        return order.index(family) if family in order else len(order), natural(label)

    return sorted(labels, key=place)


def _distances(ladder: Ladder) -> list[float]:
    found = [ladder.distance(cell, t) for cell in ladder.panel.finished for t in ladder.truths]
    return [distance for distance in found if distance is not None]


def _ends(splits: Sequence[Split]) -> tuple[float, float]:
    """Return the ends of the axis of shares."""
    lows = [sum(min(0.0, share) for share in split.shares.values()) for split in splits]
    highs = [sum(max(0.0, share) for share in split.shares.values()) for split in splits]
    return max(_LEAST, min([-0.1, *lows])), min(_MOST, max([1.1, *highs]))


def _draw_distances(axes: Axes, ladder: Ladder, rows: Sequence[str], highest: float) -> None:
    error_axis.set_scale(axes, highest, "x")
    error_axis.draw_break(axes, "x")
    _set_rows(axes, rows)
    for truth, strength in _BANDS.items():
        floor = ladder.floor(truth)
        if floor:
            end = error_axis.place(floor)
            axes.axvspan(axes.get_xlim()[0], end, color="#000000", alpha=strength, linewidth=0)
    found = {truth: _known(ladder, truth, rows) for truth in ladder.truths}
    reached = {row: [d[row] for d in found.values() if row in d] for row in range(len(rows))}
    spans = {row: (min(ends), max(ends)) for row, ends in reached.items() if ends}
    colors = [ladder.context.style(rows[row]).color for row in spans]
    lows, highs = zip(*spans.values(), strict=True) if spans else ((), ())
    axes.hlines([*spans], lows, highs, colors=colors, linewidth=1)
    for truth, known in found.items():
        axes.plot([*known.values()], [*known], **figures.truth_mark(truth), zorder=3)
    axes.set_title(ladder.panel.title, fontsize=8.5)
    axes.set_xlabel(f"{ladder.context.flip_name} error, lower is better", fontsize=7.5)


def _known(ladder: Ladder, truth: str, rows: Sequence[str]) -> dict[int, float]:
    """Return the places of all distances to a truth on the axis of errors, by row."""
    found = {rows.index(c.method): ladder.distance(c, truth) for c in ladder.panel.finished}
    return {
        row: error_axis.place(distance) for row, distance in found.items() if distance is not None
    }


def _draw_shares(
    axes: Axes, ladder: Ladder, rows: Sequence[str], ends: tuple[float, float]
) -> None:
    _set_rows(axes, rows)
    axes.set_xlim(*ends)
    axes.xaxis.set_major_formatter(lambda share, place: _hundredths(share))
    axes.axvline(0, color=figures.QUIET, linewidth=0.8)
    axes.axvline(1, color=figures.INK, linewidth=0.8)
    if not ladder.splits:
        axes.text(
            0.5, 0.5, "no picture of all truths", transform=axes.transAxes, fontsize=7.5,
            color=figures.QUIET, horizontalalignment="center",
        )  # fmt: skip
    known = {rows.index(m): split for m, split in ladder.splits.items() if split.shares}
    _draw_bars(axes, known, ends)
    axes.set_xlabel(f"% of the squared error to {TRUTHS[ladder.last]}", fontsize=7.5)


def _draw_bars(axes: Axes, splits: Mapping[int, Split], ends: tuple[float, float]) -> None:
    """Stack positive parts to the right of zero, and negative ones to the left, by row."""
    low, high = dict.fromkeys(splits, 0.0), dict.fromkeys(splits, 0.0)
    for name, color in palette.categories(TERMS).items():
        shares = {row: split.shares[name] for row, split in splits.items()}
        starts = [high[row] if share > 0 else low[row] for row, share in shares.items()]
        stops = [start + share for start, share in zip(starts, shares.values(), strict=True)]
        axes.hlines([*shares], starts, stops, color=color, linewidth=_BAR, capstyle="butt")
        for row, share in shares.items():
            low[row], high[row] = low[row] + min(0.0, share), high[row] + max(0.0, share)
    for row in splits:
        if low[row] < ends[0]:
            _write(axes, ends[0], row, f"◂ {_percent(low[row])}", "left")
        if high[row] > ends[1]:
            _write(axes, ends[1], row, f"{_percent(high[row])} ▸", "right")


def _write(axes: Axes, x: float, row: int, text: str, side: str) -> None:
    """Write the end of a bar that is longer than the axis."""
    axes.text(
        x, row, text, fontsize=5.5, color="white", horizontalalignment=side,
        verticalalignment="center_baseline",
    )  # fmt: skip


def _percent(share: float) -> str:
    return f"{_hundredths(share)} %"


def _hundredths(share: float) -> str:
    return f"{100 * share:.0f}".replace("-", "−")


def _set_rows(axes: Axes, rows: Sequence[str]) -> None:
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.set_yticks([])
    axes.tick_params(labelsize=6.5)
    axes.spines["left"].set_visible(False)
    axes.grid(True, axis="x", linewidth=0.4)


def _label_rows(context: ReportContext, axes: Axes, rows: Sequence[str]) -> None:
    """Write the names of methods in the colors of their families."""
    axes.set_yticks(range(len(rows)), list(rows))
    axes.tick_params(axis="y", length=0)
    for text, label in zip(axes.get_yticklabels(), rows, strict=True):
        text.set_color(palette.ink(context.style(label).color))


def _add_legend(figure: Canvas, truths: Sequence[str]) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Line2D | Patch] = []
    handles += [
        Line2D([], [], **figures.truth_mark(truth), label=f"to {TRUTHS[truth]}") for truth in truths
    ]
    handles += [
        Patch(color="#000000", alpha=_BANDS[truth], linewidth=0, label=f"noise of {TRUTHS[truth]}")
        for truth in truths
        if truth in _BANDS
    ]
    colors = palette.categories(TERMS)
    handles += [Patch(color=colors[name], label=words) for name, words in TERMS.items()]
    figure.legend(handles=handles, loc="outside upper center", ncols=5, fontsize=7.5)
