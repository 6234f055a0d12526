"""What a run would take: its cells, and its time, memory and disk space, estimated from probes."""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from oitbench.errors import OitbenchError
from oitbench.executors.processes import LocalWorker
from oitbench.matrix.cell import Cell
from oitbench.matrix.cost_model import CostModel
from oitbench.matrix.plan import Matrix
from oitbench.matrix.probe import ProbedTruth, ProbeUsage, UsageProbed
from oitbench.matrix.resume import Resume
from oitbench.matrix.samples import Sample, SceneSamples
from oitbench.matrix.sampling import LEAST_SAMPLES, MOST_SAMPLES, TASKS, OnStage, Sampler
from oitbench.matrix.worker import CellsIdentified, Greeting, Hello, IdentifyCells, far_end
from oitbench.measure.rounds import LEAST, LEAST_OF_SLOW, SLOW, WARM_UP, Schedule
from oitbench.results.schema import Fingerprints
from oitbench.results.store import Store
from oitbench.workers.cores import usable_cores
from oitbench.workers.process import Process

_FULL_SIZE = 2
"""Cells that are drawn at their full size, those of the costliest scenes."""
_LONGEST = 20.0
"""Seconds that such a cell may be expected to take."""
_READING_SECONDS = 5.0
"""A run also starts its workers, and reads and writes its folder."""


@dataclass
class SceneEstimate:
    """The cells of one scene, as seen from one view, and the seconds that those to run take.

    Parameters
    ----------
    label : str
    methods : int
        Number of methods and their variants.
    done, todo : list of Cell
    seconds : dict of str to float
        By kind of work: "building", "drawing", "metrics", "timing".
    """

    label: str
    methods: int
    done: list[Cell]
    todo: list[Cell]
    seconds: dict[str, float] = field(default_factory=dict)


@dataclass
class Estimate:
    """What a run would take on this machine, as busy as it is.

    Parameters
    ----------
    scenes : list of SceneEstimate
    seconds : dict of str to float
        By kind of work; what several workers do at once is divided among them.
    disk : float
        Bytes of images and records.
    memory : float
        Bytes of one worker.
    missing : dict of str to int
        Traced truths that are rendered first, by their key, and the number of scenes. Their time is
        not counted.
    unknown : list of str
        Labels of scenes of which nothing could be drawn.
    """

    scenes: list[SceneEstimate]
    seconds: dict[str, float] = field(default_factory=dict)
    disk: float = 0.0
    memory: float = 0.0
    missing: dict[str, int] = field(default_factory=dict)
    unknown: list[str] = field(default_factory=list)

    @property
    def todo(self) -> int:
        """Number of cells to run."""
        return sum(len(scene.todo) for scene in self.scenes)

    @property
    def total(self) -> float:
        """Seconds of the whole run."""
        return sum(self.seconds.values())


def estimate(matrix: Matrix, on_stage: OnStage = lambda labels, stage: None) -> Estimate:
    """Find out which cells of a matrix a run would keep, and what the others would take.

    Nothing is written to the results folder. Probes draw a few cells of each scene at small sizes,
    and two at their full size.

    Raises
    ------
    UsageError
        The results folder cannot be used.
    CapabilityError
        There is no OpenGL on this machine.
    """
    with (
        tempfile.TemporaryDirectory(prefix="oitbench-") as folder,
        LocalWorker(far_end(matrix.plugins, Path(folder)), matrix.memory_limit) as worker,
    ):
        scenes = _list(matrix, worker)
        found = Estimate(scenes)
        due = [scene for scene in scenes if scene.todo]
        if not due:
            return found
        sampler = Sampler(worker, matrix.timeout, matrix.preset.rounds > 0, on_stage)
        methods = {cell.method for scene in due for cell in scene.todo}
        count = math.ceil(len(methods) / len(due))
        count = max(LEAST_SAMPLES, min(MOST_SAMPLES, count))
        before, start = _usage(worker), time.perf_counter()
        samples = [sampler.sample(scene.todo, k, count) for k, scene in enumerate(due)]
        seconds = time.perf_counter() - start
        busy = (_usage(worker).cpu - before.cpu) / seconds
        found.unknown = [
            scene.label for scene, own in zip(due, samples, strict=True) if not own.samples
        ]
        if any(own.samples for own in samples):
            software = worker.ask(Hello(), Greeting).gl.software
            _add_up(found, due, samples, _Costs(samples), matrix, sampler, software)
            at_once = speedup(matrix.workers, len(usable_cores()), busy)
            for scene in due:
                for kind, value in scene.seconds.items():
                    shared = 1 if kind == "timing" else at_once
                    found.seconds[kind] = found.seconds.get(kind, 0.0) + value / shared
            found.seconds["rest"] = _READING_SECONDS
    return found


def _list(matrix: Matrix, worker: Process) -> list[SceneEstimate]:
    """Return the cells of each scene, and which of them a run would keep."""
    gl = worker.ask(Hello(), Greeting, retry=True).gl
    store = Store.read(matrix.out)
    store.check_renderer(gl.renderer)
    resume = Resume(store, gl, matrix.force)

    def identify(cells: list[Cell]) -> Sequence[Fingerprints | None]:
        try:
            return worker.ask(IdentifyCells(cells), CellsIdentified, matrix.timeout).fingerprints
        except OitbenchError:
            return [None] * len(cells)

    groups: dict[str, list[Cell]] = {}
    for cell in matrix.cells:
        groups.setdefault(cell.seen, []).append(cell)
    found = []
    for label, cells in groups.items():
        usable = [cell for cell in cells if cell not in matrix.unusable]
        todo = resume.redone(usable, identify)
        done = [cell for cell in usable if cell not in todo]
        methods = len({cell.method for cell in cells})
        found.append(SceneEstimate(label, methods, done, list(todo)))
    return found


