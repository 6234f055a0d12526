"""A process that renders cells: requests come in, replies go out, one JSON line each.

A crash, a hang or a leak in a driver then costs one cell and not the run. Both ends speak over
standard input and output, so a worker could also be at the end of a network connection. The other
end is `oitbench.matrix.pool.WorkerProcess`.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import msgspec
from msgspec import Struct

from oitbench.errors import OitbenchError
from oitbench.matrix.bench import Bench
from oitbench.matrix.cell import Cell
from oitbench.plugins import Collection
from oitbench.results.schema import Fingerprints, Record, Renderer, Time


class Settings(Struct, frozen=True):
    """Sources of plugins that are not the suite's own, and the results folder."""

    collections: list[str]
    methods: list[str]
    folder: str


class Hello(Struct, frozen=True, tag=True):
    """Asks for a greeting."""


class IdentifyCells(Struct, frozen=True, tag=True):
    """Asks for the fingerprints of the cells of one scene."""

    cells: list[Cell]


class RunCell(Struct, frozen=True, tag=True):
    """Asks for one rendered and scored cell."""

    cell: Cell


class TimeCells(Struct, frozen=True, tag=True):
    """Asks for the times of the cells of one scene."""

    cells: list[Cell]
    rounds: int
    budget: float


class Greeting(Struct, frozen=True, tag=True):
    """The renderer of the worker."""

    gl: Renderer


class CellsIdentified(Struct, frozen=True, tag=True):
    """Fingerprints in the order of the request; None for a scene or a method that is broken."""

    fingerprints: list[Fingerprints | None]


class CellDone(Struct, frozen=True, tag=True):
    """A record, and the seconds spent by kind of work."""

    record: Record
    spent: dict[str, float]


class CellsTimed(Struct, frozen=True, tag=True):
    """Times in the order of the request, and the seconds spent by kind of work."""

    times: list[Time]
    spent: dict[str, float]


class Refusal(Struct, frozen=True, tag=True):
    """A user's error that prevented the work; `kind` is the name of its class."""

    message: str
    kind: str


Request = Hello | IdentifyCells | RunCell | TimeCells
Reply = Greeting | CellsIdentified | CellDone | CellsTimed | Refusal


def _answer(bench: Bench, request: Request) -> Reply:
    if isinstance(request, Hello):
        return Greeting(bench.gl)
    if isinstance(request, IdentifyCells):
        return CellsIdentified([bench.identities.find(cell) for cell in request.cells])
    if isinstance(request, RunCell):
        record = bench.run(request.cell)
        return CellDone(record, bench.watch.take())
    times = bench.time(request.cells, request.rounds, request.budget)
    return CellsTimed(times, bench.watch.take())


def _bench(settings: Settings) -> Bench:
    collection = Collection.load(map(Path, settings.collections))
    for folder in settings.methods:
        collection.add_method(Path(folder))
    return Bench(collection, Path(settings.folder))


def main() -> None:
    """Serve until standard input ends."""
    # Output of libraries must not appear between the replies.
    replies = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    settings = msgspec.json.decode(sys.argv[1], type=Settings)
    decoder = msgspec.json.Decoder(Request)
    bench: Bench | None = None
    for line in sys.stdin.buffer:
        reply: Reply
        try:
            bench = bench or _bench(settings)
            reply = _answer(bench, decoder.decode(line))
        except OitbenchError as error:
            reply = Refusal(str(error), type(error).__name__)
        replies.write(msgspec.json.encode(reply) + b"\n")
        replies.flush()


if __name__ == "__main__":
    main()
