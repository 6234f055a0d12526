"""Targets and buffers that each method allocates.

The color and depth targets that every method uses are not counted. Shadow maps and ambient
occlusion, which all methods share, are a bar of their own.
"""

from __future__ import annotations

from collections.abc import Iterator

from oitbench.report import Artifact, Column, ReportContext, accounts, columns, decimal, palette
from oitbench.report.accounts import Account, Bar, Block
from oitbench.report.artifacts import Row
from oitbench.results.records import Panel
from oitbench.results.schema import Memory, Outcome, Record
from oitbench.results.table import MEBIBYTE

title = "Memory"
order = 40

# The last block of a bar is mixed with this share of white, the first one with none.
_LIGHTEST = 0.62


def build(context: ReportContext) -> list[Artifact]:
    """Draw a figure per scene, and list all resources."""
    return accounts.build(context, _ACCOUNT)


def _bar(context: ReportContext, cell: Record, outcome: Outcome) -> Bar:
    return _stacked(outcome.memory, context.style(cell.method).color, "no memory of its own")


def _shared(panel: Panel, outcome: Outcome) -> Bar:
    return _stacked(outcome.shading.memory, accounts.SHARED, "no shadow maps, no occlusion")


def _stacked(memory: Memory, color: str, nothing: str) -> Bar:
    """Return one block per resource, in tints of a color."""
    steps = max(1, len(memory.terms) - 1)
    blocks = tuple(
        Block(
            term.resource,
            ((palette.mix(color, "#ffffff", _LIGHTEST * place / steps), term.bytes / MEBIBYTE),),
        )
        for place, term in enumerate(memory.terms)
    )
    total = f"{decimal(memory.bytes / MEBIBYTE)} MiB   {memory.bits_per_pixel:,.0f} bit/px"
    return Bar(blocks, total if memory.bytes else nothing)


def _rows(panel: Panel, cell: Record, outcome: Outcome) -> Iterator[Row]:
    pixels = panel.size[0] * panel.size[1]
    for term in outcome.memory.terms:
        yield (
            panel.title,
            cell.method,
            term.resource,
            term.bytes,
            term.bytes / MEBIBYTE,
            8 * term.bytes / pixels,
        )


_ACCOUNT = Account(
    name="memory",
    axis="memory, MiB (2²⁰ bytes)",
    caption="Memory of each method, one block per target or buffer, in order of declaration. The "
    "numbers are the total in MiB and in bits per pixel of the picture.",
    room=1.3,
    columns=(
        columns.SCENE,
        columns.METHOD,
        Column("resource", "Resource", kind="text"),
        Column("bytes", "Bytes"),
        Column("mib", "Memory", "MiB"),
        Column("bits_per_pixel", "Bits per pixel"),
    ),
    table_title="All resources",
    table_caption="Targets and buffers that the methods declare, in bytes, in MiB (2²⁰ bytes), and "
    "in bits per pixel of the picture.",
    bar=_bar,
    shared=_shared,
    rows=_rows,
)
