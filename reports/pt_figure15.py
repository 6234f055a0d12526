"""Haze in a patio, with the leaves, the wine glasses and the lamps in it.

The paper shows views of the scene San Miguel. The parts are those where haze meets leaves that
cover a part of their pixels, glass that refracts, and the flue of a lamp.
"""

from dataclasses import replace

from oitbench.papers import Album, Picture, Row, caption, nearer, needs_of, plate, unlike
from oitbench.report import Artifact, ReportContext
from oitbench.truths import MATCHED

title = "Fog with glass and leaves"

OURS = Picture("courtyard", "phenomenological", "Phenomenological")
TRACED = replace(OURS.traced, label="Traced")
CLEAR = Picture("courtyard", "phenomenological", "The same, no haze", effects="-volume")
COMPOSITED = Picture("courtyard", "a_buffer", "Exact compositing")
PARTS = ("crown", "leaves", "glasses", "lamp")
ROWS = (
    Row((OURS, TRACED, CLEAR, COMPOSITED), marks=PARTS),
    Row([OURS.part(part) for part in PARTS], "phenomenological"),
    Row([TRACED.part(part) for part in PARTS], "traced"),
)
needs = needs_of((OURS, TRACED, CLEAR, COMPOSITED, COMPOSITED.traced))


def build(context: ReportContext) -> list[Artifact]:
    """Draw the patio in four ways, and parts of it."""
    album = Album(context, needs)
    said = (
        nearer(
            album, OURS, (COMPOSITED,), MATCHED,
            "phenomenological transparency is nearer to the traced picture than exact compositing",
        ),
        unlike(album, OURS, CLEAR, "the haze is plain to see"),
    )  # fmt: skip
    text = caption(album, "Below: the parts with frames.", said)
    return [plate(album, ROWS, "pt_figure15", title=title, caption=text)]
