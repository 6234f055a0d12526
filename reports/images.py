"""What the methods look like: every picture beside both truths, its FLIP map beneath.

The maps show FLIP against exact compositing on the magma scale from 0 (black) to 1. Pixels that are
not finite are magenta.
"""

from __future__ import annotations

import math
import textwrap
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from oitbench import images, metrics
from oitbench import results as read
from oitbench.images import Image
from oitbench.report import Artifact, Figure, ImageGrid, Note, Tile, figures, fixed
from oitbench.results import EXACT, PATH_TRACED, TRUTHS, Panel, Results
from oitbench.store import Record

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

title = "Pictures and error maps"
order = 30

_COLUMNS = 6
_LABEL_WIDTH = 22
# Inches: one picture, the gap between two, the room for a label above and the values below.
_PICTURE = 1.5
_GAP = 0.1
_LABEL = 0.36
_VALUES = 0.34
_MARGIN = 0.08
_SCALE = 0.5


def build(results: Results, out: Path) -> list[Artifact]:
    """Write each scene's pictures and maps as PNG, and all of them as one figure."""
    drawn: list[Artifact] = []
    for panel in results.panels():
        shown = _tiles(results, panel, out)
        if any(picture is not None for _, picture, _ in shown):
            drawn.append(_grid(results, panel, shown, out))
        else:
            drawn.append(Note(f"{panel.title}: there is no picture yet."))
    return drawn or [Note("There is no cell yet.")]


Shown = tuple[Tile, Image | None, Image | None]


def _tiles(results: Results, panel: Panel, out: Path) -> list[Shown]:
    """Return both truths, then every cell, each with its display picture and its map."""
    truths = {kind: _first(results, panel, kind) for kind in TRUTHS}
    exposure = next((float(cell.get("exposure") or 0) for cell in panel.finished), 0.0)
    tiles: list[Shown] = []
    for kind, name in TRUTHS.items():
        values = _noise(results, panel) if kind == PATH_TRACED else ()
        note = "" if truths[kind] is not None else _why_no_truth(panel, kind)
        tile = Tile(name, None, None, values, note, truth=True)
        against = truths[EXACT] if kind == PATH_TRACED else None
        tiles.append(_show(results, tile, truths[kind], against, exposure, out, panel))
    for cell in panel.cells:
        tile = Tile(cell["method"], None, None, _values(results, cell), _note(cell))
        image = results.image(cell, "color") if cell["status"] in read.FINISHED else None
        tiles.append(_show(results, tile, image, truths[EXACT], exposure, out, panel))
    return tiles


def _first(results: Results, panel: Panel, kind: str) -> Image | None:
    found = (results.image(cell, kind) for cell in panel.finished)
    return next((image for image in found if image is not None), None)


def _show(
    results: Results,
    tile: Tile,
    image: Image | None,
    exact: Image | None,
    exposure: float,
    out: Path,
    panel: Panel,
) -> Shown:
    """Write the PNG files of one tile."""
    if image is None:
        return tile, None, None
    stem = "".join(letter if letter.isalnum() else "_" for letter in tile.label)
    folder = out / "images" / panel.slug
    picture = images.mark_nonfinite(images.to_srgb(image, exposure))
    images.write_png(folder / f"{stem}.png", picture)
    colored = None
    if exact is not None and exact.shape == image.shape:
        errors = metrics.flip_map(exact, image, exposure, hdr=results.hdr)
        colored = None if errors is None else _magma(errors)
    if colored is not None:
        images.write_png(folder / f"{stem}-flip.png", colored)
    written = replace(
        tile,
        picture=folder / f"{stem}.png",
        error_map=None if colored is None else folder / f"{stem}-flip.png",
    )
    return written, picture, colored


def _magma(errors: Image) -> Image:
    import matplotlib

    colors: Image = matplotlib.colormaps["magma"](np.clip(errors, 0, 1))[..., :3].astype(np.float32)
    return colors


def _values(results: Results, cell: Record) -> tuple[str, ...]:
    told = []
    for truth, name in ((EXACT, "to exact"), (PATH_TRACED, "to path traced")):
        value = read.metric(cell, truth, results.flip)
        if value is not None:
            told.append(f"{fixed(value, 4)} {name}")
    return tuple(told)


def _noise(results: Results, panel: Panel) -> tuple[str, ...]:
    floors = [read.noise_floor(cell, results.flip) for cell in panel.finished]
    known = [floor for floor in floors if floor is not None]
    return (f"noise {fixed(max(known), 4)}",) if known else ()


