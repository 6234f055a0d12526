"""Decides which scenes are timed, and keeps the times of all cells that did not fail."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence

import msgspec

from oitbench.errors import OitbenchError
from oitbench.fingerprints.code import timing_fingerprint
from oitbench.matrix.cell import Cell
from oitbench.matrix.timed_cells import ScoredCell, Timing
from oitbench.measure.rounds import Schedule
from oitbench.results.schema import Record
from oitbench.results.times import Processor
from oitbench.workers.process import WorkerError

Pair = tuple[Cell, Record]
Ask = Callable[[list[ScoredCell]], list[Timing]]
_NOT_TIMED = "not timed: "


def due_scenes(
    pairs: Sequence[Pair], fresh: Collection[Cell], cpu: Processor | None, schedule: Schedule
) -> list[list[Pair]]:
    """Return the finished cells of each view and size that has to be timed, as one list each.

    Cells are timed together, so one of them is enough: it is fresh, has no time, or was timed on
    another processor, in another number of rounds, or by other sources.
    """
    scenes: dict[tuple[str, tuple[int, int]], list[Pair]] = {}
    for cell, record in pairs:
        if record.finished:
            scenes.setdefault((cell.seen, cell.size), []).append((cell, record))
    return [
        group
        for group in scenes.values()
        if any(cell in fresh or not _is_current(record, cpu, schedule) for cell, record in group)
    ]


def _is_current(record: Record, cpu: Processor | None, schedule: Schedule) -> bool:
    if record.time is None:
        return False
    block = record.time.block
    same_cpu = cpu is None or block.cpu.model == cpu.model
    how = schedule.rounds, schedule.budget, timing_fingerprint()
    return same_cpu and (block.rounds, block.budget, block.code) == how


def time_scene(pairs: Sequence[Pair], ask: Ask) -> list[Record]:
    """Time the cells of one scene; return their records in order, with times or with reasons.

    If the worker does not survive, the scene is timed in two halves, and these again, until the
    cell that ends the worker is alone.

    Parameters
    ----------
    pairs : sequence of (Cell, Record)
    ask : callable
        Asks a worker for the times of cells.
    """
    cells = [
        ScoredCell(cell, record.outcome.plan if record.outcome else "", record.fingerprints)
        for cell, record in pairs
    ]
    try:
        timings = ask(cells)
    except WorkerError as error:
        if len(pairs) > 1:
            half = len(pairs) // 2
            return [*time_scene(pairs[:half], ask), *time_scene(pairs[half:], ask)]
        timings = [Timing(reason=str(error))]
    except OitbenchError as error:
        timings = [Timing(reason=str(error))] * len(pairs)
    return [_timed(record, timing) for (_, record), timing in zip(pairs, timings, strict=True)]


def _timed(record: Record, timing: Timing) -> Record:
    """Return the record with its times; an earlier time stays if there is no new one."""
    reason = record.reason.partition(_NOT_TIMED)[0].removesuffix("; ")
    if timing.time is not None:
        return msgspec.structs.replace(record, time=timing.time, reason=reason)
    if timing.suspect:
        return msgspec.structs.replace(record, time=None, reason=reason).suspect(timing.reason)
    reasons = [reason, _NOT_TIMED + timing.reason]
    return msgspec.structs.replace(record, reason="; ".join(filter(None, reasons)))
