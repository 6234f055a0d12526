"""What a method stores for a picture: its targets, as their views show them, and its shadow map.

Only methods that declare views appear, each with the first of its cells in a scene. Of scenes in
which the same effects run, which need the same targets, the first is shown. The frames are drawn
for this page, one sample per pixel, by the same code as `oitbench render --target`, with the
published form of translucent shadows. The text below a picture is its range. For phenomenological
transparency, McGuire & Mara 2017 show these targets in figures 12 (bottles: accumulated light and
transmittance), 19 (chess: refraction), 21 (door and street: diffusion) and 25, and the stochastic
shadow map in figure 11 (caustic_spheres).
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from oitbench.errors import OitbenchError
from oitbench.image import files
from oitbench.report import (
    Artifact,
    Figure,
    ImageGrid,
    Note,
    ReportContext,
    Tile,
    figures,
    plates,
)
from oitbench.results.records import Panel
from oitbench.results.schema import Record
from oitbench.shading import PUBLISHED, read_shading

if TYPE_CHECKING:
    from oitbench.matrix.targets import DrawnTarget
    from oitbench.plugins import Collection

title = "Buffers"
order = 33

_IMAGE, _SHADOWS = "color", "shadow_map"
_ACROSS = 5
# Inches: one picture, and the room for the lines above and below it.
_PICTURE, _LABEL, _TEXT = 1.75, 0.22, 0.42
_TEXT_WIDTH = 36


def build(context: ReportContext) -> list[Artifact]:
    """Draw one plate for each method with views and each set of effects that run."""
    from oitbench.plugins import Collection

    collection = Collection.load()
    drawn: list[Artifact] = []
    known: set[tuple[str, frozenset[str]]] = set()
    for panel in context.results.panels():
        for cell in _cells(collection, panel):
            running = frozenset(cell.requested_effects) - frozenset(cell.missing_effects)
            if (cell.name, running) not in known:
                drawn.append(_plate(context, panel, cell))
                if isinstance(drawn[-1], ImageGrid):
                    known.add((cell.name, running))
    return drawn or [Note("No finished cell belongs to a method that declares views.")]


def _cells(collection: Collection, panel: Panel) -> Iterator[Record]:
    """Yield the first finished cell of each method with views."""
    seen: set[str] = set()
    for cell in panel.finished:
        if cell.name not in seen and cell.name in collection.methods:
            seen.add(cell.name)
            try:
                (method,) = collection.expand_methods([cell.method])
            except (OitbenchError, ValueError):
                continue  # the file has changed since
            if method.views:
                yield cell


def _plate(context: ReportContext, panel: Panel, cell: Record) -> Artifact:
    """Return the plate of a cell, or a note that says why there is none."""
    from oitbench.matrix.targets import draw

    heading = f"{panel.title}: {cell.method}"
    try:
        shading = replace(read_shading(cell.shading), translucent=PUBLISHED).label
        found = draw(
            cell.scene, cell.method, size=cell.size, effects=cell.effects, shading=[shading],
            view=cell.view,
        )  # fmt: skip
    except OitbenchError as error:
        return Note(f"{heading}: {error}")
    shown = [item for item in found if item.facts.view or item.facts.name == _IMAGE]
    shown += _shadow_map(found)
    folder = context.out / "buffers" / f"{panel.slug}-{cell.name}"
    tiles = tuple(_tile(item, folder) for item in shown)
    path = context.out / f"buffers-{panel.slug}-{cell.name}"
    return ImageGrid(tiles, _figure(shown, path, heading))


def _shadow_map(found: Sequence[DrawnTarget]) -> list[DrawnTarget]:
    """Return the shadow map of transparent surfaces that fills the most texels, if there is one."""

    def filled(item: DrawnTarget) -> int:
        return 0 if item.values is None else int(np.count_nonzero(item.values))

    maps = [item for item in found if item.facts.name.partition("@")[0] == _SHADOWS]
    return [item for item in sorted(maps, key=filled, reverse=True) if filled(item)][:1]


def _tile(item: DrawnTarget, folder: Path) -> Tile:
    """Return the tile of a target, after writing its picture."""
    picture, name = item.picture, item.facts.name
    path = folder / f"{name}.png"
    files.write_png(path, picture.srgb, f"{name}, {item.facts.format}: {picture.text}")
    return Tile(name, path, None, (item.facts.format, picture.text))


def _figure(shown: Sequence[DrawnTarget], path: Path, heading: str) -> Figure:
    """Draw all pictures in rows, with the same width."""
    pictures = [item.picture for item in shown]
    boxes = [plates.fitted(item.srgb.shape[1::-1], _PICTURE) for item in pictures]
    tallest = max(height for _, height in boxes)
    tile = _LABEL + tallest + _TEXT
    across = min(_ACROSS, len(shown))
    whole = 2 * plates.MARGIN + across * (_PICTURE + plates.GAP)
    tall = 2 * plates.MARGIN + -(-len(shown) // across) * (tile + plates.GAP)
    with figures.canvas(whole, tall, by_hand=True) as canvas:
        for place, (item, picture, (width, height)) in enumerate(
            zip(shown, pictures, boxes, strict=True)
        ):
            row, column = divmod(place, across)
            left = plates.MARGIN + column * (_PICTURE + plates.GAP)
            top = plates.MARGIN + row * (tile + plates.GAP) + _LABEL
            plates.draw_picture(canvas, picture.srgb, left, top, width)
            lines = textwrap.fill(f"{item.facts.format}; {picture.text}", _TEXT_WIDTH)
            plates.write(canvas, item.facts.name, left, top - 0.04, 8)
            plates.write(canvas, lines, left, top + height + 0.04, 6.5, below=True)
        caption = (
            "The image, the views that the method declares, and the map of transparent surfaces as"
            " one beam sees them, as it was drawn at random under the published form of shadows."
            " The text below each picture states its format and its range."
        )
        return figures.save(canvas, path, title=heading, caption=caption)
