"""Three scenes with many layers at a pixel, composited with few nodes.

The headings give the largest number of transparent fragments at a pixel and the nodes of a pixel.
The paper's scenes have at most 320, 671 and 45 fragments at a pixel; theirs are not public, and
scenes of this suite stand for them.
"""

from dataclasses import replace
from pathlib import Path

from oitbench.papers import Album, Picture, Row, caption, faithful, needs_of, plate, read_paper
from oitbench.report import Artifact, ReportContext
from oitbench.truths import EXACT

title = "Three scenes by adaptive transparency"

PAPER = read_paper(Path(__file__).parent / "papers" / "at2011.toml")
PICTURES = {name: PAPER.picture(name, "AT", name) for name in ("SMOKE", "HAIR", "FOREST")}
needs = needs_of(PICTURES.values())


def build(context: ReportContext) -> list[Artifact]:
    """Draw the three scenes side by side."""
    album = Album(context, needs)
    shown = [replace(picture, label=_heading(album, picture)) for picture in PICTURES.values()]
    said = [
        faithful(album, picture, EXACT, f"{name} looks like exact compositing")
        for name, picture in PICTURES.items()
    ]
    text = caption(album, "FLIP is against exact compositing.", said)
    rows = [Row(shown, score=EXACT)]
    return [plate(album, rows, "at_figure01", title=title, caption=text)]


def _heading(album: Album, picture: Picture) -> str:
    outcome = album.outcome(picture)
    if outcome is None:
        return picture.label
    layers = outcome.statistics.complexity.worst
    return f"{picture.label}: {layers} fragments, {outcome.parameters['nodes']} nodes"
