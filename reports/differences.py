"""All methods beside exact compositing, with their differences from it times eight.

A row of pictures for each scene, and below each picture |method − exact| of the displayed colors,
enhanced by a factor of eight and clipped. The number is mean FLIP against exact compositing. Where
there are many columns, each method has one; the viewer shows all.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from oitbench.image.files import Image
from oitbench.papers.plates import FACTOR, difference
from oitbench.report import Artifact, Figure, Note, ReportContext, figures, fixed, plates
from oitbench.results.pictures import PICTURE, REDUCED, REDUCED_EXACT
from oitbench.results.records import Panel
from oitbench.results.schema import Record
from oitbench.truths import EXACT

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

title = "Differences from exact compositing, times eight"
order = 31

_ROWS = 4
"""Scenes in one figure."""
_WIDTH, _WIDEST = 13.0, 2.4
"""Inches: of all pictures of a row, and the most for one."""
MOST = 16
"""Columns beyond which each method has one alone."""
_LABEL, _TITLE, _NAME, _GAP = 0.4, 0.18, 0.32, 0.06
"""Inches: room above the first row, for the name of a scene, for that and numbers, and between
pictures."""
_SMALL, _POINTS = 5, 6
"""Sizes of labels and of numbers."""
_LETTERS = 24
"""Letters of a label for each inch."""


@dataclass(frozen=True)
class _Row:
    """A scene: its panel, its exact picture, and the methods' cells by label.

    `kind` is that of pictures of its size.
    """

    panel: Panel
    exact: Image
    kind: str
    cells: dict[str, Record]


def build(context: ReportContext) -> list[Artifact]:
    """Draw one figure for every four scenes."""
    rows = [*_rows(context)]
    if not rows:
        return [Note("No scene has a picture of exact compositing yet.")]
    groups = [rows[start : start + _ROWS] for start in range(0, len(rows), _ROWS)]
    labels = columns(context, [*dict.fromkeys(label for row in rows for label in row.cells)])
    return [_figure(context, group, labels, number) for number, group in enumerate(groups, 1)]


def _rows(context: ReportContext) -> Iterator[_Row]:
    for panel in context.results.panels():
        # The smaller pictures have more pixels than a figure has dots.
        for kind, truth in ((REDUCED, REDUCED_EXACT), (PICTURE, EXACT)):
            exact = plates.first_image(context, panel, truth)
            if exact is not None:
                cells = {cell.method: cell for cell in panel.finished}
                yield _Row(panel, exact, kind, cells)
                break


def columns(context: ReportContext, labels: Sequence[str]) -> list[str]:
    """Return the labels that are drawn: if there are many, those with defaults, or the first."""
    if len(labels) <= MOST:
        return [*labels]
    chosen: dict[str, str] = {}
    for label in labels:
        name = context.names[label]
        if label == name or name not in chosen:
            chosen[name] = label
    return [label for label in labels if label in chosen.values()]


def _figure(
    context: ReportContext, rows: Sequence[_Row], labels: Sequence[str], number: int
) -> Figure:
    """Draw the rows of some scenes; a method that lacks one leaves a gap there."""
    width = min(_WIDEST, _WIDTH / (len(labels) + 1) - _GAP)
    sizes = [plates.fitted(row.panel.size, width) for row in rows]
    heights = [_NAME + 2 * tall + 2 * _GAP for _, tall in sizes]
    across = (width + _GAP) * (len(labels) + 1) + 2 * plates.MARGIN
    with figures.canvas(across, sum(heights) + _LABEL + plates.MARGIN, by_hand=True) as canvas:
        top = _LABEL
        for place, label in enumerate(["exact", *labels]):
            left = plates.MARGIN + place * (width + _GAP)
            heading = "\n".join(plates.lines_of(label, int(_LETTERS * width)))
            plates.write(canvas, heading, left, top - 0.03, _SMALL)
        for row, (_, tall), height in zip(rows, sizes, heights, strict=True):
            heading = row.panel.title
            plates.write(canvas, heading, plates.MARGIN, top + _TITLE - 0.03, 7.5, bold=True)
            _draw_row(context, canvas, row, labels, (top + _NAME, width, tall))
            top += height
        caption = (
            "Upper pictures: the image at the exposure of the scene. Lower pictures: its "
            f"difference from exact compositing, times {FACTOR}. Numbers: mean {context.flip_name}."
        )
        path = context.out / f"differences-{number}"
        return figures.save(canvas, path, title=title, caption=caption)


def _draw_row(
    context: ReportContext,
    canvas: Canvas,
    row: _Row,
    labels: Sequence[str],
    box: tuple[float, float, float],
) -> None:
    """Draw the pictures of a scene from `box`: top, width and height of the first, in inches."""
    top, width, tall = box
    stops = plates.exposure(row.panel.finished)
    exact = plates.display(row.exact, stops)
    plates.draw_picture(canvas, exact, plates.MARGIN, top, width)
    for place, label in enumerate(labels, 1):
        left = plates.MARGIN + place * (width + _GAP)
        picture = context.results.image(row.cells[label], row.kind) if label in row.cells else None
        if picture is None:
            continue
        shown = plates.display(picture, stops)
        plates.draw_picture(canvas, shown, left, top, width)
        plates.draw_picture(canvas, difference(shown, exact), left, top + tall + _GAP / 2, width)
        error = row.cells[label].metric(EXACT, context.flip)
        if error is not None:
            plates.write(canvas, fixed(error, 4), left, top - 0.03, _POINTS)
