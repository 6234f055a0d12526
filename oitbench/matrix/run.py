"""Running a matrix: unfinished cells are rendered and timed, and each is stored when it is done."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from queue import Empty, Queue
from typing import Any

import msgspec

from oitbench.errors import OitbenchError
from oitbench.matrix import machine
from oitbench.matrix.cell import Cell
from oitbench.matrix.plan import Matrix, plan_matrix
from oitbench.matrix.pool import WorkerProcess
from oitbench.matrix.timed_cells import ScoredCell, Timing
from oitbench.matrix.timed_scenes import due_scenes, time_scene
from oitbench.matrix.worker import CellDone, CellsTimed, Greeting, Hello, RunCell, TimeCells
from oitbench.results.schema import Record
from oitbench.results.store import Store
from oitbench.results.times import Processor
from oitbench.workers.process import WorkerError

OnRecord = Callable[[Cell, Record], None]
Done = tuple[Cell, CellDone] | BaseException
_WAKE_SECONDS = 1.0
_KINDS = ("rendering", "metrics", "references")


@dataclass
class Summary:
    """How a run ended.

    Parameters
    ----------
    statuses : dict of str to int
        Number of records by status.
    kept : int
        Cells that an earlier run had finished.
    wall : float
        Wall-clock seconds.
    spent : dict of str to float
        Seconds by kind of work.
    disturbed : dict of str to float
        Share of the CPU time that other processes took, by the label of each scene whose times
        they disturbed.
    """

    statuses: dict[str, int] = field(default_factory=dict)
    kept: int = 0
    wall: float = 0.0
    spent: dict[str, float] = field(default_factory=dict)
    disturbed: dict[str, float] = field(default_factory=dict)

    @property
    def warning(self) -> str:
        """A line about times that other processes disturbed, or ""."""
        if not self.disturbed:
            return ""
        return (
            f"other processes took up to {max(self.disturbed.values()):.0%} of the CPU time while"
            f" {', '.join(self.disturbed)} was timed; run with --force on an idle machine"
        )

    @property
    def rest(self) -> float:
        """Seconds that are neither rendering, metrics nor references."""
        return max(0.0, self.wall - sum(self.spent.values()))

    def add(self, spent: dict[str, float]) -> None:
        """Add seconds by kind of work."""
        for kind, seconds in spent.items():
            self.spent[kind] = self.spent.get(kind, 0.0) + seconds

    def __str__(self) -> str:
        done = ", ".join(f"{count} {status}" for status, count in sorted(self.statuses.items()))
        split = ", ".join(f"{kind} {self.spent.get(kind, 0.0):.1f} s" for kind in _KINDS)
        return (
            f"{done or 'nothing to do'}; {self.kept} kept from before;"
            f" {self.wall:.1f} s: {split}, rest {self.rest:.1f} s"
        )


def run(
    scenes: Sequence[str] = (),
    methods: Sequence[str] = (),
    preset: str = "quick",
    size: tuple[int, int] | None = None,
    out: Path | str = "results",
    **options: Any,
) -> Summary:
    """Plan and run a matrix.

    Parameters
    ----------
    scenes, methods, preset, size, out
        See `plan_matrix`, as for all further options.
    """
    return run_matrix(plan_matrix(scenes, methods, preset, size, out=out, **options))


def run_matrix(matrix: Matrix, on_record: OnRecord = lambda cell, record: None) -> Summary:
    """Run all cells of a matrix that are not finished; each is on the disk when it is done.

    Parameters
    ----------
    matrix : Matrix
    on_record : callable
        Called with every record as it comes.

    Raises
    ------
    UsageError
        The results folder cannot be used.
    CapabilityError
        There is no OpenGL on this machine.
    """
    start = time.perf_counter()
    summary = Summary()
    store = Store.open(matrix.out)
    pool = [
        WorkerProcess(matrix.collections, matrix.method_folders, matrix.out, matrix.memory_limit)
        for _ in range(matrix.workers)
    ]
    try:
        greeting = pool[0].ask(Hello(), Greeting)
        facts = machine.collect(
            greeting.gl, argv=sys.argv, seed=matrix.seed, methods=matrix.methods
        )
        store.write_run(facts)
        todo = [cell for cell in matrix.cells if matrix.force or not _rendered(store, cell)]
        summary.kept = len(matrix.cells) - len(todo)
        _render_all(todo, pool, matrix, store, summary, on_record)
        for extra in pool[1:]:
            extra.stop()
        if matrix.preset.rounds:
            _time_all(matrix, pool[0], store, summary, set(todo), facts.cpu)
        for cell in todo:
            record = store.find(cell.key)
            status = record.status if record else "failed"
            summary.statuses[status] = summary.statuses.get(status, 0) + 1
        store.compact()
        summary.wall = time.perf_counter() - start
        wall = {"total": summary.wall, "rest": summary.rest, **summary.spent}
        store.write_run(msgspec.structs.replace(facts, wall=wall))
    finally:
        for worker in pool:
            worker.stop()
    return summary


def _rendered(store: Store, cell: Cell) -> bool:
    record = store.find(cell.key)
    return record is not None and record.status in ("ok", "unstable", "skipped")


def _render_all(
    todo: list[Cell],
    pool: list[WorkerProcess],
    matrix: Matrix,
    store: Store,
    summary: Summary,
    on_record: OnRecord,
) -> None:
    """Distribute scenes over the workers; a scene stays with one worker, which uploads it once."""
    scenes: dict[str, list[Cell]] = {}
    for cell in todo:
        scenes.setdefault(cell.scene, []).append(cell)
    finished: Queue[Done] = Queue()
    free: Queue[WorkerProcess] = Queue()
    for worker in pool:
        free.put(worker)
    stopped = threading.Event()

    def render_scene(cells: list[Cell]) -> None:
        worker = free.get()
        lost: WorkerError | None = None
        try:
            for cell in cells:
                if not stopped.is_set():
                    try:
                        done = _render(worker, cell, matrix, lost)
                    except WorkerError as error:
                        done = _unanswered(cell, error)
                        # The other cells need the same part, which would fail again.
                        lost = error if error.shared else None
                    finished.put((cell, done))
        except BaseException as error:
            finished.put(error)
        finally:
            free.put(worker)

    with ThreadPoolExecutor(len(pool)) as threads:
        for cells in scenes.values():
            threads.submit(render_scene, cells)
        try:
            for _ in todo:
                item = _next(finished)
                if isinstance(item, BaseException):
                    raise item
                cell, done = item
                store.append(done.record)
                summary.add(done.spent)
                on_record(cell, done.record)
        except BaseException:
            # An interrupt or a bug must not wait for cells that nobody wants.
            stopped.set()
            for worker in pool:
                worker.stop()
            raise


def _next(finished: Queue[Done]) -> Done:
    """Wait for the next item of a queue.

    Signals that a stopped process receives may reach any of its threads when it goes on. The main
    thread, which handles them, only notices them when it wakes up.
    """
    while True:
        with suppress(Empty):
            return finished.get(timeout=_WAKE_SECONDS)


def _render(
    worker: WorkerProcess, cell: Cell, matrix: Matrix, lost: WorkerError | None
) -> CellDone:
    if cell in matrix.unusable:
        return CellDone(cell.record("failed", matrix.unusable[cell]), {})
    if lost is not None:
        return _unanswered(cell, lost)
    try:
        request = RunCell(cell, matrix.preset.path_traced)
        return worker.ask(request, CellDone, matrix.timeout)
    except WorkerError:
        raise
    except OitbenchError as error:
        return CellDone(cell.record("failed", str(error)), {})


def _unanswered(cell: Cell, error: WorkerError) -> CellDone:
    return CellDone(cell.record("timeout" if error.timeout else "failed", str(error)), {})


def _time_all(
    matrix: Matrix,
    worker: WorkerProcess,
    store: Store,
    summary: Summary,
    fresh: set[Cell],
    cpu: Processor | None,
) -> None:
    """Time the finished cells of each scene together, if one of them has no time yet."""

    def ask(cells: list[ScoredCell]) -> list[Timing]:
        preset = matrix.preset
        limit = None if matrix.timeout is None else matrix.timeout * len(cells)
        request = TimeCells(cells, preset.rounds, preset.budget, matrix.seed)
        reply = worker.ask(request, CellsTimed, limit)
        summary.add(reply.spent)
        return reply.timings

    known = [(cell, store.find(cell.key)) for cell in matrix.cells]
    pairs = [(cell, record) for cell, record in known if record is not None]
    for scene in due_scenes(pairs, fresh, cpu):
        for record in time_scene(scene, ask):
            store.append(record)
            if record.time is not None and record.time.block.disturbed:
                summary.disturbed[record.scene] = record.time.block.foreign or 0.0
