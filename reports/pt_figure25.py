"""Three views of a courtyard in clear air, and the buffers of phenomenological transparency.

Leaves cover parts of pixels, while windows, lamps and wine glasses transmit and refract light. The
paper draws the interiors of leaves with the opaque surfaces, so that only their silhouettes are in
its buffers. This suite does that under ambient occlusion alone, which this scene does not have.
"""

from oitbench.papers import Album, Finding, Picture, Row, caption, needs_of, plate
from oitbench.report import Artifact, ReportContext

title = "A courtyard and the buffers of its views"

SCENE, METHOD, CLEAR = "courtyard", "phenomenological", "-volume"
VIEWS = ("main", "table", "tree")
HEADINGS = {
    "": "Picture",
    "accumulated": "Accumulated light A",
    "transmittance": "Transmittance β",
    "refraction": "Refraction δ",
}


def _row(view: str, labels: dict[str, str]) -> list[Picture]:
    """Return the picture of a view and its buffers."""
    return [
        Picture(SCENE, METHOD, labels.get(target, ""), target=target, view=view, effects=CLEAR)
        for target in HEADINGS
    ]


GRID = {view: _row(view, HEADINGS if view == VIEWS[0] else {}) for view in VIEWS}
ROWS = [Row(pictures) for pictures in GRID.values()]
CROWN = GRID["tree"][2].part("crown")
needs = needs_of(picture for pictures in GRID.values() for picture in pictures)
HIDDEN, FEW = 0.02, 0.01
"""Displayed transmittance that counts as none, and the part of pixels that counts as none."""


def build(context: ReportContext) -> list[Artifact]:
    """Draw all views, and look for leaves in the transmittance."""
    album = Album(context, needs)
    text = caption(album, "Middle gray is no refraction.", [_silhouettes(album)])
    return [plate(album, ROWS, "pt_figure25", title=title, caption=text)]


def _silhouettes(album: Album) -> Finding:
    """Return whether hardly any pixel of a tree is covered completely."""
    text = "only silhouettes of leaves are in the buffers"
    shown = album.shown(CROWN)
    if shown is None:
        return Finding(text, None)
    covered = float((shown.max(axis=2) <= HIDDEN).mean())
    return Finding(f"{text} ({covered:.1%} of the crown lets no light pass)", covered <= FEW)
