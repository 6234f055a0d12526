"""Stacks: all pictures of a panel, pixel over pixel, for the viewer of the page."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from typing import Any

import numpy as np

from oitbench.report import pixels, plates, previews
from oitbench.report.artifacts import Layer, Stack
from oitbench.report.context import ReportContext
from oitbench.report.error_maps import MapScale, scale_of
from oitbench.report.pixels import Codes
from oitbench.report.plates import Shown
from oitbench.results.records import Panel
from oitbench.results.schema import Record
from oitbench.truths import TRUTHS

FOLDER = "pixels"
"""Folder of the scripts, in that of the page."""
_PICTURE = "picture"
_Owner = str | Record
"""What a layer shows: a truth, by its key, or a cell."""


def stack(context: ReportContext, panel: Panel, *, caption: str, characters: int) -> Stack | None:
    """Return all truths and methods of a panel, after writing their pixels.

    The figure with all of them is drawn if the context asks for sheets.

    Parameters
    ----------
    context : ReportContext
    panel : Panel
    caption : str
        Words for readers; the scale of the maps is added.
    characters : int
        Room for each preview; see `previews.room`.

    Returns
    -------
    Stack or None
        None if there is no picture yet.
    """
    owners: list[_Owner] = [*TRUTHS, *panel.cells]
    scale = scale_of(panel.finished, panel.truth, context.flip)
    shown = [_show(context, panel, owner, scale) for owner in owners]
    if all(item.image is None for item in shown):
        return None
    script = context.out / FOLDER / f"{panel.slug}.js"
    stored: dict[str, Codes] = {}
    layers: list[Layer] = []
    for number, (owner, item) in enumerate(zip(owners, shown, strict=True)):
        codes = _codes(context, owner, item)
        keys = {name: f"{number}-{name}" for name in codes}
        stored |= {keys[name]: value for name, value in codes.items()}
        layers.append(_layer(context, owner, item, keys, characters))
    pixels.write(script, panel.slug, stored)
    path = context.out / f"images-{panel.slug}"
    title, words = panel.title, f"{caption} Maps: {scale.words}."
    sheet = None
    if context.sheets:
        sheet = plates.draw(context, panel, shown, path, scale=scale, title=title, caption=words)
    return Stack(
        panel.slug,
        tuple(layers),
        panel.truth,
        context.hdr,
        plates.exposure(panel.finished),
        panel.size,
        context.crops_of(panel),
        script,
        title,
        words,
        sheet,
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
        "title": stack.title,
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


def _show(context: ReportContext, panel: Panel, owner: _Owner, scale: MapScale) -> Shown:
    if isinstance(owner, str):
        return plates.show_truth(context, panel, owner, None)
    values = tuple(text for truth in TRUTHS for text in plates.error_text(context, owner, truth))
    return plates.show_cell(context, owner, panel.truth, None, values=values, scale=scale)


def _codes(context: ReportContext, owner: _Owner, shown: Shown) -> dict[str, Codes]:
    """Return the pixels of a layer: those of its picture, and of its error maps by truth."""
    if shown.image is None or shown.picture is None:
        return {}
    picture = pixels.radiance_codes(shown.image) if context.hdr else None
    codes = {_PICTURE: pixels.display_codes(shown.picture) if picture is None else picture}
    if isinstance(owner, Record):
        maps = {truth: context.flip_map(owner, truth) for truth in TRUTHS}
        codes |= {t: pixels.error_codes(errors) for t, errors in maps.items() if errors is not None}
    return codes


def _layer(
    context: ReportContext,
    owner: _Owner,
    shown: Shown,
    keys: Mapping[str, str],
    characters: int,
) -> Layer:
    """Return a layer, whose pixels have the names `keys`."""
    tile, errors = shown.tile, {}
    if isinstance(owner, Record):
        errors = {truth: owner.metric(truth, context.flip) for truth in TRUTHS}
    return Layer(
        tile.label,
        owner if isinstance(owner, str) else "",
        tile.values,
        tile.note,
        {truth: error for truth, error in errors.items() if error is not None},
        "" if shown.picture is None else previews.preview(shown.picture, characters),
        "" if shown.error_map is None else previews.preview(shown.error_map, characters),
        keys.get(_PICTURE, ""),
        {name: key for name, key in keys.items() if name != _PICTURE},
    )
