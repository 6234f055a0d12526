"""Plates: pictures side by side with their error maps beneath, for the page and for print."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from oitbench.image import files as images
from oitbench.image import metrics
from oitbench.image.files import Image
from oitbench.report import figures
from oitbench.report.artifacts import Figure, ImageGrid, Tile, fixed
from oitbench.results import records as read
from oitbench.results.records import PATH_TRACED, Panel, Results
from oitbench.results.store import Record

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

MARGIN, GAP = 0.08, 0.1
"""Inches at the edge of a plate and between two of its pictures."""
_COLUMNS = 6
_LABEL_WIDTH = 22
# Inches: one picture, the room for a label above and the values below, and for the scale.
_PICTURE = 1.5
_LABEL = 0.36
_VALUES = 0.34
_SCALE = 0.5


@dataclass(frozen=True)
class Shown:
    """A tile with its pixels, display-encoded; None where there are none."""

    tile: Tile
    picture: Image | None
    error_map: Image | None


def first_image(results: Results, cells: Sequence[Record], kind: str) -> Image | None:
    """Return the first image of that kind that the cells share, or None."""
    found = (results.image(cell, kind) for cell in cells)
    return next((image for image in found if image is not None), None)


def exposure(cells: Sequence[Record]) -> float:
    """Return the exposure of the scene that the cells show, in stops."""
    return next((float(cell.get("exposure") or 0) for cell in cells), 0.0)


def display(image: Image, stops: float) -> Image:
    """Return the picture that a reader sees; pixels that are not finite are magenta."""
    return images.mark_nonfinite(images.to_srgb(image, stops))


def show(
    results: Results,
    tile: Tile,
    image: Image | None,
    against: Image | None,
    stops: float,
    folder: Path,
) -> Shown:
    """Write the PNG files of one tile into `folder`: the picture, and its FLIP map to `against`."""
    if image is None:
        return Shown(tile, None, None)
    stem = "".join(letter if letter.isalnum() else "_" for letter in tile.label)
    picture = display(image, stops)
    images.write_png(folder / f"{stem}.png", picture)
    colored = None
    if against is not None and against.shape == image.shape:
        errors = metrics.flip_map(against, image, stops, hdr=results.hdr)
        colored = None if errors is None else _magma(errors)
    if colored is not None:
        images.write_png(folder / f"{stem}-flip.png", colored)
    written = replace(
        tile,
        picture=folder / f"{stem}.png",
        error_map=None if colored is None else folder / f"{stem}-flip.png",
    )
    return Shown(written, picture, colored)


def _magma(errors: Image) -> Image:
    import matplotlib

    colors: Image = matplotlib.colormaps["magma"](np.clip(errors, 0, 1))[..., :3].astype(np.float32)
    return colors


def note(cell: Record) -> str:
    """Return why a cell did not end well; empty if it did."""
    if cell["status"] == "ok":
        return ""
    reason = f": {cell['reason']}" if cell.get("reason") else ""
    return f"{cell['status']}{reason}"


def noise(results: Results, cells: Sequence[Record]) -> tuple[str, ...]:
    """Return the noise floor of the path-traced picture in words, if it is known."""
    floor = read.largest_floor(cells, results.flip)
    return () if floor is None else (f"noise {fixed(floor, 4)}",)


def why_no_truth(cells: Sequence[Record], kind: str = PATH_TRACED) -> str:
    """Return the reason that a cell gives for want of that truth."""
    for cell in cells:
        reason = ((cell.get("metrics") or {}).get(kind) or {}).get("reason")
        if reason:
            return str(reason)
    return "not rendered"


def grid(
    results: Results,
    panel: Panel,
    shown: Sequence[Shown],
    path: Path,
    *,
    title: str,
    caption: str,
) -> ImageGrid:
    """Return the tiles for the page, drawn for print as `path` with the suffixes .png and .pdf."""
    layout = _Layout(len(shown), _PICTURE * panel.size[1] / panel.size[0])
    with figures.canvas(layout.width, layout.height, by_hand=True) as canvas:
        for place, tile in enumerate(shown):
            _draw_tile(canvas, layout, place, tile)
        _draw_scale(canvas, layout, results.flip)
        figure: Figure = figures.save(canvas, path, title=title, caption=caption)
    return ImageGrid(title, caption, tuple(item.tile for item in shown), figure)


@dataclass(frozen=True)
class _Layout:
    """Where tiles lie, in inches from the upper left; every picture has the same size."""

    count: int
    picture_height: float

    @property
    def columns(self) -> int:
        # As few rows as possible, and those of almost equal length.
        return math.ceil(self.count / math.ceil(self.count / _COLUMNS))

    @property
    def tile_height(self) -> float:
        return _LABEL + 2 * self.picture_height + GAP / 2 + _VALUES

    @property
    def width(self) -> float:
        return 2 * MARGIN + self.columns * (_PICTURE + GAP) + _SCALE

    @property
    def height(self) -> float:
        return 2 * MARGIN + math.ceil(self.count / self.columns) * (self.tile_height + GAP)

    def corner(self, place: int) -> tuple[float, float]:
        row, column = divmod(place, self.columns)
        return MARGIN + column * (_PICTURE + GAP), MARGIN + row * (self.tile_height + GAP)


def draw_picture(canvas: Canvas, image: Image, left: float, top: float, width: float) -> None:
    """Draw an image without axes.

    Parameters
    ----------
    canvas : Canvas
    image : array, shape (h, w, 3)
        Display-encoded.
    left, top, width : float
        Inches from the figure's upper left corner; the height follows.
    """
    height = width * image.shape[0] / image.shape[1]
    axes = canvas.add_axes(_box(canvas, left, top, width, height))
    axes.set_axis_off()
    axes.imshow(image, interpolation="nearest", aspect="auto")


def _box(
    canvas: Canvas, left: float, top: float, width: float, height: float
) -> tuple[float, float, float, float]:
    """Return a rectangle in fractions of the figure, from its lower left."""
    whole, tall = canvas.get_size_inches()
    return left / whole, 1 - (top + height) / tall, width / whole, height / tall


def _draw_tile(canvas: Canvas, layout: _Layout, place: int, shown: Shown) -> None:
    tile, picture, colored = shown.tile, shown.picture, shown.error_map
    left, top = layout.corner(place)
    upper = top + _LABEL
    lower = upper + layout.picture_height + GAP / 2
    for image, edge in ((picture, upper), (colored, lower)):
        if image is not None:
            draw_picture(canvas, image, left, edge, _PICTURE)
    below = lower + layout.picture_height + 0.04 if colored is not None else lower + 0.02
    told = tile.note if picture is None or not tile.values else ""
    texts = (
        (_heading(tile.label), upper - 0.04, "bottom", 7.5),
        (textwrap.fill(told, _LABEL_WIDTH), upper + 0.04 if picture is None else lower, "top", 7),
        ("\n".join(tile.values), below, "top", 7),
    )
    for text, edge, anchor, size in texts:
        canvas.text(
            left / layout.width,
            1 - edge / layout.height,
            text,
            fontsize=size,
            fontweight="bold" if tile.truth and anchor == "bottom" else "normal",
            verticalalignment=anchor,
            linespacing=1.15,
        )


def _heading(label: str) -> str:
    """Break a long label before its parameters, or between its words."""
    if len(label) <= _LABEL_WIDTH:
        return label
    name, bracket, parameters = label.partition("[")
    if not bracket and " " in label:
        return textwrap.fill(label, _LABEL_WIDTH)
    return "\n".join([name[:_LABEL_WIDTH], bracket + parameters])


def _draw_scale(canvas: Canvas, layout: _Layout, name: str) -> None:
    """Draw the magma scale at the right edge, beside the first row."""
    left = layout.width - MARGIN - _SCALE + 0.06
    height = 2 * layout.picture_height + GAP / 2
    axes = canvas.add_axes(_box(canvas, left, MARGIN + _LABEL, 0.1, height))
    ramp = np.linspace(1, 0, 256)[:, None]
    axes.imshow(ramp, cmap="magma", vmin=0, vmax=1, aspect="auto", extent=(0, 1, 0, 1))
    axes.set_xticks([])
    axes.yaxis.tick_right()
    axes.set_yticks([0, 0.5, 1], ["0", "0.5", "1"])
    axes.set_title(name.partition("@")[0].replace("_", "\n"), fontsize=7, fontweight="normal")
