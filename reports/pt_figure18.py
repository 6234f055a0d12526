"""Clouds of particles in front of a sky, with their shadows on themselves and on each other.

The paper shows the first picture. The second one has no shadows, so that differences are due to
them alone.
"""

from oitbench.papers import Album, Picture, Row, caption, darker, needs_of, plate
from oitbench.report import Artifact, ReportContext
from oitbench.truths import EXACT

title = "Clouds with shadows"

SHADED = Picture("clouds", "phenomenological", "With shadows")
FLAT = Picture("clouds", "phenomenological", "Without shadows", effects="-translucent_shadows")
PAIR = (SHADED, FLAT)
LIT, CAST, FOOT = "lit_side", "shaded_side", "foot"
ROWS = (
    Row(PAIR, score=EXACT, marks=(LIT, CAST, FOOT)),
    Row([picture.part("center_cloud") for picture in PAIR]),
)
needs = needs_of(PAIR)


def build(context: ReportContext) -> list[Artifact]:
    """Draw the clouds with and without shadows, and compare the tones of parts of them."""
    album = Album(context, needs)
    said = (
        darker(album, SHADED.part(FOOT), SHADED.part(LIT), "clouds are dark below"),
        darker(
            album, SHADED.part(CAST), SHADED.part(LIT),
            "the left cloud shades the left part of the center one",
        ),
    )  # fmt: skip
    shown = (
        "Frames: the parts whose tones are compared. Below: the center cloud. FLIP is against exact"
        " compositing with the same shadows."
    )
    text = caption(album, shown, said)
    return [plate(album, ROWS, "pt_figure18", title=title, caption=text)]
