"""Stacks: all pictures of a panel, pixel over pixel, for the viewer of the page."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

from oitbench.image.files import Image
from oitbench.report import pixels, plates, previews
from oitbench.report.artifacts import Layer, Stack
from oitbench.report.context import ReportContext
from oitbench.report.pixels import Codes
from oitbench.report.plates import Shown
from oitbench.results.records import Panel
from oitbench.results.schema import Record
from oitbench.truths import TRUTHS

FOLDER = "pixels"
"""Folder of the scripts, in that of the page."""


def stack(context: ReportContext, panel: Panel, *, caption: str, characters: int) -> Stack | None:
    """Return all truths and methods of a panel, after writing their pixels and the figure.

    Parameters
    ----------
    context : ReportContext
    panel : Panel
    caption : str
        Of the figure.
    characters : int
        Room for each preview; see `previews.room`.

    Returns
    -------
    Stack or None
        None if there is no picture yet.
    """
    truths = {truth: plates.show_truth(context, panel, truth, None) for truth in TRUTHS}
    methods = [(cell, _show(context, panel, cell)) for cell in panel.cells]
    shown = [*truths.values(), *(item for _, item in methods)]
    if all(item.image is None for item in shown):
        return None
    stored: dict[str, Codes] = {}
    layers = [_layer(context, item, truth, stored, characters) for truth, item in truths.items()]
    for cell, item in methods:
        layer = _layer(context, item, "", stored, characters, cell)
        layers.append(layer)
    script = context.out / FOLDER / f"{panel.slug}.js"
    pixels.write(script, panel.slug, stored)
    path = context.out / f"images-{panel.slug}"
    return Stack(
        panel.slug,
        tuple(layers),
        panel.truth,
        context.hdr,
        plates.exposure(panel.finished),
        panel.size,
        context.crops_of(panel),
        script,
        plates.draw(context, panel, shown, path, title=panel.title, caption=caption),
    )


def facts(context: ReportContext, stack: Stack, address: str) -> dict[str, Any]:
    """Return what the viewer knows of a stack before its pixels are loaded.

    Parameters
    ----------
    context : ReportContext
    stack : Stack
    address : str
        Of the script with the pixels, from the page.
    """
    return {
        "name": stack.name,
        "title": stack.figure.title,
        "pixels": address,
        "against": stack.against,
        "metric": "HDR-FLIP" if stack.radiance else "FLIP",
        "radiance": stack.radiance,
        "exposure": stack.exposure,
        "size": stack.size,
        "crops": stack.crops,
        "layers": [
            {
                "label": layer.label,
                "truth": layer.truth,
                "color": "" if layer.truth else context.style(layer.label).color,
                "note": layer.note,
                "errors": layer.errors,
                "key": layer.key,
                "maps": layer.maps,
            }
            for layer in stack.layers
        ],
    }


def color_maps() -> dict[str, str]:
    """Return the 256 colors of the viewer's color maps as base64 of R, G, B, by name."""
    import matplotlib

    places = np.arange(256)
    tables = {name: matplotlib.colormaps[name](places, bytes=True) for name in ("magma", "viridis")}
    return {
        name: base64.b64encode(np.ascontiguousarray(table[:, :3]).tobytes()).decode()
        for name, table in tables.items()
    }


def _show(context: ReportContext, panel: Panel, cell: Record) -> Shown:
    values = tuple(text for truth in TRUTHS for text in plates.error_text(context, cell, truth))
    return plates.show_cell(context, cell, panel.truth, None, values=values)


def _layer(
    context: ReportContext,
    shown: Shown,
    truth: str,
    stored: dict[str, Codes],
    characters: int,
    cell: Record | None = None,
) -> Layer:
    """Return a layer, after adding its pixels to `stored`; a method's layer has a `cell`."""
    number = f"{len(stored)}"
    errors: dict[str, float] = {}
    maps: dict[str, str] = {}
    for other in TRUTHS if cell and shown.image is not None else ():
        assert cell is not None
        error, found = cell.metric(other, context.flip), context.flip_map(cell, other)
        if error is not None:
            errors[other] = error
        if found is not None:
            maps[other] = f"{number}-{other}"
            stored[maps[other]] = pixels.error_codes(found)
    if shown.image is not None:
        stored[number] = _codes(context, shown.image, shown.picture)
    tile = shown.tile
    return Layer(
        tile.label,
        truth,
        tile.values,
        tile.note,
        errors,
        "" if shown.picture is None else previews.preview(shown.picture, characters),
        "" if shown.error_map is None else previews.preview(shown.error_map, characters),
        "" if shown.image is None else number,
        maps,
    )


def _codes(context: ReportContext, image: Image, picture: Image | None) -> Codes:
    if context.hdr:
        return pixels.radiance_codes(image)
    assert picture is not None
    return pixels.display_codes(picture)
