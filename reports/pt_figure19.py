"""A glass chess set: blended in two passes over objects, and by one unordered pass.

All men of a color are one object, so that no order of objects is right. The first picture has no
translucent shadows either, and sorted blending does not refract. Below are parts of the pictures,
and the buffers of the unordered pass: accumulated light A, transmittance beta, and refraction delta
as red and green around middle gray. The paper has no traced picture.
"""

from oitbench.papers import Album, Picture, Row, caption, nearer, needs_of, plate, unlike
from oitbench.report import Artifact, ReportContext
from oitbench.truths import MATCHED

title = "Chess men of glass"

NAIVE = Picture(
    "chess", "sorted_two_pass", "Two passes over two objects", effects="-translucent_shadows"
)
OURS = Picture("chess", "phenomenological", "Phenomenological")
TRACED = Picture("chess", "phenomenological", "Traced", truth=MATCHED)
PICTURES = (NAIVE, OURS, TRACED)
BUFFERS = [
    Picture("chess", "phenomenological", label, target=target)
    for target, label in (
        ("accumulated", "Accumulated light A"),
        ("transmittance", "Transmittance β"),
        ("refraction", "Refraction δ"),
    )
]
ROWS = (
    Row(PICTURES, marks=("red_pieces",)),
    Row([picture.part("red_pieces") for picture in PICTURES]),
    Row(BUFFERS),
)
needs = needs_of(PICTURES)


def build(context: ReportContext) -> list[Artifact]:
    """Draw the set by both methods, parts of it, and the buffers of one."""
    album = Album(context, needs)
    said = (
        unlike(album, NAIVE, OURS, "order, shadows and refraction change the picture"),
        nearer(
            album, OURS, (NAIVE,), TRACED,
            "phenomenological transparency is nearer to tracing than two passes",
        ),
    )  # fmt: skip
    text = caption(album, "Middle: the part with a frame. Below: buffers.", said)
    return [plate(album, ROWS, "pt_figure19", title=title, caption=text)]
