"""Four plastic bottles by four methods, and two targets of phenomenological transparency.

Two passes blend colored transmission exactly where surfaces are sorted; here, all triangles are.
Self-modulation tints the light of overlapping bottles with the hue of their transmission.
"""

from oitbench.papers import Album, Picture, Row, caption, nearer, needs_of, plate, unlike
from oitbench.report import Artifact, ReportContext
from oitbench.truths import EXACT

title = "Four bottles"

SCENE = "bottles"
UNSORTED = Picture(SCENE, "sorted_two_pass[sort=none]", "Two passes, unordered")
SORTED = Picture(SCENE, "sorted_two_pass[sort=triangle]", "Two passes, sorted")
PLAIN = Picture(SCENE, "phenomenological[modulation=none]", "No self-modulation")
OURS = Picture(SCENE, "phenomenological", "Self-modulation")
PICTURES = (UNSORTED, SORTED, PLAIN, OURS)
PART = "overlap"
TARGETS = (
    Picture(SCENE, "phenomenological", "Accumulated light A", target="accumulated"),
    Picture(SCENE, "phenomenological", "Transmittance β", target="transmittance"),
)
ROWS = (
    Row(PICTURES, score=EXACT, marks=(PART,)),
    Row([picture.part(PART) for picture in PICTURES]),
    Row([*TARGETS, None, None]),
)
needs = needs_of((*PICTURES, *TARGETS))


def build(context: ReportContext) -> list[Artifact]:
    """Draw the bottles, a part of each picture, and the targets."""
    album = Album(context, needs)
    said = (
        unlike(album, UNSORTED, SORTED, "unordered submission is incorrect"),
        nearer(album, OURS, (UNSORTED,), EXACT, "phenomenological transparency is nearer to exact"),
        nearer(
            album, OURS.part(PART), (PLAIN.part(PART),), SORTED.part(PART),
            "self-modulation brings the part where bottles overlap nearer to the sorted picture",
        ),
    )  # fmt: skip
    shown = "Below: the part with a frame, then the targets. FLIP is against exact compositing."
    return [plate(album, ROWS, "pt_figure12", title=title, caption=caption(album, shown, said))]
