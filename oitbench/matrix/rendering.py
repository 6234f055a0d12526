"""Lets workers render the cells of a matrix, and stores each when it is done."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import msgspec

from oitbench.errors import OitbenchError, StorageError
from oitbench.executors.executor import Executor, Worker
from oitbench.matrix.agenda import Agenda, SceneWork
from oitbench.matrix.cell import Cell
from oitbench.matrix.plan import Matrix
from oitbench.matrix.resume import Resume, describe
from oitbench.matrix.worker import CellDone, CellsIdentified, IdentifyCells, RunCell
from oitbench.results.schema import Fingerprints, Record, Status
from oitbench.workers.process import WorkerError

OnRecord = Callable[[Cell, Record | None], None]
OnLine = Callable[[str], None]
OnStage = Callable[[str, str], None]
_Item = tuple[Cell, CellDone | None] | str
"""A cell that is done, or kept; a line for the user."""


@dataclass
class Rendering:
    """Distributes scenes over workers; each is uploaded by as few of them as possible.

    Parameters
    ----------
    matrix : Matrix
    resume : Resume
    on_record : callable
        Called with every record as it comes, and with None for a cell that is kept.
    on_line : callable
        Called with a line about finished cells that are run again, and why.
    on_stage : callable
        Called with the labels of a cell and the part of its work that begins, by any thread.

    Attributes
    ----------
    fresh : set of Cell
        Cells that were run.
    unstored : dict of Cell to Record
        Those of them that failed before their content was known. An earlier result stays in the
        store, and its fingerprints tell later whether it is still valid.
    spent : list of dict of str to float
        Seconds by kind of work of each of them.
    """

    matrix: Matrix
    resume: Resume
    on_record: OnRecord
    on_line: OnLine
    on_stage: OnStage = lambda labels, stage: None
    fresh: set[Cell] = field(default_factory=set, init=False)
    unstored: dict[Cell, Record] = field(default_factory=dict, init=False)
    spent: list[dict[str, float]] = field(default_factory=list, init=False)

    def run(self, executor: Executor) -> None:
        """Render and store all cells that are not kept."""
        for item in executor.collect(Agenda(self.matrix.cells), self._render_scene):
            if isinstance(item, str):
                self.on_line(item)
            else:
                self._take(*item)

    def _take(self, cell: Cell, done: CellDone | None) -> None:
        """Store what a worker has done for a cell; None: it is kept."""
        if done is None:
            self.on_record(cell, None)
            return
        record, store = done.record, self.resume.store
        earlier = store.find(cell.key)
        failed = record.status in ("failed", "timeout") and record.fingerprints is None
        if failed and earlier is not None and earlier.finished:
            reason = f"{record.reason}; its earlier result stays in the folder"
            record = self.unstored[cell] = msgspec.structs.replace(record, reason=reason)
        else:
            store.append(record)
        self.fresh.add(cell)
        self.spent.append(done.spent)
        self.on_record(cell, record)

    def _render_scene(self, worker: Worker, scene: SceneWork) -> Iterator[_Item]:
        if scene.join():
            yield from self._begin(worker, scene)
        first = True
        for cell in scene.take():
            try:
                done = self._render(worker, cell, scene.lost)
            except WorkerError as error:
                done = self._unanswered(cell, error)
                if error.shared:
                    # The other cells need the same part, which would fail again.
                    scene.lost = error
            if done.record.fingerprints is None and scene.content.get(cell) is not None:
                known = msgspec.structs.replace(done.record, fingerprints=scene.content[cell])
                done = msgspec.structs.replace(done, record=known)
            scene.count(done.record.seconds, first=first)
            first = False
            yield cell, done

    def _begin(self, worker: Worker, scene: SceneWork) -> Iterator[_Item]:
        """Choose the cells to draw, and yield the others."""

        def identify(known: list[Cell]) -> Sequence[Fingerprints | None]:
            scene.content.update(zip(known, self._identify(worker, known), strict=True))
            return [scene.content[cell] for cell in known]

        todo = self.resume.redone(scene.cells, identify)
        yield from describe(todo)
        yield from ((cell, None) for cell in scene.cells if cell not in todo)
        scene.begin(todo)

    def _identify(self, worker: Worker, cells: list[Cell]) -> Sequence[Fingerprints | None]:
        usable = [cell for cell in cells if cell not in self.matrix.unusable]
        try:
            request, limit = IdentifyCells(usable), self.matrix.timeout
            # A worker that was killed from outside must not cost the results of earlier runs.
            reply = worker.ask(request, CellsIdentified, limit, retry=True)
        except OitbenchError:
            return [None] * len(cells)  # Running the cells tells what is wrong.
        found = dict(zip(usable, reply.fingerprints, strict=True))
        return [found.get(cell) for cell in cells]

    def _render(self, worker: Worker, cell: Cell, lost: WorkerError | None) -> CellDone:
        if cell in self.matrix.unusable:
            return self._failed(cell, self.matrix.unusable[cell])
        if lost is not None:
            return self._unanswered(cell, lost)
        try:
            return worker.ask(
                RunCell(cell),
                CellDone,
                self.matrix.timeout,
                on_step=lambda step: self.on_stage(f"{cell.seen} {cell.method}", step.name),
            )
        except (StorageError, WorkerError):
            raise
        except OitbenchError as error:
            return self._failed(cell, str(error))

    def _failed(self, cell: Cell, reason: str) -> CellDone:
        return CellDone(cell.record("failed", reason, gl=self.resume.gl), {})

    def _unanswered(self, cell: Cell, error: WorkerError) -> CellDone:
        status: Status = "timeout" if error.timeout else "failed"
        return CellDone(cell.record(status, str(error), gl=self.resume.gl), {})
