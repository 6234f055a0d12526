"""Draws, scores and times the rows of other engines, each engine in a process of its own.

Frames of an engine and of its peers are drawn in turns, in shuffled rounds, each by the process
that has it open, while the others wait. A process that ends costs only the row that ended it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from msgspec.structs import replace

from oitbench.atomic import locked
from oitbench.effects import effects_of
from oitbench.engines import record
from oitbench.engines.content import require_coverage_alone
from oitbench.engines.record import PEER, EngineRow, Picture, Place
from oitbench.engines.worker import (
    Describe,
    Described,
    DrawRow,
    Reply,
    RowDrawn,
    RowTimed,
    Settings,
    TimeRow,
)
from oitbench.errors import CapabilityError, OitbenchError, SceneError, StorageError
from oitbench.image.stored import StoredImage
from oitbench.measure import rounds
from oitbench.measure.intervals import interval
from oitbench.measure.rounds import Schedule
from oitbench.method.ablation import REQUESTED
from oitbench.places import PluginFiles
from oitbench.results.pictures import PICTURE, compared
from oitbench.results.records import Results
from oitbench.results.schema import CellKey, Record
from oitbench.truths import TRUTHS
from oitbench.workers.process import Process, WorkerError

OnRow = Callable[[EngineRow], None]
_OWN = ""
"""The engine that is the suite itself."""
_MODULE = "oitbench.engines.worker"
_LOCK = "engines.lock"
_Task = tuple[str, str]
"""Names of an engine and of an algorithm, or of the suite and a method."""


@dataclass(frozen=True)
class Job:
    """Engines to run where cells have been run.

    Parameters
    ----------
    engines : sequence of str
        Names; see `oitbench.engines.known`.
    cells : sequence of CellKey
        Rows are added wherever one of them is with all effects and the default shading.
    folder : Path
        The results folder, which holds the truths of these cells.
    plugins : PluginFiles
        The files of scenes and methods.
    schedule : Schedule
        Of the rounds of each place; without rounds nothing is timed.
    timeout : float, optional
        Seconds that each step may take. None: no limit.
    memory_limit : int
        Bytes that each process may use.
    """

    engines: Sequence[str]
    cells: Sequence[CellKey]
    folder: Path
    plugins: PluginFiles
    schedule: Schedule
    timeout: float | None
    memory_limit: int


def run(job: Job, on_row: OnRow = lambda row: None) -> list[EngineRow]:
    """Return the rows of a job. They replace earlier ones in the folder place by place.

    Raises
    ------
    StorageError
        A file cannot be written.
    UsageError
        Another process runs engines in this folder.
    """
    records = {found.key: found for found in Results.load(job.folder).records}
    done: list[EngineRow] = []
    (job.folder / record.FOLDER).mkdir(exist_ok=True)
    with ExitStack() as stack, locked(job.folder / record.FOLDER / _LOCK):
        kept = {row.key: row for row in record.read(job.folder)}
        desk = _Desk(job, stack)
        known = [desk.described(name) for name in job.engines]
        for place, keys in _places(job.cells).items():
            base = [records[key] for key in keys if key in records and records[key].finished]
            started = [_started(place, blank, base) for rows in known for blank in rows]
            rows = desk.timed([desk.drawn(row, base[0]) if base else row for row in started])
            kept |= {row.key: row for row in rows}
            record.write(job.folder, kept.values())
            for row in rows:
                on_row(row)
            done += rows
    return done


def _places(cells: Iterable[CellKey]) -> dict[Place, list[CellKey]]:
    found: dict[Place, list[CellKey]] = {}
    for key in cells:
        keys = found.setdefault(Place(key.scene, key.view, key.size, key.ssaa), [])
        if key.effects == REQUESTED and not key.shading:
            keys.append(key)
    return found


def _started(place: Place, blank: EngineRow, base: Sequence[Record]) -> EngineRow:
    row = replace(blank, place=place)
    if base or row.status == "failed":
        return row
    return replace(row, reason="no cell with all effects and the default shading has finished here")


class _Desk:
    """The processes of all engines and of the suite, and the pictures of peers."""

    def __init__(self, job: Job, stack: ExitStack) -> None:
        self._job = job
        self._processes = {
            name: stack.enter_context(
                Process(_MODULE, Settings(job.plugins, job.folder, name), Reply, job.memory_limit)
            )
            for name in (_OWN, *job.engines)
        }
        self._peers: dict[tuple[Place, str], RowDrawn] = {}

    def described(self, engine: str) -> list[EngineRow]:
        """Return a row of each algorithm of an engine, in no place yet; a failed one for none."""
        blank = EngineRow(Place(""), engine, "", "", "skipped")
        try:
            reply = self._processes[engine].ask(Describe(), Described, self._job.timeout)
        except OitbenchError as error:
            return [replace(blank, status="failed", reason=str(error))]
        return [
            replace(blank, algorithm=name, peer=algorithm.peer, remark=algorithm.remark)
            for name, algorithm in reply.algorithms.items()
        ]

    def drawn(self, row: EngineRow, base: Record) -> EngineRow:
        """Return a row with its picture and that of its peer, or with the reason for none."""
        if row.status == "failed":
            return row
        assert base.outcome is not None
        images = base.outcome.images
        # Truths of another size than the picture cannot be compared with pictures of engines.
        same = (name for name in TRUTHS if compared(base.outcome, name) == PICTURE)
        truths = {name: images[name] for name in same if name in images}
        try:
            # Known without building the scene, which may take long.
            require_coverage_alone(row.place.scene, effects_of(base.requested_effects))
            peer = self._peer(row, truths)
            against = truths | {PEER: peer.image}
            found = self._draw(row.engine, row.place, row.algorithm, against)
        except StorageError:
            raise
        except (CapabilityError, SceneError) as error:
            return replace(row, status="skipped", reason=str(error))
        except OitbenchError as error:
            late = isinstance(error, WorkerError) and error.timeout
            return replace(row, status="timeout" if late else "failed", reason=str(error))
        return replace(
            row,
            status="ok",
            version=found.version,
            renderer=found.renderer,
            peer_renderer=peer.renderer,
            drawn=Picture(found.image, found.scores),
            peer_drawn=Picture(peer.image, peer.scores),
        )

    def _peer(self, row: EngineRow, truths: dict[str, StoredImage]) -> RowDrawn:
        key = row.place, row.peer
        if key not in self._peers:
            self._peers[key] = self._draw(_OWN, row.place, row.peer, truths)
        return self._peers[key]

    def _draw(
        self, engine: str, place: Place, algorithm: str, against: dict[str, StoredImage]
    ) -> RowDrawn:
        request = DrawRow(place, algorithm, against)
        return self._processes[engine].ask(request, RowDrawn, self._job.timeout)

    def timed(self, rows: Sequence[EngineRow]) -> list[EngineRow]:
        """Return the rows of one place with the ratio of their times to those of their peers."""
        ready = [row for row in rows if row.status == "ok"]
        if not ready or not self._job.schedule.rounds:
            return list(rows)
        tasks: dict[_Task, Callable[[], float]] = {}
        for row in ready:
            for engine, name in ((row.engine, row.algorithm), (_OWN, row.peer)):
                tasks[engine, name] = partial(self._time, engine, row.place, name)
        counted = rounds.run(tasks, self._job.schedule)
        return [_with_ratio(row, counted) if row.status == "ok" else row for row in rows]

    def _time(self, engine: str, place: Place, name: str) -> float:
        request = TimeRow(place, name)
        return self._processes[engine].ask(request, RowTimed, self._job.timeout).ms


def _with_ratio(row: EngineRow, counted: rounds.Counted[_Task]) -> EngineRow:
    """Return the row with the ratio of each round, or with the reason why there is none."""
    own, peer = (row.engine, row.algorithm), (_OWN, row.peer)
    errors = [counted.errors[task] for task in (own, peer) if task in counted.errors]
    if errors:
        return replace(row, reason=f"not timed: {errors[0]}")
    pairs = zip(counted.samples[own], counted.samples[peer], strict=False)
    return replace(row, ratio=interval([one / other for one, other in pairs]))
