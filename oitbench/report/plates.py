"""Plates: pictures side by side with their error maps below, for the page and for print."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from oitbench.filenames import file_name
from oitbench.image import files as images
from oitbench.image.files import Image
from oitbench.report import figures
from oitbench.report.artifacts import Figure, ImageGrid, Tile, decimal, fixed
from oitbench.report.context import ReportContext
from oitbench.report.error_maps import MapScale
from oitbench.report.pixels import Codes, display_codes
from oitbench.results.pictures import PICTURE, compared
from oitbench.results.ranking import largest_noise_floor, truth_label
from oitbench.results.records import Panel
from oitbench.results.schema import Record

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

MARGIN, GAP = 0.08, 0.1
"""Inches at the edge of a plate and between two of its pictures."""
_COLUMNS = 6
_LABEL_WIDTH = 22
# Height of a picture in widths; taller pictures are drawn narrower, else a figure takes gigabytes.
_TALLEST = 3.0
# Inches: one picture, the room for a label above it and for values below it, and for the scale.
_PICTURE = 1.5
_LABEL = 0.36
_VALUES = 0.34
_SCALE = 0.5


@dataclass(frozen=True)
class Shown:
    """A tile with its pixels, sRGB-encoded, and the linear image; None where there is none."""

    tile: Tile
    picture: Image | None
    error_map: Image | None
    image: Image | None


def first_image(context: ReportContext, panel: Panel, truth: str) -> Image | None:
    """Return the image of a truth, which all cells of a panel share, or None."""
    found = (context.results.image(cell, truth) for cell in panel.finished)
    return next((image for image in found if image is not None), None)


def exposure(cells: Sequence[Record]) -> float:
    """Return the exposure in stops, which all cells of a scene share."""
    return next((cell.outcome.exposure for cell in cells if cell.outcome), 0.0)


def display(image: Image, stops: float) -> Image:
    """Return the displayed picture, sRGB-encoded; pixels that are not finite are magenta."""
    return images.mark_nonfinite(images.to_srgb(image, stops))


def show_truth(context: ReportContext, panel: Panel, truth: str, folder: Path | None) -> Shown:
    """Return the tile of a truth, after writing its picture to `folder`, if there is one."""
    image = first_image(context, panel, truth)
    text = truth_text(context, panel, truth)
    if image is not None and image.shape[1::-1] != panel.size:
        text += ("{1} × {0}".format(*image.shape),)
    tile = Tile(
        truth_label(panel, truth),
        None,
        None,
        text,
        "" if image is not None else why_no_truth(context, panel.cells, truth),
        truth=True,
    )
    return _write(tile, image, None, exposure(panel.finished), folder)


def truth_text(context: ReportContext, panel: Panel, truth: str) -> tuple[str, ...]:
    """Return the noise floor and the samples of a traced truth, and the sub-pixels that count."""
    scores = (cell.outcome.scores[truth] for cell in panel.finished if cell.outcome)
    facts = next((found.reference for found in scores if found.reference), None)
    if facts is None:
        return ()
    floor = largest_noise_floor(panel.finished, truth, context.flip)
    text = "no noise" if not facts.random else f"noise floor {fixed(floor or 0.0, 4)}"
    samples = f"{facts.parts} × {facts.spp} spp, {decimal(facts.seconds)} s"
    return text, f"ssaa {facts.ssaa}, methods {panel.finished[0].ssaa}", samples


def show_cell(
    context: ReportContext,
    cell: Record,
    truth: str,
    folder: Path | None,
    *,
    values: tuple[str, ...],
    scale: MapScale,
    label: str = "",
) -> Shown:
    """Return the tile of a cell, after writing its picture and its FLIP map.

    Parameters
    ----------
    context : ReportContext
    cell : Record
    truth : str
        The truth that the map compares with.
    folder : Path, optional
        Default: nothing is written.
    values : tuple of str
        Lines below the pictures.
    scale : MapScale
        Of the map.
    label : str
        Heading. Default: the label of the method.
    """
    picture = compared(cell.outcome, truth) if cell.outcome else PICTURE
    fault = context.results.fault(cell, picture)
    tile = Tile(label or cell.method, None, None, values, fault or note(cell))
    image, errors = context.results.image(cell, picture), context.flip_map(cell, truth)
    colored = None if errors is None else scale.colored(errors)
    return _write(tile, image, colored, exposure([cell]), folder)


def error_text(context: ReportContext, cell: Record, truth: str, name: str = "") -> tuple[str, ...]:
    """Return the mean error of a cell against a truth as text; empty if it has none.

    `name` is that of the truth for readers. Default: its key.
    """
    value = cell.metric(truth, context.flip)
    return () if value is None else (f"{fixed(value, 4)} to {name or truth}",)


def note(cell: Record) -> str:
    """Return the status of a cell with its reason; empty if the status is "ok"."""
    if cell.status == "ok":
        return ""
    return f"{cell.status}: {cell.reason}" if cell.reason else cell.status


def why_no_truth(context: ReportContext, cells: Sequence[Record], truth: str) -> str:
    """Return the reason why cells have no image of a truth."""
    faults = (context.results.fault(cell, truth) for cell in cells)
    reasons = (cell.outcome.scores[truth].reason for cell in cells if cell.outcome)
    return next(filter(None, (*faults, *reasons)), "not rendered")


def _write(
    tile: Tile, image: Image | None, colored: Image | None, stops: float, folder: Path | None
) -> Shown:
    """Write the PNG files of a tile to a folder, if any, and return it with their paths."""
    if image is None:
        return Shown(tile, None, None, None)
    picture = display(image, stops)
    if folder is None:
        return Shown(tile, picture, colored, image)
    stem = file_name(tile.label)
    files = [folder / f"{stem}.png", folder / f"{stem}-flip.png"]
    images.write_png(files[0], picture)
    if colored is not None:
        images.write_png(files[1], colored)
    written = replace(tile, picture=files[0], error_map=None if colored is None else files[1])
    return Shown(written, picture, colored, image)


def grid(
    context: ReportContext,
    panel: Panel,
    shown: Sequence[Shown],
    path: Path,
    *,
    scale: MapScale,
    title: str,
    caption: str,
) -> ImageGrid:
    """Return the tiles for the page, and the same as one figure."""
    figure = draw(context, panel, shown, path, scale=scale, title=title, caption=caption)
    return ImageGrid(tuple(item.tile for item in shown), figure)


def draw(
    context: ReportContext,
    panel: Panel,
    shown: Sequence[Shown],
    path: Path,
    *,
    scale: MapScale,
    title: str,
    caption: str,
) -> Figure:
    """Draw tiles as one figure, `path` with the suffixes .png and .pdf."""
    layout = _Layout(len(shown), *fitted(panel.size, _PICTURE))
    with figures.canvas(layout.width, layout.height, by_hand=True) as canvas:
        for place, tile in enumerate(shown):
            _draw_tile(canvas, layout, place, tile)
        _draw_scale(canvas, layout, context.flip_name, scale)
        return figures.save(canvas, path, title=title, caption=caption)


def fitted(size: tuple[int, int], width: float) -> tuple[float, float]:
    """Return the width and height at which a picture is drawn, in the unit of `width`.

    Parameters
    ----------
    size : (int, int)
        Pixels.
    width : float
        Width of a picture that is not very tall.
    """
    width = min(width, _TALLEST * width * size[0] / size[1])
    return width, width * size[1] / size[0]


@dataclass(frozen=True)
class _Layout:
    """Positions of tiles, in inches from the upper left; all pictures have the same size."""

    count: int
    picture_width: float
    picture_height: float

    @property
    def columns(self) -> int:
        # As few rows as possible, of almost equal length.
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
    """Draw an image without axes; pixels that are smaller than dots are averaged.

    Parameters
    ----------
    canvas : Canvas
    image : array, shape (h, w, 3)
        sRGB-encoded, in [0, 1].
    left, top, width : float
        Inches from the upper left corner of the figure; the height follows.
    """
    from matplotlib.image import BboxImage
    from matplotlib.transforms import Bbox, TransformedBbox

    height = width * image.shape[0] / image.shape[1]
    bounds = Bbox.from_bounds(*_box(canvas, left, top, width, height))
    # Axes around each picture would take half of the time of a figure.
    picture = BboxImage(TransformedBbox(bounds, canvas.transFigure), interpolation="nearest")
    picture.set_data(_legible(image, width))
    canvas.add_artist(picture)


def _legible(image: Image, width: float) -> Codes:
    """Return the levels of a picture; those of several pixels for each dot are averaged."""
    from PIL import Image as Picture

    levels = display_codes(image)
    factor = int(image.shape[1] / (width * figures.DOTS_PER_INCH))
    return levels if factor < 2 else np.asarray(Picture.fromarray(levels).reduce(factor))


def write(
    canvas: Canvas,
    text: str,
    left: float,
    edge: float,
    size: float,
    *,
    below: bool = False,
    bold: bool = False,
    color: str = figures.INK,
    spacing: float = 1.15,
) -> None:
    """Write text above or below an edge.

    Parameters
    ----------
    canvas : Canvas
    text : str
    left, edge : float
        Inches from the upper left corner of the figure.
    size : float
        Points.
    below, bold : bool
    color : str
    spacing : float
        Distance of lines in heights of the font.
    """
    whole, tall = canvas.get_size_inches()
    canvas.text(
        left / whole,
        1 - edge / tall,
        text,
        fontsize=size,
        fontweight="bold" if bold else "normal",
        color=color,
        verticalalignment="top" if below else "bottom",
        linespacing=spacing,
    )


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
            draw_picture(canvas, image, left, edge, layout.picture_width)
    lines = [*tile.values, textwrap.fill(tile.note, _LABEL_WIDTH)]
    below = upper if picture is None else lower
    if colored is not None:
        # There is no room for the note, which the page shows.
        lines, below = [*tile.values], lower + layout.picture_height
    write(canvas, _heading(tile.label), left, upper - 0.04, 7.5, bold=tile.truth)
    write(canvas, "\n".join(lines), left, below + 0.04, 7, below=True)


def _heading(label: str) -> str:
    """Break a long label before its parameters, or between words."""
    if len(label) <= _LABEL_WIDTH:
        return label
    if "[" not in label and " " in label:
        return textwrap.fill(label, _LABEL_WIDTH)
    return "\n".join(lines_of(label, _LABEL_WIDTH))


def lines_of(label: str, letters: int) -> list[str]:
    """Return the label of a method as lines, which end at underscores and before parameters.

    Only words with more letters than a line are broken, with a hyphen; parameters have none, as it
    would be a minus.
    """
    words = re.findall(r"\[.*|[^_\[]+_?|_", label)
    lines = [""]
    for part in (part for word in words for part in _parts(word, letters)):
        if lines[-1] and len(lines[-1] + part) > letters:
            lines.append("")
        lines[-1] += part
    return lines


def _parts(word: str, letters: int) -> list[str]:
    if len(word) <= letters:
        return [word]
    hyphen = "" if word.startswith("[") else "-"
    step = max(1, letters - len(hyphen))
    parts = [word[start : start + step] for start in range(0, len(word), step)]
    return [*(part + hyphen for part in parts[:-1]), parts[-1]]


def _draw_scale(canvas: Canvas, layout: _Layout, name: str, scale: MapScale) -> None:
    """Draw the scale of the error maps at the right edge, beside the first row."""
    left = layout.width - MARGIN - _SCALE + 0.06
    height = 2 * layout.picture_height + GAP / 2
    axes = canvas.add_axes(_box(canvas, left, MARGIN + _LABEL, 0.1, height))
    ramp = np.linspace(1, 0, 256)[:, None]
    axes.imshow(ramp, cmap="magma", vmin=0, vmax=1, aspect="auto", extent=(0, 1, 0, 1))
    axes.set_xticks([])
    axes.yaxis.tick_right()
    axes.set_yticks([*scale.ticks], [*scale.ticks.values()])
    axes.tick_params(labelsize=6.5, length=2)
    axes.set_title(name, fontsize=7, fontweight="normal", pad=8)
