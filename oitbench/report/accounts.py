"""Bytes or times of methods as stacked bars and as a table."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import accumulate, pairwise
from typing import TYPE_CHECKING

from oitbench.report import figures, palette
from oitbench.report.artifacts import Artifact, Column, Figure, Note, Row, write_table
from oitbench.report.cells import outcomes
from oitbench.report.context import ReportContext
from oitbench.results.records import Panel
from oitbench.results.schema import Outcome, Record

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# A block shows its name if it has at least this share of the axis for each letter.
_LETTER_SHARE = 0.0092
# Inches: a bar with its gap, the axis below, and the legend.
_ROW_HEIGHT = 0.235
_MARGIN = 0.75
_LEGEND = 0.25
_BAR_HEIGHT = 0.72
SHARED = "#b5b5b5"
"""Color of what all methods share."""
_SHARED_NAME = "shared by all methods"
_SHARED_NOTE = "Below the line: work that all methods share, such as shadow maps."
_Points = tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Block:
    """A named block of a bar; `parts` are pairs of a color and a value."""

    name: str
    parts: tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class Bar:
    """The bar of one cell; `total` is the text at its end."""

    blocks: tuple[Block, ...]
    total: str

    @property
    def length(self) -> float:
        """Sum of all parts."""
        return sum(value for block in self.blocks for _, value in block.parts)


@dataclass(frozen=True)
class Account:
    """The way in which a report shows an account of bytes or of times.

    Parameters
    ----------
    name : str
        Stem of the names of all files.
    axis : str
        Label of the axis, with the unit.
    caption : str
        Of the figures.
    room : float
        Length of the axis relative to the longest bar; the rest is room for the totals.
    columns : tuple of Column
    table_title, table_caption : str
    bar : callable
        Returns the bar of a finished cell.
    shared : callable
        Returns the bar of what all methods of a panel share, as one of its outcomes has it.
    rows : callable
        Returns the rows of a finished cell in the table.
    legend : mapping of str to str
        Color of each name.
    """

    name: str
    axis: str
    caption: str
    room: float
    columns: tuple[Column, ...]
    table_title: str
    table_caption: str
    bar: Callable[[ReportContext, Record, Outcome], Bar]
    shared: Callable[[Panel, Outcome], Bar]
    rows: Callable[[Panel, Record, Outcome], Iterable[Row]]
    legend: Mapping[str, str] = field(default_factory=dict)


def build(context: ReportContext, account: Account) -> list[Artifact]:
    """Draw a figure per scene, and list all terms in a table."""
    drawn: list[Artifact] = []
    rows: list[Row] = []
    for panel in context.results.panels():
        finished = outcomes(panel)
        if not finished:
            drawn.append(Note(f"{panel.title}: no method has finished yet."))
            continue
        bars = {cell.method: account.bar(context, cell, outcome) for cell, outcome in finished}
        shared = account.shared(panel, finished[0][1])
        drawn.append(_figure(context, account, panel, bars, shared))
        rows += [row for cell, outcome in finished for row in account.rows(panel, cell, outcome)]
    if rows:
        drawn.append(
            write_table(
                context.out / f"{account.name}.csv",
                account.columns,
                rows,
                title=account.table_title,
                caption=account.table_caption,
                collapsed=True,
            )
        )
    return drawn


def _figure(
    context: ReportContext, account: Account, panel: Panel, bars: Mapping[str, Bar], shared: Bar
) -> Figure:
    """Draw the bars of methods, and apart from them that of what all share."""
    longest = max(bar.length for bar in bars.values()) or shared.length or 1.0
    length = account.room * longest
    height = _MARGIN + _ROW_HEIGHT * (len(bars) + 1.5) + (_LEGEND if account.legend else 0)
    with figures.canvas(figures.WIDTH, height) as figure:
        axes = figure.subplots()
        axes.grid(True, axis="x")
        axes.set_xlim(0, length)
        last = len(bars) + 0.5
        shapes = [_lay_out(axes, row, bar, length) for row, bar in enumerate(bars.values())]
        broken = shared.length > longest
        lay_out = _lay_out_broken if broken else _lay_out
        shapes.append(lay_out(axes, last, shared, longest if broken else length))
        _add_shapes(axes, shapes)
        axes.axhline(len(bars) - 0.25, color=figures.QUIET, linewidth=0.6)
        axes.set_yticks([*range(len(bars)), last], [*bars, _SHARED_NAME])
        axes.set_ylim(last + 0.6, -0.6)
        axes.set_xlabel(account.axis)
        # The labels of methods need neither tick marks nor a line.
        axes.tick_params(axis="y", length=0)
        axes.spines["left"].set_visible(False)
        used = {color for bar in shapes for color in bar.colors}
        shown = {name: color for name, color in account.legend.items() if color in used}
        if shown:
            _add_legend(axes, shown)
        caption = f"{account.caption} {_SHARED_NOTE}"
        if broken:
            caption += " The break marks a bar that is longer than the axis."
        path = context.out / f"{account.name}-{panel.slug}"
        return figures.save(figure, path, title=panel.title, caption=caption)


def _add_legend(axes: Axes, colors: Mapping[str, str]) -> None:
    from matplotlib.patches import Patch

    axes.figure.legend(
        handles=[Patch(color=color, label=name) for name, color in colors.items()],
        loc="outside upper left",
        ncols=len(colors),
        handlelength=1,
        columnspacing=1.6,
    )


@dataclass(frozen=True)
class _Shapes:
    """The boxes of a bar with their colors, and the white lines between its blocks."""

    boxes: tuple[_Points, ...]
    colors: tuple[str, ...]
    separators: tuple[_Points, ...]


def _add_shapes(axes: Axes, bars: Sequence[_Shapes]) -> None:
    """Draw the boxes of all bars, as one collection, which is much faster than rectangles."""
    from matplotlib.collections import LineCollection, PolyCollection

    boxes = [box for bar in bars for box in bar.boxes]
    colors = [color for bar in bars for color in bar.colors]
    separators = [line for bar in bars for line in bar.separators]
    axes.add_collection(PolyCollection(boxes, facecolors=colors, edgecolors="none"))
    axes.add_collection(LineCollection(separators, colors="white", linewidths=1.2, zorder=2))


def _lay_out(axes: Axes, row: float, bar: Bar, length: float) -> _Shapes:
    """Write the names of the blocks of a bar, and the total at its end; return its shapes."""
    parts = [part for block in bar.blocks for part in block.parts]
    ends = [0.0, *accumulate(value for _, value in parts)]
    low, high = row - _BAR_HEIGHT / 2, row + _BAR_HEIGHT / 2
    boxes = tuple(((a, low), (b, low), (b, high), (a, high)) for a, b in pairwise(ends))
    first, separators = 0, []
    for block in bar.blocks:
        _name(axes, row, block, ends[first:], length)
        first += len(block.parts)
        separators.append(((ends[first], low), (ends[first], high)))
    axes.annotate(
        bar.total,
        (ends[-1], row),
        xytext=(4, 0),
        textcoords="offset points",
        fontsize=7.5,
        verticalalignment="center_baseline",
        in_layout=False,
    )
    return _Shapes(boxes, tuple(color for color, _ in parts), tuple(separators))


def _lay_out_broken(axes: Axes, row: float, bar: Bar, end: float) -> _Shapes:
    """Draw a bar that is longer than all others up to `end`, with a visible break."""
    whole, half = Bar((Block("", ((SHARED, end),)),), bar.total), _BAR_HEIGHT / 2 + 0.12
    shapes = _lay_out(axes, row, whole, end)
    for left in (0.9, 0.915):
        axes.plot(
            [left * end, (left + 0.01) * end],
            [row + half, row - half],
            color="white",
            linewidth=2.5,
            zorder=3,
        )
    return shapes


def _name(axes: Axes, row: float, block: Block, ends: Sequence[float], length: float) -> None:
    """Write the name of a block into its widest part, if it fits; `ends` are those of its parts."""
    widest = max(range(len(block.parts)), key=lambda place: block.parts[place][1])
    color, value = block.parts[widest]
    if not block.name or value <= _LETTER_SHARE * length * (len(block.name) + 2):
        return
    axes.text(
        ends[widest] + value / 2,
        row,
        block.name,
        fontsize=6.5,
        color="white" if palette.is_dark(color) else figures.INK,
        horizontalalignment="center",
        verticalalignment="center_baseline",
        in_layout=False,
    )
