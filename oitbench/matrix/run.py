"""Running a matrix: unfinished cells are rendered and timed, and each is stored when it is done."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from queue import Queue
from typing import Any

import msgspec

from oitbench.errors import OitbenchError, StorageError
from oitbench.matrix import machine
from oitbench.matrix.cell import Cell
from oitbench.matrix.plan import Matrix, plan_matrix
from oitbench.matrix.pool import WorkerError, WorkerProcess
from oitbench.matrix.resume import Resume, describe
from oitbench.matrix.worker import (
    CellDone,
    CellsIdentified,
    CellsTimed,
    Greeting,
    Hello,
    IdentifyCells,
    RunCell,
    TimeCells,
)
from oitbench.plugins import Collection
from oitbench.results.schema import TROUBLED, Fingerprints, Record, Status
from oitbench.results.store import Store

OnRecord = Callable[[Cell, Record | None], None]
OnLine = Callable[[str], None]
_KINDS = ("rendering", "metrics", "references")


@dataclass
class Summary:
    """How a run ended.

    Parameters
    ----------
    statuses : dict of str to int
        Number of cells that were run, by status.
    kept : int
        Cells that an earlier run had finished.
    troubled : list of Record
        Cells of the matrix that a user should look at, also kept ones.
    wall : float
        Wall-clock seconds.
    spent : dict of str to float
        Seconds by kind of work.
    """

    statuses: dict[str, int] = field(default_factory=dict)
    kept: int = 0
    troubled: list[Record] = field(default_factory=list)
    wall: float = 0.0
    spent: dict[str, float] = field(default_factory=dict)

    @property
    def rest(self) -> float:
        """Seconds that are neither rendering, metrics nor references."""
        return max(0.0, self.wall - sum(self.spent.values()))

    def add(self, spent: dict[str, float]) -> None:
        """Add seconds by kind of work."""
        for kind, seconds in spent.items():
            self.spent[kind] = self.spent.get(kind, 0.0) + seconds

    @property
    def exit_code(self) -> int:
        """0 if all cells are well, else 1."""
        return 1 if self.troubled else 0

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


def run_matrix(
    matrix: Matrix,
    on_record: OnRecord = lambda cell, record: None,
    on_line: OnLine = lambda line: None,
) -> Summary:
    """Run all cells of a matrix that are not finished; each is on the disk when it is done.

    Parameters
    ----------
    matrix : Matrix
    on_record : callable
        Called with every record as it comes, and with None for a cell that is kept.
    on_line : callable
        Called with a line about finished cells that are run again, and why.

    Raises
    ------
    UsageError
        The results folder cannot be used.
    StorageError
        A file cannot be written. Cells that finished before are kept.
    CapabilityError
        There is no OpenGL on this machine.
    """
    start = time.perf_counter()
    summary = Summary()
    pool = [
        WorkerProcess(matrix.collections, matrix.method_folders, matrix.out)
        for _ in range(matrix.workers)
    ]
    with Store.open(matrix.out) as store:
        try:
            names = list(Collection.load(matrix.collections).methods)
            greeting = pool[0].ask(Hello(), Greeting)
            store.check_renderer(greeting.gl.renderer)
            facts = machine.collect(
                greeting.gl, argv=list(map(_plain, sys.argv)), seed=matrix.seed, methods=names
            )
            store.write_run(facts)
            rendering = _Rendering(
                matrix, Resume(store, greeting.gl, matrix.force), on_record, on_line
            )
            fresh = rendering.run(pool, summary)
            for extra in pool[1:]:
                extra.stop()
            if matrix.preset.rounds:
                _time_all(matrix, pool[0], store, summary, fresh)
            _count(matrix, store, summary, fresh)
            store.compact()
            summary.wall = time.perf_counter() - start
            wall = {"total": summary.wall, "rest": summary.rest, **summary.spent}
            store.write_run(msgspec.structs.replace(facts, wall=wall))
        finally:
            for worker in pool:
                worker.stop()
    return summary


def _plain(text: str) -> str:
    """Return a text that any file can hold; names of files need not be UTF-8."""
    return text.encode("utf-8", "backslashreplace").decode()


def _count(matrix: Matrix, store: Store, summary: Summary, fresh: set[Cell]) -> None:
    summary.kept = len(matrix.cells) - len(fresh)
    for cell in matrix.cells:
        record = store.find(cell.key)
        assert record is not None
        if cell in fresh:
            summary.statuses[record.status] = summary.statuses.get(record.status, 0) + 1
        if record.status in TROUBLED:
            summary.troubled.append(record)


@dataclass(frozen=True)
class _Rendering:
    """Distributes scenes over workers; a scene stays with one worker, which uploads it once."""

    matrix: Matrix
    resume: Resume
    on_record: OnRecord
    on_line: OnLine

    def run(self, pool: list[WorkerProcess], summary: Summary) -> set[Cell]:
        """Render and store all cells that are not kept; return them."""
        scenes: dict[str, list[Cell]] = {}
        for cell in self.matrix.cells:
            scenes.setdefault(cell.scene, []).append(cell)
        finished: Queue[tuple[Cell, CellDone | None] | str | BaseException | None] = Queue()
        free: Queue[WorkerProcess] = Queue()
        for worker in pool:
            free.put(worker)
        stopped = threading.Event()

        def render_scene(cells: list[Cell]) -> None:
            worker = free.get()
            try:
                todo = self.resume.redone(cells, lambda known: self._identify(worker, known))
                for line in describe(todo):
                    finished.put(line)
                for cell in cells:
                    if not stopped.is_set():
                        finished.put((cell, self._render(worker, cell) if cell in todo else None))
                finished.put(None)
            except BaseException as error:
                finished.put(error)
            finally:
                free.put(worker)

        fresh: set[Cell] = set()
        with ThreadPoolExecutor(len(pool)) as threads:
            for cells in scenes.values():
                threads.submit(render_scene, cells)
            try:
                left = len(scenes)
                while left:
                    item = finished.get()
                    if isinstance(item, BaseException):
                        raise item
                    if item is None:
                        left -= 1
                    elif isinstance(item, str):
                        self.on_line(item)
                    else:
                        self._take(*item, summary, fresh)
            except BaseException:
                # An interrupt or a bug must not wait for cells that nobody wants.
                stopped.set()
                for worker in pool:
                    worker.stop()
                raise
        return fresh

    def _take(self, cell: Cell, done: CellDone | None, summary: Summary, fresh: set[Cell]) -> None:
        """Store what a worker has done for a cell; None: it is kept."""
        if done is not None:
            self.resume.store.append(done.record)
            fresh.add(cell)
            summary.add(done.spent)
        self.on_record(cell, None if done is None else done.record)

    def _identify(self, worker: WorkerProcess, cells: list[Cell]) -> Sequence[Fingerprints | None]:
        try:
            reply = worker.ask(IdentifyCells(cells), CellsIdentified, self.matrix.timeout)
            return reply.fingerprints
        except OitbenchError:
            return [None] * len(cells)  # Running the cells tells what is wrong.

    def _render(self, worker: WorkerProcess, cell: Cell) -> CellDone:
        try:
            return worker.ask(RunCell(cell), CellDone, self.matrix.timeout)
        except StorageError:
            raise
        except WorkerError as error:
            status: Status = "timeout" if error.timeout else "failed"
            return CellDone(cell.record(status, str(error), gl=self.resume.gl), {})
        except OitbenchError as error:
            return CellDone(cell.record("failed", str(error), gl=self.resume.gl), {})


def _time_all(
    matrix: Matrix, worker: WorkerProcess, store: Store, summary: Summary, fresh: set[Cell]
) -> None:
    """Time the finished cells of each scene together, if one of them has no time yet."""
    scenes: dict[tuple[str, tuple[int, int]], list[tuple[Cell, Record]]] = {}
    for cell in matrix.cells:
        record = store.find(cell.key)
        if record is not None and record.finished:
            scenes.setdefault((cell.scene, cell.size), []).append((cell, record))
    for pairs in scenes.values():
        cells = [cell for cell, _ in pairs]
        if all(record.time for _, record in pairs) and not fresh & set(cells):
            continue
        request = TimeCells(cells, matrix.preset.rounds, matrix.preset.budget)
        limit = None if matrix.timeout is None else matrix.timeout * len(cells)
        try:
            reply = worker.ask(request, CellsTimed, limit)
        except OitbenchError as error:
            for _, record in pairs:
                reason = f"not timed: {error}"
                store.append(msgspec.structs.replace(record, time=None, reason=reason))
            continue
        summary.add(reply.spent)
        for (_, record), found in zip(pairs, reply.times, strict=True):
            store.append(msgspec.structs.replace(record, time=found))
