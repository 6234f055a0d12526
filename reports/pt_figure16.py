"""A ball of smoke of a thousand particles, with and without the shadow that it casts on itself.

Both balls cast their shadow on the ground, and a cube stands partly inside of them. Without its own
shadow, smoke has the same tone everywhere.
"""

from oitbench.papers import Album, Picture, Row, caption, darker, even, needs_of, plate, unlike
from oitbench.report import Artifact, ReportContext
from oitbench.truths import EXACT

title = "Smoke that shadows itself"

FLAT = Picture("smoke_ball[self_shadow=false]", "phenomenological", "No shadow on the smoke")
SHADED = Picture("smoke_ball", "phenomenological", "The smoke shadows itself")
PAIR = (FLAT, SHADED)
SUNNY, DARK = "sunny_smoke", "dark_smoke"
ROWS = (Row(PAIR, score=EXACT, marks=(SUNNY, DARK)),)
needs = needs_of(PAIR)


def build(context: ReportContext) -> list[Artifact]:
    """Draw both balls, and compare the tones of two parts of the smoke."""
    album = Album(context, needs)
    said = (
        unlike(album, FLAT, SHADED, "the shadow changes how the smoke looks"),
        darker(
            album, SHADED.part(DARK), SHADED.part(SUNNY),
            "smoke with its own shadow is darker away from the light",
        ),
        even(album, FLAT.part(DARK), FLAT.part(SUNNY), "smoke without it has an even tone"),
    )  # fmt: skip
    shown = "Frames: the parts whose tones are compared. FLIP is against exact compositing."
    text = caption(album, shown, said)
    return [plate(album, ROWS, "pt_figure16", title=title, caption=text)]
