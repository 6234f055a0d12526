"""The far end of a process that renders, scores and times cells."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from msgspec import Struct

from oitbench.errors import UsageError
from oitbench.executors.executor import Far, Settings
from oitbench.gl.frame import Frame
from oitbench.gl.frame_targets import choose, targets_of
from oitbench.gl.limits import check_size
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.image import files
from oitbench.image.values import Show
from oitbench.matrix import machine
from oitbench.matrix.bench import Bench
from oitbench.matrix.cell import Cell, choose_effects
from oitbench.matrix.probe import ProbeTruths, ProbeUsage, TruthsProbed, UsageProbed, probe_truths
from oitbench.matrix.timed_cells import ScoredCell, Timing
from oitbench.measure.rounds import Schedule
from oitbench.method.declaration import Method
from oitbench.places import PluginFiles
from oitbench.plugins import Collection
from oitbench.results.schema import Fingerprints, Record, Renderer, RunFacts
from oitbench.shading import read_shading
from oitbench.views import MAIN
from oitbench.workers import memory
from oitbench.workers.serve import OnStep, serve

LIST, ALL = "list", "all"
"""In place of the names of targets: only their facts, and all that can be read."""


class Hello(Struct, frozen=True, tag=True):
    """Asks for a greeting."""


class CollectFacts(Struct, frozen=True, tag=True):
    """Asks for the facts of a run; see `oitbench.matrix.machine.collect`."""

    argv: list[str]
    seed: int
    methods: list[str]


class IdentifyCells(Struct, frozen=True, tag=True):
    """Asks for the fingerprints of the cells of one scene."""

    cells: list[Cell]


class RunCell(Struct, frozen=True, tag=True):
    """Asks for one rendered and scored cell."""

    cell: Cell


class TimeCells(Struct, frozen=True, tag=True):
    """Asks for the times of the cells of one scene; the rest is a `Schedule`."""

    cells: list[ScoredCell]
    rounds: int
    budget: float
    seed: int


class DrawPicture(Struct, frozen=True, tag=True):
    """Asks for one picture as a file of numpy; see `oitbench.matrix.picture.render`."""

    scene: str
    method: str
    size: tuple[int, int]
    ssaa: int
    effects: str
    file: Path
    shading: str = ""
    view: str = MAIN


class DrawTargets(Struct, frozen=True, tag=True):
    """Asks for targets of one frame as an archive of numpy; see `oitbench.matrix.targets.draw`."""

    scene: str
    method: str
    size: tuple[int, int]
    ssaa: int
    effects: str
    names: list[str]
    file: Path
    shading: str = ""
    view: str = MAIN


class Greeting(Struct, frozen=True, tag=True):
    """The renderer of the worker."""

    gl: Renderer


class FactsCollected(Struct, frozen=True, tag=True):
    """The facts of the machine on which the process runs, and of the run."""

    facts: RunFacts


class CellsIdentified(Struct, frozen=True, tag=True):
    """Fingerprints in the order of the request; None for a scene or a method that is broken."""

    fingerprints: list[Fingerprints | None]


class CellDone(Struct, frozen=True, tag=True):
    """A record, and the seconds spent by kind of work."""

    record: Record
    spent: dict[str, float]


class CellsTimed(Struct, frozen=True, tag=True):
    """Times in the order of the request, and the seconds spent by kind of work."""

    timings: list[Timing]
    spent: dict[str, float]


class PictureDrawn(Struct, frozen=True, tag=True):
    """The exposure of the scene in stops."""

    exposure: float


class TargetFacts(Struct, frozen=True):
    """Facts of a target; see `oitbench.gl.frame_targets.FrameTarget`."""

    name: str
    format: str
    size: tuple[int, int]
    show: Show
    unit: str
    depth: bool
    view: bool


class TargetsDrawn(Struct, frozen=True, tag=True):
    """The exposure of the scene in stops, and the targets in the order of the archive."""

    exposure: float
    targets: list[TargetFacts]


Request = (
    Hello
    | CollectFacts
    | IdentifyCells
    | RunCell
    | TimeCells
    | DrawPicture
    | DrawTargets
    | ProbeTruths
    | ProbeUsage
)
Reply = (
    Greeting
    | FactsCollected
    | CellsIdentified
    | CellDone
    | CellsTimed
    | PictureDrawn
    | TargetsDrawn
    | TruthsProbed
    | UsageProbed
)


def far_end(plugins: PluginFiles, folder: Path) -> Far:
    """Return the process of this file, which writes images below `folder`."""
    return Far(__name__, Settings(plugins, folder), Reply, Hello())


def begin(settings: Settings, on_step: OnStep) -> Callable[[Request], Reply]:
    """Return the function that answers."""
    bench = Bench(Collection(settings.plugins.places()), settings.folder, on_step)

    def answer(request: Request) -> Reply:
        if isinstance(request, Hello):
            return Greeting(bench.gl)
        if isinstance(request, CollectFacts):
            argv, seed, methods = request.argv, request.seed, request.methods
            return FactsCollected(machine.collect(bench.gl, argv=argv, seed=seed, methods=methods))
        if isinstance(request, IdentifyCells):
            return CellsIdentified([bench.identities.find(cell) for cell in request.cells])
        if isinstance(request, RunCell):
            record = bench.run(request.cell)
            return CellDone(record, bench.watch.take())
        if isinstance(request, DrawPicture):
            return _draw(bench, request)
        if isinstance(request, DrawTargets):
            return _draw_targets(bench, request)
        if isinstance(request, ProbeTruths):
            scene = bench.identities.scene(request.cell)
            return probe_truths(scene, request.cell, bench.collection.folders)
        if isinstance(request, ProbeUsage):
            return UsageProbed(memory.resident(), memory.peak(), time.process_time())
        schedule = Schedule(request.rounds, request.budget, request.seed)
        return CellsTimed(bench.time(request.cells, schedule), bench.watch.take())

    return answer


@contextmanager
def _opened(bench: Bench, request: DrawPicture | DrawTargets) -> Iterator[tuple[Frame, Method]]:
    """Yield the frame of a request, sub-pixels included, and its method."""
    chosen = bench.collection.expand_methods([request.method])
    if len(chosen) != 1:
        raise UsageError(f"'{request.method}' selects {len(chosen)} methods; name one")
    scene = bench.collection.build_scene(request.scene).from_view(request.view)
    running = choose_effects(request.effects, scene.effects) & chosen[0].shows
    fine = (request.size[0] * request.ssaa, request.size[1] * request.ssaa)
    check_size(bench.device, fine)
    with (
        UploadedScene(bench.device, scene, read_shading(request.shading), fine[1]) as uploaded,
        Frame(uploaded, chosen[0], fine, running) as frame,
    ):
        yield frame, chosen[0]


def _draw(bench: Bench, request: DrawPicture) -> PictureDrawn:
    with _opened(bench, request) as (frame, _):
        frame.render()
        image = files.box_downsample(frame.image(), request.ssaa)
        exposure = frame.scene.scene.exposure
    with request.file.open("wb") as file:
        np.save(file, image)
    return PictureDrawn(exposure)


def _draw_targets(bench: Bench, request: DrawTargets) -> TargetsDrawn:
    with _opened(bench, request) as (frame, method):
        if request.names == [LIST]:
            chosen = list(targets_of(frame, method).values())
        elif request.names == [ALL]:
            chosen = [item for item in targets_of(frame, method).values() if item.readable]
        else:
            chosen = [choose(frame, method, name) for name in request.names]
        if request.names != [LIST]:
            frame.render()
            arrays: dict[str, Any] = {str(k): item.read() for k, item in enumerate(chosen)}
            with request.file.open("wb") as file:
                np.savez(file, **arrays)
        exposure = frame.scene.scene.exposure
    facts = [
        TargetFacts(item.name, item.format, item.size, item.show, item.unit, item.depth, item.view)
        for item in chosen
    ]
    return TargetsDrawn(exposure, facts)


def main() -> None:
    """Serve the process that started this one."""
    serve(Settings, Request, begin)
