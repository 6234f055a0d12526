"""What the methods look like: every picture beside both truths, its FLIP map beneath.

The maps show FLIP against exact compositing on the magma scale from 0 (black) to 1. Pixels that are
not finite are magenta.
"""

from __future__ import annotations

from pathlib import Path

from oitbench.report import Artifact, ImageGrid, Note, Tile, fixed, plates
from oitbench.report.plates import Shown
from oitbench.results import records as read
from oitbench.results.records import EXACT, PATH_TRACED, TRUTHS, Panel, Results
from oitbench.results.store import Record

title = "Pictures and error maps"
order = 30


def build(results: Results, out: Path) -> list[Artifact]:
    """Write each scene's pictures and maps as PNG, and all of them as one figure."""
    drawn: list[Artifact] = []
    for panel in results.panels():
        shown = _tiles(results, panel, out / "images" / panel.slug)
        if any(item.picture is not None for item in shown):
            drawn.append(_grid(results, panel, shown, out))
        else:
            drawn.append(Note(f"{panel.title}: there is no picture yet."))
    return drawn or [Note("There is no cell yet.")]


def _tiles(results: Results, panel: Panel, folder: Path) -> list[Shown]:
    """Return both truths, then every cell, each with its display picture and its map."""
    truths = {kind: plates.first_image(results, panel.finished, kind) for kind in TRUTHS}
    exact, stops = truths[EXACT], plates.exposure(panel.finished)
    tiles: list[Shown] = []
    for kind, name in TRUTHS.items():
        values = plates.noise(results, panel.finished) if kind == PATH_TRACED else ()
        note = "" if truths[kind] is not None else plates.why_no_truth(panel.cells, kind)
        tile = Tile(name, None, None, values, note, truth=True)
        against = exact if kind == PATH_TRACED else None
        tiles.append(plates.show(results, tile, truths[kind], against, stops, folder))
    for cell in panel.cells:
        tile = Tile(cell["method"], None, None, _values(results, cell), plates.note(cell))
        image = results.image(cell, "color") if cell["status"] in read.FINISHED else None
        tiles.append(plates.show(results, tile, image, exact, stops, folder))
    return tiles


def _values(results: Results, cell: Record) -> tuple[str, ...]:
    told = []
    for truth, name in ((EXACT, "to exact"), (PATH_TRACED, "to path traced")):
        value = read.metric(cell, truth, results.flip)
        if value is not None:
            told.append(f"{fixed(value, 4)} {name}")
    return tuple(told)


def _grid(results: Results, panel: Panel, shown: list[Shown], out: Path) -> ImageGrid:
    caption = (
        f"Top: the picture at the scene's exposure. Beneath: {results.flip} against exact "
        "compositing, from 0 (black) to 1 (pale yellow), with the mean against both truths."
    )
    path = out / f"images-{panel.slug}"
    return plates.grid(results, panel, shown, path, title=panel.title, caption=caption)
