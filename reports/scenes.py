"""What each scene asks of a renderer.

Each row is a view of a scene: its picture, the number of transparent fragments at each pixel, the
share of pixels by that number, and counts. Fragments are counted at the centers of pixels, without
those that an opaque surface hides.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from oitbench.image.files import Image
from oitbench.report import Artifact, Column, Note, ReportContext, columns, figures, write_table
from oitbench.report.artifacts import Figure, Row, Value
from oitbench.report.cells import effect_labels
from oitbench.report.plates import (
    GAP,
    MARGIN,
    display,
    draw_picture,
    exposure,
    first_image,
    fitted,
    write,
)
from oitbench.results.records import Panel
from oitbench.results.schema import Record
from oitbench.results.statistics import DepthComplexity, SceneStatistics
from oitbench.results.table import flat_statistics
from oitbench.truths import EXACT

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure as Canvas

title = "Scenes"
order = 5

_ROWS = 6
"""Views on one sheet, which then fits a page."""
# Inches: a picture, the color bar with its numbers, the histogram, and the text.
_PICTURE, _BAR, _CHART, _TEXT = 2.2, 0.55, 2.0, 2.15
_HEADING, _LEAST_HEIGHT, _BELOW = 0.26, 1.6, 0.3
_LINE = 38
"""Characters of a line of text."""
_BARS = 48
"""Bars of a histogram; deeper scenes have several numbers of fragments in one."""
_LOGARITHMIC = 32
"""Scenes deeper than that have a logarithmic scale of colors."""
_NOTHING = "#e9e9e9"
_COLORS = "viridis"
_COLUMNS = (
    columns.SCENE,
    Column("view", "View", kind="text"),
    Column("size", "Size", "px", kind="text"),
    Column("objects", "Objects"),
    Column("transparent_objects", "Transparent", help="objects through which light passes"),
    Column("triangles", "Triangles"),
    Column("transparent_triangles", "Transparent", help="triangles through which light passes"),
    Column("draws", "Draws", help="draw calls if each object is drawn by itself"),
    Column("fragments", "Fragments", help="transparent, and not behind an opaque surface"),
    Column("covered_percent", "Covered", "%", help="pixels with a transparent fragment"),
    Column("mean_depth_complexity", "Mean layers", help="of covered pixels"),
    Column("median_depth_complexity", "Median", help="of covered pixels"),
    Column("max_depth_complexity", "Worst", help="the largest number at any pixel"),
    Column("effects", "Requested effects", kind="text"),
)


@dataclass(frozen=True)
class Card:
    """A view of a scene with what is known of it."""

    title: str
    record: Record
    statistics: SceneStatistics
    picture: Image | None
    counts: npt.NDArray[np.uint32] | None

    @property
    def effects(self) -> str:
        """The effects that the scene requests."""
        return effect_labels(self.record.requested_effects)

    @property
    def covered(self) -> float:
        """Percent of the pixels that have a transparent fragment."""
        return 100 * self.statistics.covered_pixels / math.prod(self.record.size)


def build(context: ReportContext) -> list[Artifact]:
    """Draw sheets of all views, and write their numbers as a table."""
    cards = list(_cards(context))
    if not cards:
        return [Note("No cell has finished yet.")]
    sheets = [cards[first : first + _ROWS] for first in range(0, len(cards), _ROWS)]
    drawn: list[Artifact] = [
        _sheet(context, sheet, number, len(sheets)) for number, sheet in enumerate(sheets, start=1)
    ]
    return [*drawn, _table(context, cards)]


def _cards(context: ReportContext) -> Iterator[Card]:
    """Yield one card for each view of a scene at each size, with all requested effects."""
    seen: set[tuple[object, ...]] = set()
    for panel in context.results.panels():
        cell = next(iter(panel.finished), None)
        place = (panel.scene, cell.view, panel.size) if cell else ()
        if cell is None or cell.outcome is None or place in seen:
            continue
        seen.add(place)
        image = _picture(context, panel)
        picture = None if image is None else display(image, exposure(panel.finished))
        counts = context.results.complexity(cell)
        yield Card(cell.seen, cell, cell.outcome.statistics, picture, counts)


def _picture(context: ReportContext, panel: Panel) -> Image | None:
    """Return the truth that ranks the scene, else exact compositing."""
    found = (first_image(context, panel, truth) for truth in (panel.truth, EXACT))
    return next((image for image in found if image is not None), None)


def _sheet(context: ReportContext, cards: Sequence[Card], number: int, count: int) -> Figure:
    boxes = [fitted(card.record.size, _PICTURE) for card in cards]
    heights = [_HEADING + max(height, _LEAST_HEIGHT) + _BELOW for _, height in boxes]
    wide = 2 * MARGIN + 2 * (_PICTURE + GAP) + _BAR + _CHART + _TEXT
    tall = 2 * MARGIN + sum(heights)
    top = MARGIN
    with figures.canvas(wide, tall, by_hand=True) as canvas:
        for card, box, height in zip(cards, boxes, heights, strict=True):
            _draw(canvas, card, box, top)
            top += height
        part = f" ({number} of {count})" if count > 1 else ""
        caption = (
            "Picture: the truth that ranks the scene, or exact compositing. Colors: transparent "
            "fragments at each pixel, on a logarithmic scale if there are more than "
            f"{_LOGARITHMIC}; gray pixels have none. Bars: pixels by that number; dotted: "
            "the median of covered pixels."
        )
        path = context.out / (f"scenes-{number}" if count > 1 else "scenes")
        return figures.save(canvas, path, title=f"Contact sheet{part}", caption=caption)


def _draw(canvas: Canvas, card: Card, box: tuple[float, float], top: float) -> None:
    """Draw one row, whose upper edge is `top` inches below that of the figure."""
    whole, tall = canvas.get_size_inches()
    width, height = box
    upper, left = top + _HEADING, MARGIN

    def axes_at(start: float, across: float, down: float) -> Axes:
        return canvas.add_axes(
            (start / whole, 1 - (upper + down) / tall, across / whole, down / tall)
        )

    write(canvas, card.title, left, upper - 0.06, 9.5, bold=True)
    if card.picture is not None:
        draw_picture(canvas, card.picture, left, upper, width)
    left += width + GAP
    complexity = card.statistics.complexity
    if card.counts is not None:
        _draw_map(axes_at(left, width, height), card.counts)
        if complexity.worst > 1:
            _draw_scale(axes_at(left + width + 0.07, 0.1, height), complexity.worst)
    left += width + GAP + _BAR
    if complexity.worst:
        # The labels of the axis below and beside the bars need room.
        across, down = _CHART - 0.55, max(height, _LEAST_HEIGHT) - 0.25
        _draw_histogram(axes_at(left + 0.3, across, down), complexity)
    write(canvas, _text(card), left + _CHART, upper, 7.5, below=True, spacing=1.35)


def _scale(worst: int) -> Normalize:
    """Return the scale of colors, from one fragment to the largest number."""
    from matplotlib.colors import LogNorm, Normalize

    return LogNorm(1, worst) if worst > _LOGARITHMIC else Normalize(1, max(2, worst))


def _draw_map(axes: Axes, counts: npt.NDArray[np.uint32]) -> None:
    import matplotlib

    colors = matplotlib.colormaps[_COLORS]
    picture = colors(_scale(int(counts.max()))(np.maximum(counts, 1)))
    picture[counts == 0] = matplotlib.colors.to_rgba(_NOTHING)
    axes.imshow(picture, interpolation="nearest", aspect="auto")
    axes.set_axis_off()


def _draw_scale(axes: Axes, worst: int) -> None:
    """Draw the color bar of a map."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colorbar import Colorbar

    ticks = [tick for tick in (1, 3, 10, 30, 100, 300, 1000, 3000) if tick < 0.8 * worst]
    if worst <= _LOGARITHMIC:
        ticks = list(range(1, worst, math.ceil(worst / 5)))
    bar = Colorbar(axes, ScalarMappable(_scale(worst), _COLORS))
    bar.set_ticks([*ticks, worst], labels=[*map(str, ticks), str(worst)])
    bar.minorticks_off()
    axes.tick_params(labelsize=6.5, length=2, pad=2)


