"""A cloud and a glass ball with three kinds of shadow: binary, translucent, and with a caustic.

A binary map keeps each surface that blocks half of the light. A stochastic map keeps a surface with
the probability that it blocks light; the caustic changes these probabilities. Both are filtered as
variance maps, the form of shadows that the paper publishes.
"""

from oitbench.papers import Album, Picture, Row, caption, darker, needs_of, plate
from oitbench.report import Artifact, ReportContext

title = "Shadows of a cloud and of a glass ball"

SCENE, METHOD, SHADING = "shadow_trio", "phenomenological", "translucent=published"
BINARY = Picture(
    SCENE, METHOD, "Binary shadow map", effects="-translucent_shadows", shading=SHADING
)
EVEN = Picture(SCENE, METHOD, "Stochastic shadow map", effects="-caustics", shading=SHADING)
CAUSTIC = Picture(SCENE, METHOD, "Stochastic, with a caustic", shading=SHADING)
PICTURES = (BINARY, EVEN, CAUSTIC)
BALL, CLOUD = "shadow_of_ball", "smoke"
MIDDLE, RIM = "middle_of_shadow", "rim_of_shadow"
TOP, FOOT = "top_of_smoke", "foot_of_smoke"
ROWS = (
    Row(PICTURES),
    Row([picture.part(CLOUD) for picture in PICTURES], "cloud"),
    Row([picture.part(BALL) for picture in PICTURES], "shadow of the ball"),
)
needs = needs_of(PICTURES)


def build(context: ReportContext) -> list[Artifact]:
    """Draw the scene with each kind of shadow, and parts of it."""
    album = Album(context, needs)
    said = (
        darker(
            album, BINARY.part(BALL), EVEN.part(BALL),
            "the binary shadow of glass is darker than the stochastic one",
        ),
        darker(
            album, CAUSTIC.part(RIM), CAUSTIC.part(MIDDLE),
            "the caustic brightens the middle of the shadow",
        ),
        darker(album, CAUSTIC.part(FOOT), CAUSTIC.part(TOP), "the foot of the cloud is darker"),
    )  # fmt: skip
    text = caption(album, "Below: the cloud, and the shadow of the ball.", said)
    return [plate(album, ROWS, "pt_figure09", title=title, caption=text)]
