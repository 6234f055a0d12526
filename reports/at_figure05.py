"""The ways to remove a node from a curve that is full: so that the curve is too low, or too high.

An overestimate lets a later fragment of the compressed range show through. Choosing the way of
least error at each node makes the better curves, but neighboring pixels then choose differently.
"""

from oitbench.papers import Album, Picture, Row, caption, nearer, needs_of, plate
from oitbench.report import Artifact, ReportContext
from oitbench.truths import EXACT

title = "Underestimates and overestimates"

ALL = Picture("smoke_yard", "a_buffer", "Uncompressed")
UNDER = Picture("smoke_yard", "adaptive[nodes=4]", "Underestimate, 4 nodes")
OVER = Picture("smoke_yard", "adaptive[nodes=4,removal=over]", "Overestimate, 4 nodes")
BEST = Picture("smoke_yard", "adaptive[nodes=4,removal=best]", "The better at each node")
PICTURES = (ALL, UNDER, OVER, BEST)
PARTS = [picture.part("fence") for picture in PICTURES]
ROWS = (
    Row(PICTURES, score=EXACT, marks=("fence",)),
    Row(PARTS, "part"),
    Row([None, *PARTS[1:]], against=PARTS[0]),
)
needs = needs_of(PICTURES)


def build(context: ReportContext) -> list[Artifact]:
    """Draw the scene, a part of it, and the differences from all fragments."""
    album = Album(context, needs)
    nearest = "underestimates are nearer to exact compositing than"
    said = (
        nearer(album, UNDER, (OVER,), EXACT, f"{nearest} overestimates"),
        nearer(album, UNDER, (BEST,), EXACT, f"{nearest} choosing at each node"),
    )
    shown = "FLIP is against exact compositing, and differences are from the uncompressed picture."
    text = caption(album, shown, said)
    return [plate(album, ROWS, "at_figure05", title=title, caption=text)]
