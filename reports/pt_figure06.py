"""Plants without ambient occlusion, with that of opaque surfaces, and with inferred occlusion.

The outlines of leaves, which cover a part of their pixels, are not in the depth buffer that
occlusion is computed from. Without inference they receive none and are too bright.
"""

from oitbench.papers import Album, Picture, Row, caption, less, nearer, needs_of, plate
from oitbench.report import Artifact, ReportContext
from oitbench.results.schema import TRANSMITTANCE

title = "Ambient occlusion of leaves"

SCENE, METHOD, PART = "foliage[light=sky]", "phenomenological", "blossoms"
NONE = Picture(SCENE, METHOD, "No ambient occlusion", effects="-ambient_occlusion")
OPAQUE = Picture(SCENE, METHOD, "On opaque surfaces", effects="-inferred_ao")
INFERRED = Picture(SCENE, METHOD, "Inferred at outlines, too")
PICTURES = (NONE, OPAQUE, INFERRED)
TRACED = INFERRED.traced
ROWS = (
    Row(PICTURES, marks=(PART,)),
    Row([picture.part(PART) for picture in PICTURES]),
)
needs = needs_of((*PICTURES, TRACED))
PARTIAL = (0.2, 0.8)
"""Transmittance of all layers at a pixel of an outline."""


def build(context: ReportContext) -> list[Artifact]:
    """Draw the plants with three kinds of occlusion, and a part of each."""
    album = Album(context, needs)
    outlines = [_outlines(album, picture) for picture in PICTURES]
    closer = "inferred occlusion is nearer to traced occlusion than"
    said = (
        less(outlines[2], outlines[1], "inferred occlusion darkens the bright outlines", 3),
        nearer(album, INFERRED, (NONE,), TRACED, f"{closer} none"),
        nearer(album, INFERRED, (OPAQUE,), TRACED, f"{closer} that of opaque surfaces"),
    )
    shown = "Below: the part with a frame. Outlines are compared by their mean radiance."
    return [plate(album, ROWS, "pt_figure06", title=title, caption=caption(album, shown, said))]


def _outlines(album: Album, picture: Picture) -> float | None:
    """Return the mean radiance of pixels that layers cover in part; None if it is not known."""
    record, image = album.record(INFERRED), album.image(picture)
    light = album.context.results.image(record, TRANSMITTANCE) if record else None
    if image is None or light is None:
        return None
    low, high = PARTIAL
    seen = light.mean(axis=2)
    partial = (seen > low) & (seen < high)
    return float(image[partial].mean()) if partial.any() else None
