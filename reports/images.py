"""The picture of every method, with all truths, and the map of its FLIP error.

A click on a picture opens the viewer, which shows all pictures of a scene at the same pixels,
without loss. The maps below the pictures show FLIP against the truth that ranks the scene; all maps
of a scene have one scale, which its caption states. Pixels that are not finite are magenta; such
pictures have no map and no error.
"""

from __future__ import annotations

from oitbench.report import Artifact, Note, ReportContext, previews
from oitbench.report.stacks import stack
from oitbench.truths import TRUTHS

title = "Pictures and error maps"
order = 30


def build(context: ReportContext) -> list[Artifact]:
    """Write the pixels of each scene for the viewer, and its pictures and maps as one figure."""
    panels = context.results.panels()
    # A picture and an error map each.
    room = previews.room(2 * sum(len(TRUTHS) + len(panel.cells) for panel in panels))
    drawn: list[Artifact] = []
    flip = context.flip_name
    for panel in panels:
        caption = (
            "Upper picture: the image at the exposure of the scene. Lower picture: map of "
            f"{flip} against {TRUTHS[panel.truth]}, which ranks the scene. Numbers: mean {flip} "
            f"against each truth. Noise floor: the error that noise of a traced truth causes."
        )
        found = stack(context, panel, caption=caption, characters=room)
        drawn.append(found or Note(f"{panel.title}: there is no picture yet."))
    return drawn
