"""Caustics of balls of three refractive indices and of a knot, by shadow maps and traced.

The ball of index 1 does not refract. The method changes the density of a stochastic shadow map by
the angle at which light meets the glass, in the form of shadows that the paper publishes.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from oitbench.image.files import Image
from oitbench.papers import Album, Finding, Picture, Row, caption, less, needs_of, plate
from oitbench.report import Artifact, ReportContext

title = "Caustics of refractive indices"

SCENE, METHOD, SHADING = "caustic_spheres", "phenomenological", "translucent=published"
OURS = Picture(SCENE, METHOD, shading=SHADING)
DULL = Picture(SCENE, METHOD, effects="-caustics", shading=SHADING)
PARTS = {"index_10": "Index 1.0", "index_13": "1.3", "index_15": "1.5", "knot": "1.5"}
ROWS = (
    Row([replace(OURS, crop=part, label=PARTS[part]) for part in PARTS], METHOD),
    Row([DULL.part(part) for part in PARTS], "no caustics"),
    Row([OURS.traced.part(part) for part in PARTS], "traced"),
)
needs = needs_of((OURS, DULL, OURS.traced))
EVEN = 0.02
"""Largest relative change of a shadow that has no caustic."""


def build(context: ReportContext) -> list[Artifact]:
    """Draw three balls and a knot with their shadows, and measure the caustics."""
    album = Album(context, needs)
    shown = "A caustic is where the shadow is brighter than without caustics."
    text = caption(album, shown, _findings(album))
    return [plate(album, ROWS, "pt_figure10", title=title, caption=text)]


def _findings(album: Album) -> Iterator[Finding]:
    gains = {part: _gain(album, part) for part in PARTS}
    for part, bright in (("index_10", False), ("index_13", True), ("index_15", True)):
        text = f"the shadow of the ball of index {PARTS[part].split()[-1]} has "
        text += "a bright middle" if bright else "no caustic"
        gain = gains[part]
        if gain is None:
            yield Finding(text, None)
            continue
        most = float(gain.max())
        yield Finding(f"{text} (gains {most:.0%} at most)", (most > EVEN) == bright)
    yield less(
        _size(gains["index_15"]), _size(gains["index_13"]),
        "the bright part is smaller at index 1.5 than at 1.3", 3,
    )  # fmt: skip


def _size(gain: Image | None) -> float | None:
    """Return the part of the pixels that gain more than half of the most."""
    return None if gain is None else float((gain > gain.max() / 2).mean())


def _gain(album: Album, part: str) -> Image | None:
    """Return by how much caustics brighten the shadow in the lower half of a part."""
    images = album.image(OURS.part(part)), album.image(DULL.part(part))
    if images[0] is None or images[1] is None:
        return None
    bright, dull = (image[len(image) // 2 :].mean(axis=2) for image in images if image is not None)
    return np.asarray(bright / np.maximum(dull, 1e-6) - 1)
