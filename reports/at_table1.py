"""Counts and memory of four scenes beside those of a paper.

Arranged as table 1 of Salvi et al. 2011, "Adaptive Transparency", which renders at 1280 × 720. The
scenes here stand for those of the paper, which are not public. Numbers per pixel compare runs of
other sizes; the paper's follow from its counts and megabytes of 2²⁰ bytes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from oitbench.parameters import parse
from oitbench.report import Artifact, Column, Note, ReportContext, columns, write_table
from oitbench.report.artifacts import Row, Value
from oitbench.results.records import Panel
from oitbench.results.schema import Outcome
from oitbench.results.table import MEBIBYTE

title = "Scenes of Adaptive Transparency"
order = 6

_PIXELS = 1280 * 720
_KINDS = {
    "adaptive": "lists",
    "opacity_map": "maps",
    "fourier_map": "maps",
    "stochastic": "samples",
}
"""Kind of storage of a method."""


@dataclass(frozen=True)
class _Published:
    """A row of the paper's table: worst depth complexity, fragments, and MiB by kind of storage."""

    name: str
    worst: int
    fragments: float
    mebibytes: dict[str, float]


_PUBLISHED = {
    "smoke_yard": _Published("SMOKE", 312, 10.6e6, {"lists": 125.4, "maps": 63.3, "samples": 93.8}),
    "hair": _Published("HAIR", 663, 15.0e6, {"lists": 174.6, "maps": 63.3, "samples": 65.0}),
    "forest": _Published("FOREST", 45, 6.0e6, {"lists": 72.6, "maps": 63.3, "samples": 36.9}),
    "power_plant": _Published(
        "POWER PLANT", 35, 2.69e6, {"lists": 30.8, "maps": 63.3, "samples": 65.0}
    ),
}
_COLUMNS = (
    columns.SCENE,
    Column("paper_scene", "Paper", kind="text"),
    Column("size", "Size", "px", kind="text"),
    Column("worst", "Worst", help="the largest number of transparent fragments at a pixel"),
    Column("paper_worst", "Paper's"),
    Column("fragments", "Fragments", help="transparent, and not behind an opaque surface"),
    Column("per_pixel", "Per pixel", decimals=2, help="fragments divided by pixels"),
    Column("paper_per_pixel", "Paper's", decimals=2),
    Column("lists", "Lists", "B/px", decimals=0, help="memory of adaptive transparency"),
    Column("paper_lists", "Paper's", "B/px", decimals=0),
    Column("maps", "Maps", "B/px", decimals=0, help="memory of opacity or Fourier maps"),
    Column("paper_maps", "Paper's", "B/px", decimals=0),
    Column("samples", "Samples", "B/px", decimals=0, help="memory of stochastic transparency"),
    Column("paper_samples", "Paper's", "B/px", decimals=0),
    Column("methods", "Methods", kind="text", help="those whose memory is given"),
)


def build(context: ReportContext) -> list[Artifact]:
    """Write one row for each view of a scene of the paper at each size."""
    rows = [*_rows(context)]
    if not rows:
        names = ", ".join(_PUBLISHED)
        return [Note(f"No cell of {names} has finished yet.")]
    caption = (
        "Table 1 of Salvi et al. 2011 beside the scenes that stand for its own. The paper renders "
        "1280 × 720 pixels, one sample each; fragments are counted at the centers of pixels. The "
        "number of samples and nodes differs by scene there and is that of the named methods here."
    )
    table = context.out / "at_table1.csv"
    return [write_table(table, _COLUMNS, rows, title="Counts and memory", caption=caption)]


def _rows(context: ReportContext) -> Iterator[Row]:
    for panel in context.results.panels():
        cell = next(iter(panel.finished), None)
        published = _PUBLISHED.get(parse(panel.scene).name) if cell else None
        if cell is None or cell.outcome is None or published is None:
            continue
        found = cell.outcome.statistics
        values: dict[str, Value] = {
            "scene": panel.title,
            "paper_scene": published.name,
            "size": "{} × {}".format(*panel.size),
            "worst": found.complexity.worst,
            "paper_worst": published.worst,
            "fragments": found.fragments,
            "per_pixel": found.fragments / math.prod(panel.size),
            "paper_per_pixel": published.fragments / _PIXELS,
        }
        methods = []
        for kind, (label, outcome) in _stored(panel).items():
            values[kind] = outcome.memory.bits_per_pixel / 8
            methods.append(label)
        for kind, size in published.mebibytes.items():
            values[f"paper_{kind}"] = size * MEBIBYTE / _PIXELS
        values["methods"] = ", ".join(methods)
        yield tuple(values.get(column.key) for column in _COLUMNS)


def _stored(panel: Panel) -> dict[str, tuple[str, Outcome]]:
    """Return the first method of each kind of storage, with its outcome."""
    found: dict[str, tuple[str, Outcome]] = {}
    for cell in panel.finished:
        kind = _KINDS.get(cell.name)
        if kind and cell.outcome:
            found.setdefault(kind, (cell.method, cell.outcome))
    return found
