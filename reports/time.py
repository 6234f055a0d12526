"""The sort and the passes of each method, and the shading that all share.

Shading, the last bar of each figure, is the same for all methods of a scene: shadow maps, ambient
occlusion and the opaque picture. The passes are timed one by one, in frames of their own, so they
can add up to more than the method time at the end of the bar, which is that of whole frames.
"""

from __future__ import annotations

from collections.abc import Iterator
from statistics import median

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
from oitbench.report.artifacts import Row
from oitbench.results.records import Panel
from oitbench.results.schema import Outcome, Record
from oitbench.results.times import Interval, Time

title = "Time"
order = 38

_SORT = "#4d4d4d"
# The last pass of a bar is mixed with this share of white, the first one with none.
_LIGHTEST = 0.62


def build(context: ReportContext) -> list[Artifact]:
    """Draw a figure per scene, and list all parts."""
    if not any(record.time for record in context.results.records):
        return [Note("No cell has been timed yet.")]
    return accounts.build(context, _ACCOUNT)


def _parts(time: Time) -> list[tuple[str, Interval]]:
    """Return the parts of the method: sort, and passes."""
    sort = [] if time.sort_ms is None else [("sort", time.sort_ms)]
    return sort + [(part.name, part.ms) for part in time.passes]


def _bar(context: ReportContext, cell: Record, outcome: Outcome) -> Bar:
    """Return one block per part of the method, in tints of its color."""
    time = cell.time
    if time is None:
        return Bar((), "not timed")
    color, steps = context.style(cell.method).color, max(1, len(time.passes) - 1)
    tints = [palette.mix(color, "#ffffff", _LIGHTEST * k / steps) for k in range(steps + 1)]
    colors = tints if time.sort_ms is None else [_SORT, *tints]
    blocks = tuple(
        Block(name, ((tint, part.median),))
        for (name, part), tint in zip(_parts(time), colors, strict=False)
    )
    method, frame = (decimal(part.median) for part in (time.method_ms, time.frame_ms))
    total = f"method {method} ms   frame {frame} ms"
    return Bar(blocks, times.signed(total, time.block.disturbed))


def _shared(panel: Panel, outcome: Outcome) -> Bar:
    """Return the parts of shading, each the median over all cells."""
    timed = [cell.time for cell in panel.finished if cell.time is not None]
    found: dict[str, list[float]] = {}
    for time in timed:
        for part in time.shading:
            found.setdefault(part.name, []).append(part.ms.median)
    if not timed:
        return Bar((), "not timed")
    blocks = tuple(Block(name, ((accounts.SHARED, median(ms)),)) for name, ms in found.items())
    whole = median(time.shading_ms.median for time in timed)
    return Bar(blocks, f"{decimal(whole)} ms")


def _rows(panel: Panel, cell: Record, outcome: Outcome) -> Iterator[Row]:
    time = cell.time
    if time is None:
        return
    listed = [("method", name, part) for name, part in _parts(time)]
    listed += [("shading", part.name, part.ms) for part in time.shading]
    for owner, name, part in listed:
        low, high = part.ends or (None, None)
        numbers = {"ms": part.median, "ms_low": low, "ms_high": high}
        values = times.marked(numbers, time.block.disturbed)
        remark = time.remark if owner == "method" else ""
        rounds = len(part.samples)
        yield (panel.title, cell.method, owner, name, *values.values(), rounds, remark)


_ACCOUNT = Account(
    name="time",
    axis="time, ms",
    caption="Median times: sort and passes of each method, in order. The numbers are the times of "
    "whole frames, which include shading. "
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
        columns.DISTURBED,
        Column("rounds", "Rounds"),
        Column("remark", "Remark", kind="text"),
    ),
    table_title="All parts",
    table_caption="Parts of each frame, timed one by one, with their intervals. A remark says why "
    "the passes of a method do not add up to their time in a whole frame.",
    bar=_bar,
    shared=_shared,
    rows=_rows,
    legend={"sort on the CPU, with upload": _SORT},
)