def _why_no_truth(panel: Panel, kind: str) -> str:
    for cell in panel.cells:
        reason = ((cell.get("metrics") or {}).get(kind) or {}).get("reason")
        if reason:
            return str(reason)
    return "not rendered"


def _note(cell: Record) -> str:
    if cell["status"] == "ok":
        return ""
    reason = f": {cell['reason']}" if cell.get("reason") else ""
    return f"{cell['status']}{reason}"


def _grid(results: Results, panel: Panel, shown: list[Shown], out: Path) -> ImageGrid:
    caption = (
        f"Top: the picture at the scene's exposure. Beneath: {results.flip} against exact "
        "compositing, from 0 (black) to 1 (pale yellow), with the mean against both truths."
    )
    return ImageGrid(
        panel.title,
        caption,
        tuple(tile for tile, _, _ in shown),
        _figure(results, panel, shown, out, caption),
    )


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
        return _LABEL + 2 * self.picture_height + _GAP / 2 + _VALUES

    @property
    def width(self) -> float:
        return 2 * _MARGIN + self.columns * (_PICTURE + _GAP) + _SCALE

    @property
    def height(self) -> float:
        return 2 * _MARGIN + math.ceil(self.count / self.columns) * (self.tile_height + _GAP)

    def corner(self, place: int) -> tuple[float, float]:
        row, column = divmod(place, self.columns)
        return _MARGIN + column * (_PICTURE + _GAP), _MARGIN + row * (self.tile_height + _GAP)

    def box(self, left: float, top: float, width: float, height: float) -> tuple[float, ...]:
        """Return a rectangle in fractions of the figure, from its lower left."""
        bottom = 1 - (top + height) / self.height
        return left / self.width, bottom, width / self.width, height / self.height


def _figure(results: Results, panel: Panel, shown: list[Shown], out: Path, caption: str) -> Figure:
    layout = _Layout(len(shown), _PICTURE * panel.size[1] / panel.size[0])
    with figures.canvas(layout.width, layout.height, by_hand=True) as figure:
        for place, tile in enumerate(shown):
            _draw_tile(figure, layout, place, tile)
        _draw_scale(figure, layout, results.flip)
        return figures.save(
            figure, out / f"images-{panel.slug}", title=panel.title, caption=caption
        )


def _draw_tile(figure: Canvas, layout: _Layout, place: int, shown: Shown) -> None:
    tile, picture, colored = shown
    left, top = layout.corner(place)
    upper = top + _LABEL
    lower = upper + layout.picture_height + _GAP / 2
    for image, edge in ((picture, upper), (colored, lower)):
        if image is not None:
            box = layout.box(left, edge, _PICTURE, layout.picture_height)
            axes = figure.add_axes((box[0], box[1], box[2], box[3]))
            axes.set_axis_off()
            axes.imshow(image, interpolation="nearest", aspect="auto")
    below = lower + layout.picture_height + 0.04 if colored is not None else lower + 0.02
    note = tile.note if picture is None or not tile.values else ""
    texts = (
        (_heading(tile.label), upper - 0.04, "bottom", 7.5),
        (textwrap.fill(note, _LABEL_WIDTH), upper + 0.04 if picture is None else lower, "top", 7),
        ("\n".join(tile.values), below, "top", 7),
    )
    for text, edge, anchor, size in texts:
        figure.text(
            left / layout.width,
            1 - edge / layout.height,
            text,
            fontsize=size,
            fontweight="bold" if tile.truth and anchor == "bottom" else "normal",
            verticalalignment=anchor,
            linespacing=1.15,
        )


def _heading(label: str) -> str:
    """Break a long label before its parameters."""
    if len(label) <= _LABEL_WIDTH:
        return label
    name, bracket, parameters = label.partition("[")
    return "\n".join([name[:_LABEL_WIDTH], bracket + parameters])


def _draw_scale(figure: Canvas, layout: _Layout, name: str) -> None:
    """Draw the magma scale at the right edge, beside the first row."""
    left = layout.width - _MARGIN - _SCALE + 0.06
    height = 2 * layout.picture_height + _GAP / 2
    box = layout.box(left, _MARGIN + _LABEL, 0.1, height)
    axes = figure.add_axes((box[0], box[1], box[2], box[3]))
    ramp = np.linspace(1, 0, 256)[:, None]
    axes.imshow(ramp, cmap="magma", vmin=0, vmax=1, aspect="auto", extent=(0, 1, 0, 1))
    axes.set_xticks([])
    axes.yaxis.tick_right()
    axes.set_yticks([0, 0.5, 1], ["0", "0.5", "1"])
    axes.set_title(name.partition("@")[0].replace("_", "\n"), fontsize=7, fontweight="normal")
