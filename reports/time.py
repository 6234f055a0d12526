"""The parts of each frame's time.

Sorting and the passes belong to the method. Shading, in gray, is the same for all methods of a
scene: shadow maps, ambient occlusion and the opaque picture. The passes are timed one by one, in
frames of their own, so they can add up to more than the method time at the end of the bar, which is
that of whole frames.
"""

from __future__ import annotations

from collections.abc import Iterator

from oitbench.report import (
    Artifact,
    Column,
    Note,
    ReportContext,
    accounts,
    columns,
    decimal,
    palette,
    times,
)
from oitbench.report.accounts import Account, Bar, Block
from oitbench.report.artifacts import Marked, Row
from oitbench.results.records import Panel
from oitbench.results.schema import Outcome, Record
from oitbench.results.times import Interval, Time

title = "Time"
order = 38

_SORTING, _SHADING = "#4d4d4d", "#d4d4d4"
# The last pass of a bar is mixed with this share of white, the first one with none.
_LIGHTEST = 0.62


def build(context: ReportContext) -> list[Artifact]:
    """Draw a figure per scene, and list all parts."""
    if not any(record.time for record in context.results.records):
        return [Note("No cell has been timed yet.")]
    return accounts.build(context, _ACCOUNT)


def _parts(time: Time) -> list[tuple[str, Interval]]:
    """Return the parts of the method: sorting, and passes."""
    sorting = [] if time.sort_ms is None else [("sorting", time.sort_ms)]
    return sorting + [(part.name, part.ms) for part in time.passes]


def _bar(context: ReportContext, cell: Record, outcome: Outcome) -> Bar:
    """Return one block per part of the method, in tints of its color, and one for shading."""
    time = cell.time
    if time is None:
        return Bar((), "not timed")
    color, steps = context.style(cell.method).color, max(1, len(time.passes) - 1)
    tints = [palette.mix(color, "#ffffff", _LIGHTEST * k / steps) for k in range(steps + 1)]
    colors = tints if time.sort_ms is None else [_SORTING, *tints]
    blocks = [
        Block(name, ((tint, part.median),))
        for (name, part), tint in zip(_parts(time), colors, strict=False)
    ]
    shading = Block("shading", ((_SHADING, time.shading_ms.median),))
    method, frame = (decimal(part.median) for part in (time.method_ms, time.frame_ms))
    total = f"method {method} ms   frame {frame} ms"
    return Bar((*blocks, shading), times.signed(total, time.block.disturbed))


def _rows(panel: Panel, cell: Record, outcome: Outcome) -> Iterator[Row]:
    time = cell.time
    if time is None:
        return
    listed = [("method", name, part) for name, part in _parts(time)]
    listed += [("shading", part.name, part.ms) for part in time.shading]
    for owner, name, part in listed:
        values = (part.median, *(part.ends or (None, None)))
        if time.block.disturbed:
            values = tuple(value if value is None else Marked(value) for value in values)
        remark = time.remark if owner == "method" else ""
        yield (panel.title, cell.method, owner, name, *values, len(part.samples), remark)


_ACCOUNT = Account(
    name="time",
    axis="time, ms",
    caption="Median times: sorting and passes of each method, in order, and in gray the shading "
    "that all methods share. The numbers are the times of whole frames. "
    f"{times.SHORT_EXPLANATION}.",
    room=1.35,
    columns=(
        columns.SCENE,
        columns.METHOD,
        Column("owner", "Of", kind="text"),
        Column("part", "Part", kind="text"),
        Column("ms", "Median", "ms"),
        Column("ms_low", "Low", "ms"),
        Column("ms_high", "High", "ms"),
        Column("rounds", "Rounds"),
        Column("remark", "Remark", kind="text"),
    ),
    table_title="All parts",
    table_caption="Parts of each frame, timed one by one, with their intervals. A remark says why "
    "the passes of a method do not add up to their time in a whole frame.",
    bar=_bar,
    rows=_rows,
    legend={"sorting on the CPU": _SORTING, "shading, shared by all methods": _SHADING},
)