class _Costs:
    """Models of what cells cost, from samples of all scenes."""

    def __init__(self, scenes: Sequence[SceneSamples]) -> None:
        self.samples = [sample for scene in scenes for sample in scene.samples]
        self.drawing = self._model(lambda sample: sample.first + sample.again)
        self.round = self._model(lambda sample: sample.round)
        self.memory = self._model(lambda sample: sample.memory)
        known = [sample.metrics for sample in self.samples if sample.metrics is not None]
        self.metrics = sum(known) / max(1, len(known))
        self.picture = self._model(lambda sample: sample.picture)
        self.flip = self._model(lambda sample: sample.flip)

    def _model(self, cost: Callable[[Sample], float]) -> CostModel:
        return CostModel([(sample.cell, cost(sample)) for sample in self.samples])


def _add_up(
    found: Estimate,
    due: Sequence[SceneEstimate],
    samples: Sequence[SceneSamples],
    costs: _Costs,
    matrix: Matrix,
    sampler: Sampler,
    software: bool,
) -> None:
    """Fill in the seconds of each scene, and the bytes of an estimate."""
    drawing = [float(costs.drawing.predict(scene.todo).sum()) for scene in due]
    resident = _usage(sampler.worker).resident
    factor, metrics = _calibrate(drawing, samples, costs, sampler)
    largest = 0.0
    for scene, own, seconds in zip(due, samples, drawing, strict=True):
        count = len(scene.todo)
        scene.seconds["building"] = own.building * (2 if sampler.timed else 1)
        scene.seconds["drawing"] = factor * (seconds + own.sharing)
        scene.seconds["metrics"] = count * _scoring(own.truths, scene.todo[0], metrics)
        timed = [*scene.done, *scene.todo]
        if sampler.timed:
            rounds = factor * costs.round.predict(timed)
            scene.seconds["timing"] = timing_seconds(rounds.tolist(), matrix.schedule)
            largest = max(largest, float(costs.memory.predict(timed).sum()))
        found.disk += _disk(own, scene.todo, costs)
        for truth in own.truths:
            if truth.pixels is None:
                found.missing[truth.kind] = found.missing.get(truth.kind, 0) + 1
    # All frames of a scene are open while it is timed, in the memory of a software renderer.
    found.memory = max(_usage(sampler.worker).peak, resident + (largest if software else 0.0))


def _calibrate(
    drawing: Sequence[float], samples: Sequence[SceneSamples], costs: _Costs, sampler: Sampler
) -> tuple[float, float]:
    """Draw cells of the costliest scenes at their full size.

    Returns
    -------
    factor : float
        By which drawing takes longer than was extrapolated.
    metrics : float
        Seconds of scoring a cell against a truth.
    """
    order = sorted(range(len(samples)), key=lambda k: -drawing[k])
    real, expected, metrics = 0.0, 0.0, []
    for own in [samples[place] for place in order if samples[place].samples][:_FULL_SIZE]:
        sample = min(own.samples, key=lambda one: abs(one.again - _LONGEST / 2))
        if sample.again > _LONGEST:
            continue
        drawn = sampler.draw(sample.cell, sample.cell.size, permuted=True)
        if drawn is not None:
            real += drawn.seconds + drawn.permutations
            expected += sample.again + own.sharing
            metrics += [] if drawn.perfect else [drawn.metrics]
    factor = real / expected if expected else 1.0
    return factor, sum(metrics) / len(metrics) if metrics else costs.metrics


def _scoring(truths: Sequence[ProbedTruth], cell: Cell, metrics: float) -> float:
    """Return the seconds of scoring one cell against all of its truths."""
    pixels = math.prod(cell.size)
    # One that is missing will have the size of the cell.
    sizes = [pixels, *(truth.pixels or pixels for truth in truths)]
    return metrics * sum(sizes) / pixels + sum(truth.jackknife for truth in truths)


def timing_seconds(rounds: Sequence[float], schedule: Schedule) -> float:
    """Return the seconds of timing cells together.

    Parameters
    ----------
    rounds : sequence of float
        Seconds of each cell in one round.
    schedule : Schedule
    """
    # Frames are opened, and drawn for the first time, in about the time of one round.
    whole = sum(rounds)
    in_budget = math.floor(schedule.budget / whole) + 1 - WARM_UP if whole > 0 else schedule.rounds
    seconds = whole
    for one in rounds:
        if one / TASKS > SLOW:  # Then most frames are timed by their passes alone.
            count = 1 + min(schedule.rounds, max(LEAST_OF_SLOW, in_budget))
            seconds += one / TASKS * count
        else:
            seconds += one * (WARM_UP + min(schedule.rounds, max(LEAST, in_budget)))
    return seconds


def _disk(own: SceneSamples, cells: Sequence[Cell], costs: _Costs) -> float:
    """Return the bytes of the images and records of a scene."""
    truths = 1 + len(own.truths)
    pictures, maps = costs.picture.predict(cells).sum(), costs.flip.predict(cells).sum()
    shared = max((sample.shared for sample in own.samples), default=0.0)
    return float(pictures + truths * (maps + shared))


def speedup(workers: int, cores: int, busy: float) -> float:
    """Return how much faster several workers are than one that keeps some cores busy by itself.

    Parameters
    ----------
    workers, cores : int
    busy : float
        CPU time of one worker relative to the time that has passed. Software renderers and FLIP use
        several threads.
    """
    return max(1.0, min(workers, cores / busy)) if busy > 0 else float(workers)


def _usage(worker: Process) -> UsageProbed:
    return worker.ask(ProbeUsage(), UsageProbed)
