"""Shafts of sunlight in the fog of a hall, with shadows in the fog and without.

The paper shows the first picture of such a scene. Here the fog scatters forward, toward the camera.
"""

from dataclasses import replace

from oitbench.papers import Album, Picture, Row, caption, nearer, needs_of, plate, unlike
from oitbench.report import Artifact, ReportContext
from oitbench.truths import MATCHED

title = "Light shafts"

OURS = Picture("light_shafts", "phenomenological", "Phenomenological")
TRACED = replace(OURS.traced, label="Traced")
UNSHADOWED = Picture("light_shafts", "phenomenological", "No shadows", effects="-shadows")
COMPOSITED = Picture("light_shafts", "a_buffer", "Exact compositing: no fog")
ROWS = (Row((OURS, TRACED)), Row((UNSHADOWED, COMPOSITED)))
needs = needs_of((OURS, TRACED, UNSHADOWED, COMPOSITED, COMPOSITED.traced))


def build(context: ReportContext) -> list[Artifact]:
    """Draw the hall in four ways."""
    album = Album(context, needs)
    said = (
        nearer(
            album, OURS, (COMPOSITED,), MATCHED,
            "phenomenological transparency is nearer to the traced picture than no fog",
        ),
        unlike(album, OURS, UNSHADOWED, "shadows in the fog make the shafts"),
    )  # fmt: skip
    text = caption(album, "Without shadows, the sun lights all of the fog.", said)
    return [plate(album, ROWS, "pt_figure14", title=title, caption=text)]
