"""The picture of every method, with both truths, and the map of its FLIP error.

The maps show FLIP against exact compositing, from 0 (black) to 1 (pale yellow). Pixels that are not
finite are magenta; such pictures have no map and no error.
"""

from __future__ import annotations

from oitbench.report import Artifact, Note, ReportContext, plates
from oitbench.report.plates import Shown
from oitbench.results.records import Panel
from oitbench.results.schema import EXACT, TRUTHS

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
            f"{context.flip} against exact compositing, from 0 (black) to 1 (pale yellow). Numbers:"
            f" mean {context.flip} against both truths. Noise floor: {context.flip} between two "
            "halves of the samples of the path-traced reference."
        )
        path = context.out / f"images-{panel.slug}"
        drawn.append(plates.grid(context, panel, shown, path, title=panel.title, caption=caption))
    return drawn


def _tiles(context: ReportContext, panel: Panel) -> list[Shown]:
    """Return both truths, then every method, each with its picture and its map."""
    folder = context.out / "images" / panel.slug
    tiles = [plates.show_truth(context, panel, truth, folder) for truth in TRUTHS]
    for cell in panel.cells:
        values = tuple(text for truth in TRUTHS for text in plates.error_text(context, cell, truth))
        tiles.append(plates.show_cell(context, cell, EXACT, folder, values=values))
    return tiles
