"""The deviation D of the blur, behind one layer of glass and in dense fog.

Behind glass, D grows with the distance from the glass, and is zero on what is in front of it. In
fog, it grows with the fog before a surface. The paper shows D alone, which is brightest where it is
largest. Targets have 16 bits here, since 8 bits resolve nothing below four pixels of blur.
"""

from itertools import pairwise

from oitbench.papers import Album, Finding, Picture, Row, caption, needs_of, plate
from oitbench.report import Artifact, ReportContext

title = "Diffusion of the background"

METHOD = "phenomenological[precision=half]"
SCENES = {"frosted_door": "One layer of glass", "foggy_street": "Dense fog"}
PICTURES = {scene: Picture(scene, METHOD) for scene in SCENES}
BLURS = {
    scene: Picture(scene, METHOD, label, target="diffusion") for scene, label in SCENES.items()
}
PARTS = {
    "frosted_door": ("frame", "woman", "man", "far_wall"),
    "foggy_street": ("woman", "man", "houses"),
}
"""From the nearest part to the farthest."""
ROWS = (Row([*BLURS.values()], "deviation D"), Row([*PICTURES.values()], "resolved"))
needs = needs_of(PICTURES.values())


def build(context: ReportContext) -> list[Artifact]:
    """Draw the deviations, and the pictures that result."""
    album = Album(context, needs)
    said = [_zero(album), *(_growing(album, scene) for scene in SCENES)]
    text = caption(
        album, "Numbers are means over parts of a picture, whose brightest D is 1.", said
    )
    return [plate(album, ROWS, "pt_figure21", title=title, caption=text)]


def _zero(album: Album) -> Finding:
    """Return whether nothing blurs what is in front of the glass."""
    value = album.tone(BLURS["frosted_door"].part("frame"))
    return Finding("D is zero on the frame of the door", None if value is None else value == 0)


def _growing(album: Album, scene: str) -> Finding:
    """Return whether the deviation grows from each part of a scene to the next one."""
    parts = {name: album.tone(BLURS[scene].part(name)) for name in PARTS[scene]}
    text = f"D grows with depth in {scene}"
    values = [value for value in parts.values() if value is not None]
    if len(values) < len(parts):
        return Finding(text, None)
    numbers = ", ".join(f"{name.replace('_', ' ')} {value:.2f}" for name, value in parts.items())
    return Finding(f"{text} ({numbers})", all(near < far for near, far in pairwise(values)))
