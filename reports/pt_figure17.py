"""A cube that floats beside a ball of smoke, and between the smoke and the sun.

The map of opaque surfaces alone carries the cube's shadow through the smoke, whose own shadow falls
on itself and on the ground.
"""

from oitbench.papers import Album, Picture, Row, caption, darker, needs_of, plate
from oitbench.report import Artifact, ReportContext
from oitbench.truths import EXACT

title = "The shadow of a cube through smoke"

AWAY = Picture("smoke_ball[cube=away]", "phenomenological", "The cube is beside the smoke")
ABOVE = Picture("smoke_ball[cube=above]", "phenomenological", "The cube is above the smoke")
PAIR = (AWAY, ABOVE)
SHADOW = "shadow_of_the_cube"
ROWS = (Row(PAIR, score=EXACT, marks=(SHADOW,)),)
needs = needs_of(PAIR)


def build(context: ReportContext) -> list[Artifact]:
    """Draw both cubes, and compare the tones of the smoke where the shadow may fall."""
    album = Album(context, needs)
    said = darker(
        album,
        ABOVE.part(SHADOW),
        AWAY.part(SHADOW),
        "the cube above the smoke casts a shadow on it",
    )
    shown = "Frame: the part whose tones are compared. FLIP is against exact compositing."
    return [plate(album, ROWS, "pt_figure17", title=title, caption=caption(album, shown, [said]))]
