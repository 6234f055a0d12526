"""The stochastic shadow map of balls and a knot of glass, with caustics and without.

It is shown as it was drawn, before it becomes variance maps: each texel keeps the nearest surface
or none, for each channel at random. The map is smaller than that of other figures, so that its
texels can be seen.
"""

from oitbench.papers import Album, Finding, Picture, Row, caption, needs_of, plate
from oitbench.report import Artifact, ReportContext

title = "A stochastic shadow map"

SCENE, METHOD, MAP = "caustic_spheres", "phenomenological", "shadow_map"
SHADING = "translucent=published,shadow_map=256"
CAUSTIC = Picture(SCENE, METHOD, "With caustics", target=MAP, shading=SHADING)
EVEN = Picture(SCENE, METHOD, "Without caustics", target=MAP, effects="-caustics", shading=SHADING)
ROWS = (Row((CAUSTIC, EVEN)),)
needs = needs_of((CAUSTIC, EVEN))
LEAST = 0.05
"""Part of neighboring texels that differ at least in a screen door."""


def build(context: ReportContext) -> list[Artifact]:
    """Draw the map twice, and count how often neighboring texels differ."""
    album = Album(context, needs)
    broken = _broken(album, CAUSTIC)
    text = "the map is a screen door"
    if broken is not None:
        text += f": {broken:.0%} of neighboring texels differ"
    said = Finding(text, None if broken is None else broken >= LEAST)
    shown = "Color is reversed depth in three channels; black holds nothing."
    return [plate(album, ROWS, "pt_figure11", title=title, caption=caption(album, shown, [said]))]


def _broken(album: Album, picture: Picture) -> float | None:
    """Return the part of neighboring texels of which exactly one holds a surface."""
    shown = album.shown(picture)
    if shown is None:
        return None
    kept = shown[..., 2] > 0
    return float((kept[:, 1:] != kept[:, :-1]).mean())
