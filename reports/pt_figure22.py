"""Hair by three strategies: unordered blending, weights that fall with distance, and a k-buffer.

All strands are within a quarter of a meter of depth, so that weights hardly differ. The paper
proposes a k-buffer for hair, which drops all layers beyond its nodes; here are hundreds of layers,
each of which covers a small part of a pixel. Strands have the paper's coverage of 0.2. The paper
does not show the last picture.
"""

from oitbench.papers import Album, Finding, Picture, Row, caption, nearer, needs_of, plate
from oitbench.report import Artifact, ReportContext, fixed
from oitbench.truths import EXACT

title = "Hair under three strategies"

SCENE = "hair[alpha=0.2]"
BLENDED = Picture(SCENE, "alpha_blend", "Unordered blending")
OURS = Picture(SCENE, "phenomenological", "Phenomenological")
LISTS = Picture(SCENE, "k_buffer[k=16]", "k-buffer, 16 nodes")
IDEAL = Picture(SCENE, "phenomenological", "Exact compositing", truth=EXACT)
PICTURES = (BLENDED, OURS, LISTS, IDEAL)
ROWS = (
    Row(PICTURES, score=EXACT, marks=("ends",)),
    Row([picture.part("ends") for picture in PICTURES]),
)
MOST = 0.75
"""Part of the error that a substantially better method would have at most."""
needs = needs_of(PICTURES)


def build(context: ReportContext) -> list[Artifact]:
    """Draw the head by three methods, and a part of each picture."""
    album = Album(context, needs)
    said = (
        _no_better(album),
        nearer(album, LISTS, (BLENDED, OURS), EXACT, "a k-buffer is better than both"),
    )
    text = caption(album, "Below: the part with a frame. FLIP is against exact compositing.", said)
    return [plate(album, ROWS, "pt_figure22", title=title, caption=text)]


def _no_better(album: Album) -> Finding:
    """Return whether weights leave most of the error of unordered blending."""
    text = "phenomenological transparency is not much better than unordered blending"
    ours, blended = album.error(OURS, EXACT), album.error(BLENDED, EXACT)
    if ours is None or blended is None:
        return Finding(text, None)
    numbers = f"FLIP {fixed(ours, 4)} against {fixed(blended, 4)}"
    return Finding(f"{text} ({numbers})", ours >= MOST * blended)
