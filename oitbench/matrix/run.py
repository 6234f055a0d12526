"""Running a matrix: unfinished cells are rendered and timed, and each is stored when it is done."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import msgspec

from oitbench.errors import UsageError, printable
from oitbench.executors.executor import Executor, Worker
from oitbench.matrix.cell import Cell
from oitbench.matrix.plan import Matrix
from oitbench.matrix.rendering import OnLine, OnRecord, OnStage, Rendering
from oitbench.matrix.resume import Resume
from oitbench.matrix.timed_cells import ScoredCell, Timing
from oitbench.matrix.timed_scenes import due_scenes, time_scene
from oitbench.matrix.worker import (
    CellsTimed,
    CollectFacts,
    FactsCollected,
    Greeting,
    Hello,
    TimeCells,
    far_end,
)
from oitbench.results.schema import TROUBLED, Record, Renderer
from oitbench.results.store import Store
from oitbench.results.times import Processor
from oitbench.scoring.folder import score_cell
from oitbench.scoring.scorer import Findings, Scorer

KINDS = ("building", "rendering", "permutations", "metrics", "references", "timing")
"""Kinds of work whose seconds are counted apart."""
OnTimed = Callable[[Sequence[Cell], float], None]


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
    scenes : dict of str to float
        Seconds of the cells of each scene that were run, timing included, by the scene's label.
    disturbed : dict of str to float
        Share of the CPU time that other processes took, by the label of each scene whose times
        they disturbed.
    faults : list of str
        Why metrics of users' files have no value, one line each.
    """

    statuses: dict[str, int] = field(default_factory=dict)
    kept: int = 0
    troubled: list[Record] = field(default_factory=list)
    wall: float = 0.0
    spent: dict[str, float] = field(default_factory=dict)
    scenes: dict[str, float] = field(default_factory=dict)
    disturbed: dict[str, float] = field(default_factory=dict)
    faults: list[str] = field(default_factory=list)

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
        """Seconds that are of no kind in `KINDS`."""
        return max(0.0, self.wall - sum(self.spent.values()))

    def add(self, spent: dict[str, float]) -> None:
        """Add seconds by kind of work."""
        for kind, seconds in spent.items():
            self.spent[kind] = self.spent.get(kind, 0.0) + seconds

    def add_scene(self, label: str, seconds: float) -> None:
        """Add seconds of the scene of a label."""
        self.scenes[label] = self.scenes.get(label, 0.0) + seconds

    @property
    def exit_code(self) -> int:
        """0 if all cells are well and all metrics have worked, else 1."""
        return 1 if self.troubled or self.faults else 0

    def __str__(self) -> str:
        done = ", ".join(f"{count} {status}" for status, count in sorted(self.statuses.items()))
        return f"{done or 'nothing to do'}; {self.kept} kept from before; {self.wall:.1f} s"


def run_matrix(
    matrix: Matrix,
    on_record: OnRecord = lambda cell, record: None,
    on_line: OnLine = lambda line: None,
    on_stage: OnStage = lambda labels, stage: None,
    on_timed: OnTimed = lambda cells, seconds: None,
) -> Summary:
    """Run all cells of a matrix that are not finished; each is on the disk when it is done.

    Parameters
    ----------
    matrix : Matrix
    on_record : callable
        Called with every record as it comes, and with None for a cell that is kept.
    on_line : callable
        Called with a line about finished cells that are run again, and why.
    on_stage : callable
        Called with the labels of a scene and a method, or of a scene, and the part of its work
        that begins, by any thread.
    on_timed : callable
        Called with cells that were timed together, and the seconds that this took.

    Raises
    ------
    UsageError
        The results folder cannot be used.
    StorageError
        A file cannot be written. Cells that finished before are kept.
    CapabilityError
        No worker has OpenGL.
    """
    start = time.perf_counter()
    summary = Summary()
    far = far_end(matrix.plugins, matrix.out)
    with (
        Scorer(matrix.metrics, matrix.memory_limit, matrix.timeout) as scorer,
        matrix.place.open(far, on_line) as executor,
        Store.open(matrix.out) as store,
    ):
        admission = _Admission(store)
        executor.admit(admission.check)
        request = CollectFacts(list(map(printable, sys.argv)), matrix.seed, list(matrix.methods))
        facts = executor.ask(request, FactsCollected).facts
        store.write_run(facts)
        store.write_config(matrix.config)
        resume = Resume(store, admission.renderer, matrix.force)
        rendering = Rendering(matrix, resume, on_record, on_line, on_stage)
        rendering.run(executor)
        for spent in rendering.spent:
            summary.add(spent)
        executor.rest()
        _score_all(matrix, store, summary, scorer)
        if matrix.preset.rounds:
            listener = on_stage, on_timed
            _time_all(matrix, executor, store, summary, rendering, facts.cpu, *listener)
        _count(matrix, store, summary, rendering)
        store.compact()
        summary.wall = time.perf_counter() - start
        wall = {"total": summary.wall, "rest": summary.rest, **summary.spent}
        store.write_run(msgspec.structs.replace(facts, wall=wall))
    return summary


