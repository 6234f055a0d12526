"""Views of a patio in haze and in clear air, with leaves, wine glasses and lamps.

The paper shows views of the scene San Miguel. Below are parts where haze meets leaves that cover a
part of their pixels, and glass that refracts.
"""

from dataclasses import replace

from oitbench.papers import Album, Picture, Row, alike, caption, nearer, needs_of, plate, unlike
from oitbench.report import Artifact, ReportContext
from oitbench.truths import MATCHED

title = "Fog with glass and leaves"

VIEWS = {"main": "Patio", "table": "Table", "tree": "Tree"}
HAZY = [Picture("courtyard", "phenomenological", VIEWS[view], view=view) for view in VIEWS]
CLEAR = [replace(picture, label="", effects="-volume") for picture in HAZY]
OURS = HAZY[0]
TRACED = replace(OURS.traced, label="Patio, traced")
COMPOSITED = Picture("courtyard", "a_buffer", "Patio, exact compositing")
PARTS = ("crown", "leaves", "far_table", "glasses")
ROWS = (
    Row((*HAZY, TRACED), "in haze"),
    Row((*CLEAR, COMPOSITED), "in clear air"),
    Row([OURS.part(part) for part in PARTS], "parts"),
    Row([TRACED.part(part) for part in PARTS], "parts, traced"),
)
needs = needs_of((*HAZY, TRACED, *CLEAR, COMPOSITED, COMPOSITED.traced))


def build(context: ReportContext) -> list[Artifact]:
    """Draw three views with haze and without, and parts of the first one."""
    album = Album(context, needs)
    said = [
        nearer(
            album, OURS, (COMPOSITED,), MATCHED,
            "phenomenological transparency is nearer to the traced picture than exact compositing",
        ),
        *(
            unlike(album, hazy, clear, f"haze is plain to see in the view {hazy.view}")
            for hazy, clear in zip(HAZY, CLEAR, strict=True)
        ),
        alike(
            album, OURS.part("crown"), TRACED.part("crown"), "leaves far away are as hazy as traced"
        ),
    ]  # fmt: skip
    text = caption(album, "Below: parts of the first view, and the same traced.", said)
    return [plate(album, ROWS, "pt_figure15", title=title, caption=text)]
