"""Running a matrix: unfinished cells are rendered and timed, and each is stored when it is done."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass, field

import msgspec

from oitbench.errors import printable
from oitbench.matrix import machine
from oitbench.matrix.plan import Matrix
from oitbench.matrix.pool import WorkerProcess
from oitbench.matrix.rendering import OnLine, OnRecord, Rendering
from oitbench.matrix.resume import Resume
from oitbench.matrix.timed_cells import ScoredCell, Timing
from oitbench.matrix.timed_scenes import due_scenes, time_scene
from oitbench.matrix.worker import CellsTimed, Greeting, Hello, TimeCells
from oitbench.results.schema import TROUBLED, Record
from oitbench.results.store import Store
from oitbench.results.times import Processor
from oitbench.scoring.folder import score_cell
from oitbench.scoring.scorer import Findings, Scorer

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
        """Seconds that are neither rendering, metrics nor references."""
        return max(0.0, self.wall - sum(self.spent.values()))

    def add(self, spent: dict[str, float]) -> None:
        """Add seconds by kind of work."""
        for kind, seconds in spent.items():
            self.spent[kind] = self.spent.get(kind, 0.0) + seconds

    @property
    def exit_code(self) -> int:
        """0 if all cells are well and all metrics have worked, else 1."""
        return 1 if self.troubled or self.faults else 0

    def __str__(self) -> str:
        done = ", ".join(f"{count} {status}" for status, count in sorted(self.statuses.items()))
        split = ", ".join(f"{kind} {self.spent.get(kind, 0.0):.1f} s" for kind in _KINDS)
        return (
            f"{done or 'nothing to do'}; {self.kept} kept from before;"
            f" {self.wall:.1f} s: {split}, rest {self.rest:.1f} s"
        )


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
        WorkerProcess(matrix.plugins, matrix.out, matrix.memory_limit)
        for _ in range(matrix.workers)
    ]
    with (
        Scorer(matrix.metrics, matrix.memory_limit, matrix.timeout) as scorer,
        Store.open(matrix.out) as store,
    ):
        try:
            greeting = pool[0].ask(Hello(), Greeting, retry=True)
            store.check_renderer(greeting.gl.renderer)
            facts = machine.collect(
                greeting.gl,
                argv=list(map(printable, sys.argv)),
                seed=matrix.seed,
                methods=matrix.methods,
            )
            store.write_run(facts)
            store.write_config(matrix.config)
            resume = Resume(store, greeting.gl, matrix.force)
            rendering = Rendering(matrix, resume, on_record, on_line)
            rendering.run(pool)
            for spent in rendering.spent:
                summary.add(spent)
            for extra in pool[1:]:
                extra.stop()
            _score_all(matrix, store, summary, scorer)
            if matrix.preset.rounds:
                _time_all(matrix, pool[0], store, summary, rendering, facts.cpu)
            _count(matrix, store, summary, rendering)
            store.compact()
            summary.wall = time.perf_counter() - start
            wall = {"total": summary.wall, "rest": summary.rest, **summary.spent}
            store.write_run(msgspec.structs.replace(facts, wall=wall))
        finally:
            for worker in pool:
                worker.stop()
    return summary


def _count(matrix: Matrix, store: Store, summary: Summary, rendering: Rendering) -> None:
    summary.kept = len(matrix.cells) - len(rendering.fresh)
    for cell in matrix.cells:
        record = rendering.unstored.get(cell) or store.find(cell.key)
        assert record is not None
        if cell in rendering.fresh:
            summary.statuses[record.status] = summary.statuses.get(record.status, 0) + 1
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
    worker: WorkerProcess,
    store: Store,
    summary: Summary,
    rendering: Rendering,
    cpu: Processor | None,
) -> None:
    """Time the finished cells of each scene together, if one of them has no time yet."""
    schedule = matrix.schedule

    def ask(cells: list[ScoredCell]) -> list[Timing]:
        limit = None if matrix.timeout is None else matrix.timeout * len(cells)
        request = TimeCells(cells, schedule.rounds, schedule.budget, schedule.seed)
        reply = worker.ask(request, CellsTimed, limit)
        summary.add(reply.spent)
        return reply.timings

    usable = [cell for cell in matrix.cells if cell not in rendering.unstored]
    known = [(cell, store.find(cell.key)) for cell in usable]
    pairs = [(cell, record) for cell, record in known if record is not None]
    for scene in due_scenes(pairs, rendering.fresh, cpu, schedule):
        for record in time_scene(scene, ask):
            store.append(record)
            if record.time is not None and record.time.block.disturbed:
                summary.disturbed[record.seen] = record.time.block.foreign or 0.0