class _Admission:
    """Admits workers of one renderer: that of the folder's cells, else that of the first worker."""

    def __init__(self, store: Store) -> None:
        self._store = store
        self._renderer: Renderer | None = None

    @property
    def renderer(self) -> Renderer:
        """The renderer of all workers that were admitted."""
        assert self._renderer is not None
        return self._renderer

    def check(self, worker: Worker) -> None:
        """Raise `OitbenchError` if a worker cannot render, or renders with something else."""
        found = worker.ask(Hello(), Greeting, retry=True).gl
        self._store.check_renderer(found.renderer)
        self._renderer = self._renderer or found
        if found != self._renderer:
            raise UsageError(
                f"it renders with '{found.renderer}', {found.version}, and the others with"
                f" '{self._renderer.renderer}', {self._renderer.version}; use another folder for it"
            )


def _count(matrix: Matrix, store: Store, summary: Summary, rendering: Rendering) -> None:
    summary.kept = len(matrix.cells) - len(rendering.fresh)
    for cell in matrix.cells:
        record = rendering.unstored.get(cell) or store.find(cell.key)
        assert record is not None
        if cell in rendering.fresh:
            summary.statuses[record.status] = summary.statuses.get(record.status, 0) + 1
            summary.add_scene(record.seen, record.seconds)
        if record.status in TROUBLED:
            summary.troubled.append(record)


def _score_all(matrix: Matrix, store: Store, summary: Summary, scorer: Scorer) -> None:
    """Score the cells that lack a metric of a user's file, or have it of an earlier file."""
    start, findings = time.perf_counter(), Findings()
    for cell in matrix.cells:
        record = store.find(cell.key)
        if record is not None and not scorer.is_current(record):
            score_cell(store, record, scorer, findings)
    summary.faults = findings.lines
    summary.add({"metrics": time.perf_counter() - start})


def _time_all(
    matrix: Matrix,
    executor: Executor,
    store: Store,
    summary: Summary,
    rendering: Rendering,
    cpu: Processor | None,
    on_stage: OnStage,
    on_timed: OnTimed,
) -> None:
    """Time the finished cells of each scene together, if one of them has no time yet."""
    schedule = matrix.schedule

    def ask(cells: list[ScoredCell]) -> list[Timing]:
        limit = None if matrix.timeout is None else matrix.timeout * len(cells)
        request = TimeCells(cells, schedule.rounds, schedule.budget, schedule.seed)
        first, start = cells[0].cell, time.perf_counter()
        reply = executor.ask(
            request, CellsTimed, limit, on_step=lambda step: on_stage(first.seen, step.name)
        )
        seconds = time.perf_counter() - start
        summary.add(reply.spent)
        summary.add_scene(first.seen, seconds)
        on_timed([scored.cell for scored in cells], seconds)
        return reply.timings

    usable = [cell for cell in matrix.cells if cell not in rendering.unstored]
    known = [(cell, store.find(cell.key)) for cell in usable]
    pairs = [(cell, record) for cell, record in known if record is not None]
    for scene in due_scenes(pairs, rendering.fresh, cpu, schedule):
        for record in time_scene(scene, ask):
            store.append(record)
            if record.time is not None and record.time.block.disturbed:
                summary.disturbed[record.seen] = record.time.block.foreign or 0.0
