"""Shafts of sunlight in the fog of a hall, by one pass that marches through it.

The paper shows such a scene by its method alone. Here the fog scatters forward, toward the camera;
bars, piers and a statue shadow it, and stained glass colors a shaft. Exact compositing has no fog.
"""

from dataclasses import replace

from oitbench.papers import Album, Picture, Row, caption, nearer, needs_of, plate
from oitbench.report import Artifact, ReportContext
from oitbench.truths import MATCHED

title = "Light shafts"

OURS = Picture("light_shafts", "phenomenological", "Phenomenological")
TRACED = replace(OURS.traced, label="Traced")
COMPOSITED = Picture("light_shafts", "a_buffer", "Exact compositing")
ROWS = (Row((OURS, TRACED, COMPOSITED), score=MATCHED),)
needs = needs_of((OURS, TRACED, COMPOSITED, COMPOSITED.traced))


def build(context: ReportContext) -> list[Artifact]:
    """Draw the hall in three ways."""
    album = Album(context, needs)
    said = nearer(
        album, OURS, (COMPOSITED,), MATCHED,
        "phenomenological transparency is nearer to the traced picture than exact compositing",
    )  # fmt: skip
    text = caption(album, "FLIP is against the traced picture.", [said])
    return [plate(album, ROWS, "pt_figure14", title=title, caption=text)]
