"""A part of the power plant by adaptive transparency with 8 nodes, with one and four samples.

Both pictures are drawn for this figure without sub-pixels. One curve per pixel serves all samples,
and each fragment knows the samples that it covers. Triangles below the size of a pixel, as in small
pictures, gain more fragments than the paper's.
"""

from oitbench.papers import Album, Finding, Picture, Row, caption, needs_of, plate
from oitbench.report import Artifact, ReportContext
from oitbench.report.cells import listed_fragments

title = "Adaptive transparency with four samples per pixel"

ONE = Picture("power_plant", "adaptive", "One sample per pixel", target="color", view="walkway")
FOUR = Picture(
    "power_plant", "adaptive[msaa=4]", "Four samples per pixel", target="color", view="walkway"
)
PAIR = (ONE, FOUR)
ROWS = (Row(PAIR, marks=("pipes",)), Row([picture.part("pipes") for picture in PAIR]))
needs = needs_of(PAIR)


def build(context: ReportContext) -> list[Artifact]:
    """Draw both pictures, and a part of each."""
    album = Album(context, needs)
    text = caption(album, "Below: the part with a frame.", [_growth(album)])
    return [plate(album, ROWS, "at_figure09", title=title, caption=text)]


def _growth(album: Album) -> Finding:
    text = "four samples raise the number of stored fragments by 10 to 50 %"
    outcomes = [album.outcome(picture) for picture in PAIR]
    one, four = [listed_fragments(outcome) if outcome else None for outcome in outcomes]
    if not one or not four:
        return Finding(text, None)
    growth = four / one - 1
    return Finding(f"{text} (by {growth:.0%})", 0.1 <= growth <= 0.5)
