"""References from workers: each piece of each reference is a unit of work, for any worker."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from msgspec import Struct

from oitbench.errors import OitbenchError, StorageError
from oitbench.executors.executor import Executor, Worker
from oitbench.filenames import file_name
from oitbench.path_traced.references import pieces, storage
from oitbench.path_traced.references.pieces import Piece, assemble
from oitbench.path_traced.references.storage import Reference
from oitbench.path_traced.references.worker import (
    CheckReference,
    Job,
    PieceRendered,
    PlanReference,
    ReferenceChecked,
    ReferencePlanned,
    RenderPiece,
)

OnPiece = Callable[[Job, int, int], None]
"""Called with a job, the number of its finished pieces and the number of all."""


@dataclass(frozen=True)
class Order:
    """A reference to render, and the folder that stores it."""

    job: Job
    folder: Path


@dataclass(frozen=True)
class _Unit:
    job: Job
    request: Struct
    kind: type[Struct]


@dataclass
class _Started:
    """A reference of which some pieces are finished, by their numbers."""

    plan: ReferencePlanned
    seconds: float = 0.0
    found: dict[int, Piece] = field(default_factory=dict)

    def reference(self) -> Reference:
        ordered = [self.found[number] for number in range(self.plan.pieces)]
        return assemble(self.plan.rendering, ordered, self.plan.exposure, self.seconds)


def render(
    executor: Executor,
    orders: Iterable[Order],
    spp: int | None,
    seed: int,
    timeout: float | None,
    scratch: Path,
    on_piece: OnPiece = lambda job, done, count: None,
) -> Iterator[tuple[Job, Reference | OitbenchError]]:
    """Render and store references; yield each when it is stored, or the error that prevents it.

    Parameters
    ----------
    executor : Executor
        Of the worker's `far_end`.
    orders : iterable of Order
    spp, seed
        See `plan_rendering`.
    timeout : float, optional
        Seconds for each step of the work. None: no limit.
    scratch : Path
        The folder of the executor.
    on_piece : callable
        See `OnPiece`.

    Raises
    ------
    StorageError
        A file cannot be written.
    """
    folders = {order.job: order.folder for order in orders}
    units = deque(_Unit(job, PlanReference(job, spp, seed), ReferencePlanned) for job in folders)
    started: dict[Job, _Started] = {}
    for unit, reply in executor.collect(units, _asker(timeout)):
        job = unit.job
        if job not in folders:
            continue  # It has failed.
        if isinstance(reply, OitbenchError):
            del folders[job]
            kept = [other for other in units if other.job != job]
            units.clear()
            units.extend(kept)
            yield job, reply
        elif isinstance(reply, ReferencePlanned):
            started[job] = _Started(reply)
            on_piece(job, 0, reply.pieces)
            # Before those of further references, so that each is stored early.
            units.extendleft(reversed([*_pieces(job, reply)]))
        elif isinstance(unit.request, RenderPiece) and isinstance(reply, PieceRendered):
            path, known = scratch / unit.request.name, started[job]
            known.found[unit.request.number] = pieces.read(path)
            path.unlink()
            known.seconds += reply.seconds
            on_piece(job, len(known.found), known.plan.pieces)
            if len(known.found) == known.plan.pieces:
                reference = started.pop(job).reference()
                storage.save(folders[job], reference)
                yield job, reference


def _pieces(job: Job, plan: ReferencePlanned) -> Iterator[_Unit]:
    stem = file_name(plan.rendering.key)
    for number in range(plan.pieces):
        request = RenderPiece(job, plan.rendering, number, f"{stem}-{number}.npz")
        yield _Unit(job, request, PieceRendered)


def check(
    executor: Executor, requests: Iterable[CheckReference], timeout: float | None
) -> Iterator[tuple[Job, ReferenceChecked | OitbenchError]]:
    """Check stored references; yield the result of each, or the error that prevents it."""
    units = deque(_Unit(request.job, request, ReferenceChecked) for request in requests)
    for unit, reply in executor.collect(units, _asker(timeout)):
        if isinstance(reply, ReferenceChecked | OitbenchError):
            yield unit.job, reply


def _asker(
    timeout: float | None,
) -> Callable[[Worker, _Unit], Iterator[tuple[_Unit, Struct | OitbenchError]]]:
    def work(worker: Worker, unit: _Unit) -> Iterator[tuple[_Unit, Struct | OitbenchError]]:
        try:
            yield unit, worker.ask(unit.request, unit.kind, timeout)
        except StorageError:
            raise
        except OitbenchError as error:
            yield unit, error

    return work
