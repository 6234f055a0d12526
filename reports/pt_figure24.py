"""The chess set for both eyes of a viewer.

The paper shows the picture of a head-mounted display, with the correction for its lenses, which
this suite does not draw. Each eye has a view of its own here. The parts with a frame show the same
red men, which each eye sees beside other clear ones.
"""

from oitbench.papers import Album, Picture, Row, caption, needs_of, plate, unlike
from oitbench.report import Artifact, ReportContext
from oitbench.views import EYES

title = "Chess for two eyes"

PAIR = [Picture("chess", "phenomenological", f"{eye.capitalize()} eye", view=eye) for eye in EYES]
PARTS = [picture.part("red_men") for picture in PAIR]
ROWS = (Row(PAIR, marks=("red_men",)), Row(PARTS))
needs = needs_of(PAIR)


def build(context: ReportContext) -> list[Artifact]:
    """Draw both views, and a part of each."""
    album = Album(context, needs)
    said = unlike(
        album, PARTS[0], PARTS[1], "the eyes see different pictures where men hide each other"
    )
    text = caption(album, "Below: the part with a frame.", [said])
    return [plate(album, ROWS, "pt_figure24", title=title, caption=text)]
