"""Three scenes that need more than compositing: frosted glass, colored glass that bends, and fog.

The paper shows the first row. Exact compositing is the best that a method can do which neither
blurs nor bends the background, and draws no fog.
"""

from oitbench.papers import Album, Picture, Row, caption, nearer, needs_of, plate
from oitbench.report import Artifact, ReportContext
from oitbench.truths import MATCHED

title = "A frosted door, drinking glasses, and a foggy night"

SCENES = {
    "frosted_door": "Blur behind a frosted door",
    "tumblers": "Refraction, colored shadows and caustics",
    "foggy_street": "Blur, lights and shadows in fog",
}
OURS = [Picture(scene, "phenomenological", label) for scene, label in SCENES.items()]
TRACED = [picture.traced for picture in OURS]
COMPOSITED = [Picture(scene, "a_buffer") for scene in SCENES]
ROWS = (
    Row(OURS, "phenomenological", score=MATCHED),
    Row(TRACED, "traced"),
    Row(COMPOSITED, "exact compositing", score=MATCHED),
)
needs = needs_of((*OURS, *TRACED, *COMPOSITED, *(picture.traced for picture in COMPOSITED)))


def build(context: ReportContext) -> list[Artifact]:
    """Draw the three scenes in three ways."""
    album = Album(context, needs)
    said = [
        nearer(
            album, picture, (other,), MATCHED,
            f"in {picture.scene}, phenomenological transparency is nearer to the traced picture"
            " than exact compositing",
        )
        for picture, other in zip(OURS, COMPOSITED, strict=True)
    ]  # fmt: skip
    text = caption(album, "FLIP is against the traced picture of the same effects.", said)
    return [plate(album, ROWS, "pt_figure01", title=title, caption=text)]
