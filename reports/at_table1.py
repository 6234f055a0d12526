"""Counts and memory of four scenes beside those of a paper.

The paper renders 1280 × 720 pixels; its scenes are not public, and those of this suite stand for
them. Bytes per pixel and fragments per pixel compare runs of other sizes; the paper's follow from
its counts and its megabytes of 2²⁰ bytes. Lists hold all fragments, maps are in fixed memory.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from oitbench.papers import Album, Finding, caption, needs_of, read_paper
from oitbench.report import Artifact, Column, Note, ReportContext, columns, write_table
from oitbench.report.artifacts import Row, Value
from oitbench.results.table import MEBIBYTE

title = "Counts and memory of scenes"

PAPER = read_paper(Path(__file__).parent / "papers" / "at2011.toml")
KINDS = {"lists": "AT", "maps": "OSMTF", "samples": "ST"}
"""The method whose memory a column has."""
ABOUT = 0.05
"""Relative difference of numbers that are about the same."""
_PIXELS = 1280 * 720


@dataclass(frozen=True)
class _Published:
    """A row of the paper's table: worst depth complexity, fragments, and MiB by kind of storage."""

    worst: int
    fragments: float
    mebibytes: dict[str, float]

    def bytes_per_pixel(self, kind: str) -> float:
        """Return the memory of a kind of storage divided by the paper's pixels."""
        return self.mebibytes[kind] * MEBIBYTE / _PIXELS


PUBLISHED = {
    "SMOKE": _Published(312, 10.6e6, {"lists": 125.4, "maps": 63.3, "samples": 93.8}),
    "HAIR": _Published(663, 15.0e6, {"lists": 174.6, "maps": 63.3, "samples": 65.0}),
    "FOREST": _Published(45, 6.0e6, {"lists": 72.6, "maps": 63.3, "samples": 36.9}),
    "PWRPLANT": _Published(35, 2.69e6, {"lists": 30.8, "maps": 63.3, "samples": 65.0}),
}
PICTURES = {
    (name, kind): PAPER.picture(name, method)
    for name in PUBLISHED
    for kind, method in KINDS.items()
}
needs = needs_of(PICTURES.values())
_COLUMNS = (
    Column("paper_scene", "Paper", kind="text"),
    columns.SCENE,
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
    """Write one row for each scene of the paper."""
    album = Album(context, needs)
    rows = list(filter(None, (_row(album, name) for name in PUBLISHED)))
    if not rows:
        return [Note("The results have no cell of this table.")]
    text = caption(album, "Numbers per pixel beside those of the paper.", _findings(album))
    path = context.out / "at_table1.csv"
    return [write_table(path, _COLUMNS, rows, title="Counts and memory", caption=text)]


def _row(album: Album, name: str) -> Row | None:
    """Return the row of a scene; None if no method has finished there."""
    published = PUBLISHED[name]
    pictures = {kind: PICTURES[name, kind] for kind in KINDS}
    found = {kind: record for kind in KINDS if (record := album.record(pictures[kind]))}
    record = next(iter(found.values()), None)
    if record is None or record.outcome is None:
        return None
    statistics = record.outcome.statistics
    values: dict[str, Value] = {
        "paper_scene": name,
        "scene": record.seen,
        "size": "{} × {}".format(*record.size),
        "worst": statistics.complexity.worst,
        "paper_worst": published.worst,
        "fragments": statistics.fragments,
        "per_pixel": statistics.fragments / math.prod(record.size),
        "paper_per_pixel": published.fragments / _PIXELS,
        "methods": ", ".join(record.method for record in found.values()),
    }
    for kind in KINDS:
        outcome = album.outcome(pictures[kind])
        values[kind] = outcome.memory.bits_per_pixel / 8 if outcome else None
        values[f"paper_{kind}"] = published.bytes_per_pixel(kind)
    return tuple(values.get(column.key) for column in _COLUMNS)


def _findings(album: Album) -> Iterator[Finding]:
    """Compare the bytes per pixel of storage that does not depend on the scene."""
    for (name, kind), picture in PICTURES.items():
        if kind == "lists":
            continue
        outcome = album.outcome(picture)
        wanted = PUBLISHED[name].bytes_per_pixel(kind)
        text = f"{wanted:.0f} bytes per pixel for {kind} in {name}"
        if outcome is None:
            yield Finding(text, None)
            continue
        have = outcome.memory.bits_per_pixel / 8
        yield Finding(f"{text} ({have:.0f})", abs(have / wanted - 1) <= ABOUT)
