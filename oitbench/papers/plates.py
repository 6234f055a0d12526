"""Pictures in rows, as papers print them: headings above, parts and differences in further rows."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from oitbench.image.files import Image
from oitbench.papers.album import Album, reduced
from oitbench.papers.picture import Picture
from oitbench.report import figures
from oitbench.report.artifacts import Figure, fixed
from oitbench.report.plates import MARGIN, draw_picture, write

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

FACTOR = 8
"""Of differences from another picture."""
_DIFFERENCE = f"difference ×{FACTOR}"
_WIDEST, _BLANK = 3.1, 0.95
# Inches: between pictures, the room for a line above or below a picture, and for a row's name.
_GAP, _LINE, _SIDE = 0.06, 0.15, 0.2
_HEADING, _TEXT = 7.5, 6.5
_CHARACTERS = 15
"""Characters of a heading in an inch."""


@dataclass(frozen=True)
class Row:
    """Pictures side by side.

    Parameters
    ----------
    pictures : sequence of Picture or None
        None leaves a place empty.
    name : str
        Written along the left edge. Default: none, or that the row shows differences.
    against : Picture, optional
        Show the difference of the displayed colors from this picture, times `FACTOR`.
    score : str
        Key of a truth: mean FLIP of each method against it stands below its picture.
    marks : sequence of str
        Names of parts that are outlined in each picture.
    """

    pictures: Sequence[Picture | None]
    name: str = ""
    against: Picture | None = None
    score: str = ""
    marks: Sequence[str] = ()

    @property
    def side(self) -> str:
        """The text along the left edge."""
        return self.name or (_DIFFERENCE if self.against else "")


@dataclass(frozen=True)
class _Box:
    """A row's place on a plate, in inches: its top, and those of its parts from there."""

    top: float
    headings: float
    tall: float
    below: float

    @property
    def height(self) -> float:
        return self.headings + self.tall + self.below + _GAP


def plate(album: Album, rows: Sequence[Row], name: str, *, title: str, caption: str) -> Figure:
    """Draw rows of pictures as one figure, and return it for the page.

    Parameters
    ----------
    album : Album
    rows : sequence of Row
    name : str
        Of the files, in the folder of the page.
    title, caption : str
    """
    side = _SIDE if any(row.side for row in rows) else 0.0
    count = max(len(row.pictures) for row in rows)
    width = min(_WIDEST, (figures.WIDTH - 2 * MARGIN - side) / count - _GAP)
    shown = [[_shown(album, row, picture) for picture in row.pictures] for row in rows]
    boxes: list[_Box] = []
    top = MARGIN
    for row, images in zip(rows, shown, strict=True):
        boxes.append(_box(row, images, width, top))
        top += boxes[-1].height
    across = 2 * MARGIN + side + count * (width + _GAP)
    with figures.canvas(across, top + MARGIN, by_hand=True) as canvas:
        for row, images, box in zip(rows, shown, boxes, strict=True):
            _write_name(canvas, row.side, box)
            for place, (picture, image) in enumerate(zip(row.pictures, images, strict=True)):
                if picture is not None:
                    left = MARGIN + side + place * (width + _GAP)
                    _draw(canvas, album, row, picture, image, box, left, width)
        return figures.save(canvas, album.context.out / name, title=title, caption=caption)


def difference(image: Image, other: Image) -> Image:
    """Return the difference of two displayed pictures times `FACTOR`, clipped to [0, 1]."""
    return np.asarray(np.clip(FACTOR * np.abs(image - other), 0, 1))


def _shown(album: Album, row: Row, picture: Picture | None) -> Image | None:
    """Return the colors of one place of a row; None if there is no picture."""
    image = album.shown(picture) if picture is not None else None
    if image is None or picture is None or row.against is None:
        return image
    other = album.shown(row.against)
    if other is None:
        return None
    same = reduced(image, other)
    return difference(same, other) if same.shape == other.shape else None


def _box(row: Row, images: Sequence[Image | None], width: float, top: float) -> _Box:
    lines = [len(_heading(p.label, width).splitlines()) for p in row.pictures if p is not None]
    ratios = [image.shape[0] / image.shape[1] for image in images if image is not None]
    tall = width * max(ratios, default=0.5)
    return _Box(top, max(lines, default=0) * _LINE, tall, _LINE if row.score else 0.0)


def _heading(label: str, width: float) -> str:
    return textwrap.fill(label, max(8, round(_CHARACTERS * width)))


def _write_name(canvas: Canvas, name: str, box: _Box) -> None:
    whole, tall = canvas.get_size_inches()
    middle = box.top + box.headings + box.tall / 2
    canvas.text(
        (MARGIN + _SIDE / 2) / whole, 1 - middle / tall, name,
        fontsize=_HEADING, rotation=90, horizontalalignment="center", verticalalignment="center",
    )  # fmt: skip


def _draw(
    canvas: Canvas,
    album: Album,
    row: Row,
    picture: Picture,
    image: Image | None,
    box: _Box,
    left: float,
    width: float,
) -> None:
    """Draw one picture with the texts around it, or write why there is none."""
    edge = box.top + box.headings
    write(canvas, _heading(picture.label, width), left, edge - 0.03, _HEADING)
    if image is None:
        blank = np.full((1, 1, 3), _BLANK, np.float32)
        draw_picture(
            canvas, np.resize(blank, (round(1000 * box.tall / width), 1000, 3)), left, edge, width
        )
        why = textwrap.fill(album.why(picture), max(8, round(_CHARACTERS * width)))
        write(canvas, why, left, edge + 0.03, _TEXT, below=True, color=figures.QUIET)
        return
    draw_picture(canvas, image, left, edge, width)
    for mark in row.marks:
        _outline(canvas, album.crop(picture, mark), left, edge, (width, box.tall))
    error = album.error(picture, row.score) if row.score and not picture.truth else None
    if error is not None:
        text = f"FLIP {fixed(error, 4)}"
        write(canvas, text, left, edge + box.tall + 0.02, _TEXT, below=True, color=figures.QUIET)


def _outline(
    canvas: Canvas,
    part: tuple[float, float, float, float],
    left: float,
    top: float,
    size: tuple[float, float],
) -> None:
    """Draw the frame of a part of a picture of some size in inches."""
    from matplotlib.patches import Rectangle

    whole, tall = canvas.get_size_inches()
    x, y = left + part[0] * size[0], top + (part[1] + part[3]) * size[1]
    for color, line in (("#000000", 1.6), ("#ffffff", 0.8)):
        canvas.add_artist(
            Rectangle(
                (x / whole, 1 - y / tall), part[2] * size[0] / whole, part[3] * size[1] / tall,
                fill=False, edgecolor=color, linewidth=line, transform=canvas.transFigure,
                zorder=10,
            )
        )  # fmt: skip
