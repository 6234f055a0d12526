"""Hair that is blended in the order of its draws, beside adaptive transparency.

Alpha blending draws strands over others that are nearer, which the reader sees as light strands
that cross dark ones.
"""

from oitbench.papers import Album, Picture, Row, caption, nearer, needs_of, plate
from oitbench.report import Artifact, ReportContext
from oitbench.truths import EXACT

title = "Hair: alpha blending and adaptive transparency"

BLENDED = Picture("hair", "alpha_blend", "Alpha blending")
ADAPTIVE = Picture("hair", "adaptive[nodes=16]", "Adaptive transparency, 16 nodes")
PAIR = (BLENDED, ADAPTIVE)
ROWS = (
    Row(PAIR, score=EXACT, marks=("fringe",)),
    Row([picture.part("fringe") for picture in PAIR]),
)
needs = needs_of(PAIR)


def build(context: ReportContext) -> list[Artifact]:
    """Draw both heads, and a part of each."""
    album = Album(context, needs)
    said = nearer(
        album, ADAPTIVE, (BLENDED,), EXACT,
        "adaptive transparency is nearer to exact compositing than alpha blending",
    )  # fmt: skip
    text = caption(
        album, "Below: the part with a frame. FLIP is against exact compositing.", [said]
    )
    return [plate(album, ROWS, "at_figure02", title=title, caption=text)]
