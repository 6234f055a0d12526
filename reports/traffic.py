"""Bytes that each method reads and writes per frame, by pass, resource and kind of access.

The bytes are algorithmic, without caches and compression: the bytes per item of the declared
formats times the measured number of items. Those of shadow maps and ambient occlusion, which all
methods share, are a bar of their own.
"""

from __future__ import annotations

from collections.abc import Iterator

from oitbench.report import Artifact, Column, ReportContext, accounts, columns, decimal, palette
from oitbench.report.accounts import Account, Bar, Block
from oitbench.report.artifacts import Row
from oitbench.results.records import Panel
from oitbench.results.schema import Outcome, Record, Traffic
from oitbench.results.table import MEBIBYTE

title = "Memory traffic"
order = 50

_COLORS = palette.categories(("atomic", "blend", "clear", "read", "write"))


def build(context: ReportContext) -> list[Artifact]:
    """Draw a figure per scene, and list all terms."""
    return accounts.build(context, _ACCOUNT)


def _bar(context: ReportContext, cell: Record, outcome: Outcome) -> Bar:
    return _stacked(outcome.traffic)


def _shared(panel: Panel, outcome: Outcome) -> Bar:
    return _stacked(outcome.shading.traffic)


def _stacked(traffic: Traffic) -> Bar:
    """Return one block per pass, in order, divided by kind of access."""
    passes: dict[str, dict[str, float]] = {}
    for term in traffic.terms:
        kinds = passes.setdefault(term.pass_, {})
        color = _COLORS[term.kind]
        kinds[color] = kinds.get(color, 0.0) + term.bytes / MEBIBYTE
    blocks = tuple(Block(name, tuple(kinds.items())) for name, kinds in passes.items())
    return Bar(blocks, f"{decimal(traffic.bytes / MEBIBYTE)} MiB")


def _rows(panel: Panel, cell: Record, outcome: Outcome) -> Iterator[Row]:
    for term in outcome.traffic.terms:
        yield (
            panel.title,
            cell.method,
            term.pass_,
            term.resource,
            term.kind,
            term.items,
            term.bytes_per_item,
            term.bytes,
        )


_ACCOUNT = Account(
    name="traffic",
    axis="traffic per frame, MiB (2²⁰ bytes)",
    caption="Bytes that a frame reads and writes, without caches and compression. Each block is "
    "one pass, divided by kind of access; the number is the total in MiB. Blend: read for "
    "blending or for a depth test that writes. Atomic: a read and a write.",
    room=1.16,
    columns=(
        columns.SCENE,
        columns.METHOD,
        Column("pass", "Pass", kind="text"),
        Column("resource", "Resource", kind="text"),
        Column("kind", "Access", kind="text"),
        Column("items", "Items"),
        Column("bytes_per_item", "Per item", "B"),
        Column("bytes", "Bytes"),
    ),
    table_title="All terms",
    table_caption="Each total above is the sum of its terms. Bytes are items × bytes per item.",
    bar=_bar,
    shared=_shared,
    rows=_rows,
    legend=_COLORS,
)
