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
    gains = [_gain(album, part) for part in PARTS]
    peaks = [None if gain is None else float(gain.max()) for gain in gains]
    sizes = [None if gain is None else float((gain > gain.max() / 2).mean()) for gain in gains]
    yield less(peaks[0], EVEN, "the ball of index 1.0 has no caustic: its shadow gains no light")
    for number, label in ((1, "1.3"), (2, "1.5")):
        text = f"the ball of index {label} brightens the middle of its shadow"
        yield less(0.0 if gains[number] is not None else None, peaks[number], text)
    yield less(
        sizes[2],
        sizes[1],
        "the caustic is smaller at index 1.5 than at 1.3, by part of the frame",
        4,
    )


def _gain(album: Album, part: str) -> Image | None:
    """Return by how much caustics brighten the shadow in the lower half of a part."""
    images = album.image(OURS.part(part)), album.image(DULL.part(part))
    if images[0] is None or images[1] is None:
        return None
    bright, dull = (image[len(image) // 2 :].mean(axis=2) for image in images if image is not None)
    return np.asarray(bright / np.maximum(dull, 1e-6) - 1)
