"""The results of a method: its rows of all main tables, and its best and worst scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple
from urllib.parse import urlencode

from oitbench.parameters import natural
from oitbench.report import columns, error_maps, plates, previews
from oitbench.report.artifacts import Column, Row, Table, fixed, write_table
from oitbench.report.cells import effect_labels
from oitbench.report.context import ReportContext
from oitbench.report.method_pages.page import Scene
from oitbench.results.pictures import PICTURE, compared
from oitbench.results.ranking import ranking
from oitbench.results.records import Panel
from oitbench.results.schema import Record
from oitbench.results.table import MEBIBYTE
from oitbench.truths import TRUTHS

_CHARACTERS = 60_000
"""Room for each picture, as an address."""


class Standing(NamedTuple):
    """A panel, and the ranks in it by method."""

    panel: Panel
    ranks: Mapping[str, str]


def main_label(name: str, cells: Sequence[Record]) -> str:
    """Return the label of the variant that stands for a method: the default one if there is one."""
    labels = sorted({cell.method for cell in cells}, key=natural)
    return name if name in labels else labels[0]


def standings(context: ReportContext) -> list[Standing]:
    """Return all panels with the ranks of their methods."""
    panels = context.results.panels()
    return [Standing(panel, ranking(panel, context.flip).ranks) for panel in panels]


def table(context: ReportContext, name: str, ranked: Sequence[Standing]) -> Table:
    """Return the cells of all variants of a method, with ranks among all methods."""
    rows: list[Row] = [
        _row(context, panel, cell, ranks.get(cell.method))
        for panel, ranks in ranked
        for cell in panel.cells
        if cell.name == name
    ]
    path = context.method_table(name, "cells")
    caption = (
        f"{context.flip} against the truth that ranks the methods of a scene, the rank by it, and "
        "all costs. Shared shading is not included."
    )
    return write_table(path, _columns(context), rows, title="All cells", caption=caption)


def _columns(context: ReportContext) -> tuple[Column, ...]:
    return (
        columns.METHOD,
        columns.SCENE,
        columns.RANKING_TRUTH,
        Column(context.flip, "FLIP", decimals=4, help="lower is better"),
        Column("rank", "Rank", kind="rank", help="among all methods; = marks ties"),
        *(columns.error(truth, context.flip) for truth in TRUTHS),
        columns.TIMES[0],
        Column("memory_mib", "Memory", "MiB", help="2^20 bytes"),
        Column("bits_per_pixel", "Memory", "bit/px"),
        Column("traffic_mib", "Traffic", "MiB", help="per frame, 2^20 bytes"),
        Column("missing_effects", "Missing effects", kind="text"),
        Column("note", "Status", kind="prose", help="unless it is ok"),
    )


def _row(context: ReportContext, panel: Panel, cell: Record, rank: str | None) -> Row:
    outcome, time = cell.outcome, cell.time
    return (
        cell.method,
        panel.title,
        cell.ranking_truth if outcome else None,
        cell.metric(cell.ranking_truth, context.flip),
        rank,
        *(cell.metric(truth, context.flip) for truth in TRUTHS),
        time.method_ms.median if time is not None else None,
        outcome.memory.bytes / MEBIBYTE if outcome else None,
        outcome.memory.bits_per_pixel if outcome else None,
        outcome.traffic.bytes / MEBIBYTE if outcome else None,
        effect_labels(cell.missing_effects),
        plates.note(cell),
    )


def extremes(context: ReportContext, label: str, ranked: Sequence[Standing]) -> tuple[Scene, ...]:
    """Return the scenes in which a variant has its least and its largest error."""
    found: list[tuple[float, Panel, Record]] = []
    for panel, _ in ranked:
        for cell in panel.finished:
            error = cell.metric(panel.truth, context.flip)
            if cell.method == label and error is not None:
                found.append((error, panel, cell))
    if not found:
        return ()
    found.sort(key=lambda item: item[0])
    chosen = {"Best scene": found[0]}
    if len(found) > 1:
        chosen["Worst scene"] = found[-1]
    return tuple(_scene(context, word, *item) for word, item in chosen.items())


def _scene(context: ReportContext, word: str, error: float, panel: Panel, cell: Record) -> Scene:
    stops = plates.exposure([cell])
    images = (
        (TRUTHS[panel.truth], plates.first_image(context, panel, panel.truth)),
        (cell.method, context.results.image(cell, _picture(cell, panel.truth))),
    )
    pictures = [
        (caption, plates.display(image, stops)) for caption, image in images if image is not None
    ]
    errors = context.flip_map(cell, panel.truth)
    if errors is not None:
        scale = error_maps.scale_of(panel.finished, panel.truth, context.flip)
        pictures.append((f"FLIP map, {scale.words}", scale.colored(errors)))
    address = urlencode({"view": panel.slug, "method": cell.method})
    return Scene(
        f"{word}: {panel.title}",
        f"Mean {context.flip} {fixed(error, 4)} against {TRUTHS[panel.truth]}.",
        address,
        tuple((caption, previews.preview(picture, _CHARACTERS)) for caption, picture in pictures),
    )


def _picture(cell: Record, truth: str) -> str:
    return compared(cell.outcome, truth) if cell.outcome is not None else PICTURE
