"""Two grids of bars of colored glass that cross, each bar with a gray reflection.

Coverage alone cannot tint the light that a bar lets pass. Two-pass blending of bars in sorted order
is exact where the bars do not intersect.
"""

from oitbench.papers import Album, Picture, Row, alike, caption, needs_of, plate, unlike
from oitbench.report import Artifact, ReportContext
from oitbench.truths import EXACT

title = "Colored transmission through two layers of bars"

COVERAGE = Picture("glass_bars", "weighted_blended", "Coverage only: weighted blended")
COLORED = Picture("glass_bars", "phenomenological", "Phenomenological")
SORTED = Picture("glass_bars", "sorted_two_pass", "Two passes over sorted bars")
PICTURES = (COVERAGE, COLORED, SORTED)
ROWS = (
    Row(PICTURES, score=EXACT, marks=("crossings",)),
    Row([picture.part("crossings") for picture in PICTURES]),
)
needs = needs_of(PICTURES)


def build(context: ReportContext) -> list[Artifact]:
    """Draw the bars by three methods, and a part of each picture."""
    album = Album(context, needs)
    said = (
        alike(album, COLORED, SORTED, "phenomenological transparency looks like the sorted passes"),
        unlike(album, COVERAGE, SORTED, "blending by coverage alone looks different from them"),
    )
    text = caption(album, "Below: the part with a frame. FLIP is against exact compositing.", said)
    return [plate(album, ROWS, "pt_figure07", title=title, caption=text)]