def _draw_histogram(axes: Axes, complexity: DepthComplexity) -> None:
    from matplotlib.ticker import MaxNLocator

    pixels = sum(count for _, count in complexity.histogram)
    covered = [(depth, count) for depth, count in complexity.histogram if depth]
    step = max(1, math.ceil(complexity.worst / _BARS))
    edges = np.arange(0.5, complexity.worst + step + 0.5, step)
    depths, counts = np.array(covered or [(1, 0)], dtype=np.float64).T
    shares = np.histogram(depths, edges, weights=100 * counts / pixels)[0]
    axes.bar(edges[:-1], shares, width=0.92 * step, align="edge", color="#31688e", linewidth=0)
    if complexity.median is not None:
        axes.axvline(complexity.median, color=figures.INK, linewidth=0.9, linestyle=":")
    axes.set_xlim(edges[0], edges[-1])
    axes.xaxis.set_major_locator(MaxNLocator(5, integer=True, min_n_ticks=1))
    axes.set_xlabel("fragments at a pixel", fontsize=7)
    axes.set_ylabel("% of pixels", fontsize=7)
    axes.tick_params(labelsize=6.5, length=2)
    axes.grid(True, axis="y")


def _text(card: Card) -> str:
    found, complexity = card.statistics, card.statistics.complexity
    width, height = card.record.size
    lines = [
        f"{width} × {height} pixels",
        f"{found.triangles:,} triangles, {found.transparent_triangles:,} transparent",
        f"{found.objects:,} objects, {found.transparent_objects:,} transparent",
        f"{found.draws:,} draws",
        f"{found.fragments:,} transparent fragments",
        f"{card.covered:.1f} % of pixels covered",
    ]
    if complexity.mean is not None:
        lines.append(
            f"layers: mean {complexity.mean:.1f}, median {complexity.median:g},"
            f" worst {complexity.worst}"
        )
    return "\n".join([*lines, textwrap.fill(f"requests {card.effects or 'nothing'}", _LINE)])


def _table(context: ReportContext, cards: Sequence[Card]) -> Artifact:
    rows: list[Row] = []
    for card in cards:
        width, height = card.record.size
        values: dict[str, Value] = {
            **flat_statistics(card.statistics),
            "scene": card.record.scene,
            "view": card.record.view,
            "size": f"{width} × {height}",
            "covered_percent": card.covered,
            "effects": card.effects,
        }
        rows.append(tuple(values[column.key] for column in _COLUMNS))
    caption = "Transparent fragments are counted at the centers of pixels. Layers: covered pixels."
    return write_table(
        context.out / "scenes.csv", _COLUMNS, rows, title="Statistics", caption=caption
    )
