"""The picture of every method, with all truths, and the map of its FLIP error.

The maps show FLIP against the truth that ranks the scene, from 0 (black) to 1 (pale yellow). Pixels
that are not finite are magenta; such pictures have no map and no error.
"""

from __future__ import annotations

from oitbench.report import Artifact, Note, ReportContext, plates
from oitbench.report.plates import Shown
from oitbench.results.records import Panel
from oitbench.truths import TRUTHS

title = "Pictures and error maps"
order = 30


def build(context: ReportContext) -> list[Artifact]:
    """Write the pictures and maps of each scene as PNG, and all of them as one figure."""
    drawn: list[Artifact] = []
    for panel in context.results.panels():
        shown = _tiles(context, panel)
        if all(item.picture is None for item in shown):
            drawn.append(Note(f"{panel.title}: there is no picture yet."))
            continue
        caption = (
            "Upper picture: the image at the exposure of the scene. Lower picture: map of "
            f"{context.flip} against {TRUTHS[panel.truth]}, which ranks the scene, from 0 (black) "
            f"to 1 (pale yellow). Numbers: mean {context.flip} against each truth. Noise floor: "
            f"{context.flip} that the noise of a traced truth alone causes."
        )
        path = context.out / f"images-{panel.slug}"
        drawn.append(plates.grid(context, panel, shown, path, title=panel.title, caption=caption))
    return drawn


def _tiles(context: ReportContext, panel: Panel) -> list[Shown]:
    """Return all truths, then every method, each with its picture and its map."""
    folder = context.out / "images" / panel.slug
    tiles = [plates.show_truth(context, panel, truth, folder) for truth in TRUTHS]
    for cell in panel.cells:
        values = tuple(text for truth in TRUTHS for text in plates.error_text(context, cell, truth))
        tiles.append(plates.show_cell(context, cell, panel.truth, folder, values=values))
    return tiles
