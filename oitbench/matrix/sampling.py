"""Samples of what cells cost: a few of each scene, drawn at two small sizes and extrapolated.

Every part of a cell that depends on its size grows with the number of pixels, so that two sizes
determine it. A cell that is drawn for the first time also compiles its shaders. For a cell that is
slow even at the smaller size, the other one is smaller still.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import msgspec

from oitbench.errors import OitbenchError, StorageError
from oitbench.matrix.cell import Cell
from oitbench.matrix.probe import ProbedTruth, ProbeTruths, TruthsProbed
from oitbench.matrix.timed_cells import ScoredCell
from oitbench.matrix.worker import CellDone, CellsTimed, RunCell, TimeCells
from oitbench.results.schema import COMPLEXITY, TRANSMITTANCE, Outcome, flip_image
from oitbench.truths import EXACT
from oitbench.workers.process import Process

Size = tuple[int, int]
OnStage = Callable[[str, str], None]
LEAST_SAMPLES, MOST_SAMPLES = 2, 4
"""Cells of each scene that are drawn."""
_TINY, _SMALL, _MIDDLE = 8, 4, 2
"""Divisors of the sides of the small sizes; the first one is for slow cells alone."""
_SLOW = 4.0
"""Seconds of a cell at the smaller size beyond which it is not drawn at a larger one."""
_NOT_DRAWING = ("building", "metrics", "references")
_OWN_BYTES = 20
"""Of the picture and the depth of a frame, for each pixel, which no method accounts for."""
TASKS = 2
"""Tasks of a cell in a round of timing: the whole method, and its passes."""


@dataclass(frozen=True)
class Drawn:
    """A cell that was drawn at some size, and scored against exact compositing.

    Parameters
    ----------
    seconds : float
        Seconds of drawing it, and of what all cells of its scene share if it is the first one.
    building, metrics : float
        Seconds of building its scene, and of scoring it.
    line : int
        Bytes of its record.
    outcome : Outcome
    """

    seconds: float
    building: float
    metrics: float
    line: int
    outcome: Outcome


@dataclass(frozen=True)
class Sample:
    """Costs of a cell at its full size.

    Parameters
    ----------
    cell : Cell
    first : float
        Seconds that only the first drawing takes, as it compiles shaders.
    again : float
        Seconds of each further one.
    metrics : float
        Seconds of scoring it against exact compositing.
    round : float
        Seconds of it in one round of timing; 0 without timing.
    picture, flip, shared : float
        Bytes of its picture and its record, of one map of FLIP, and of exact compositing with all
        maps that the cells of a scene share.
    memory : float
        Bytes of the frame that is timed.
    """

    cell: Cell
    first: float
    again: float
    metrics: float
    round: float
    picture: float
    flip: float
    shared: float
    memory: float


@dataclass
class SceneSamples:
    """Samples of the cells of one scene, and the seconds of what its cells share.

    Parameters
    ----------
    cells : list of Cell
        All cells to run.
    samples : list of Sample
        Empty if none could be drawn.
    building : float
        Seconds of building the scene.
    sharing : float
        Seconds of uploading it, and of exact compositing at the full size.
    truths : list of ProbedTruth
    """

    cells: list[Cell]
    samples: list[Sample] = field(default_factory=list)
    building: float = 0.0
    sharing: float = 0.0
    truths: list[ProbedTruth] = field(default_factory=list)


@dataclass(frozen=True)
class Sampler:
    """Draws cells with a worker.

    Parameters
    ----------
    worker : Process
    timeout : float, optional
        Seconds of each step.
    timed : bool
        Whether frames are timed, too.
    on_stage : callable
        As in `run_matrix`.
    """

    worker: Process
    timeout: float | None
    timed: bool
    on_stage: OnStage

    def draw(self, cell: Cell, size: Size) -> Drawn | None:
        """Draw a cell at a size; None if it has no picture."""
        small = msgspec.structs.replace(cell, size=size, truths=(EXACT,))
        self.on_stage(f"{cell.seen} {cell.method}", f"probing at {size[0]}x{size[1]}")
        try:
            done = self.worker.ask(RunCell(small), CellDone, self.timeout)
        except StorageError:
            raise
        except OitbenchError:
            return None
        if done.record.outcome is None:
            return None
        other = [done.spent.get(kind, 0.0) for kind in _NOT_DRAWING]
        building, metrics, _ = other
        seconds, line = done.record.seconds - sum(other), len(msgspec.json.encode(done.record))
        return Drawn(seconds, building, metrics, line, done.record.outcome)

    def sample(self, cells: list[Cell], number: int, count: int) -> SceneSamples:
        """Return samples of the cells of one scene.

        Parameters
        ----------
        cells : list of Cell
            At least one.
        number : int
            Place of the scene among all, so that each samples other methods.
        count : int
            Cells to draw.
        """
        found = SceneSamples(cells)
        full = cells[0].size
        tiny, small, middle = (_divided(full, part) for part in (_TINY, _SMALL, _MIDDLE))
        chosen = choose(cells, number, count)
        firsts = self._draw_all(chosen, small)
        agains = self._draw_all(firsts, small)
        slow = {cell: one for cell, one in agains.items() if one.seconds > _SLOW}
        middles, shared = self._draw_sharing([cell for cell in agains if cell not in slow], middle)
        tinies = self._draw_all(slow, tiny)
        rounds = self._time(middles, middle) | self._time(slow, small) if self.timed else {}
        for cell, again in agains.items():
            larger = middles.get(cell)
            if larger is None:
                sizes, pair = (tiny, small, full), (tinies.get(cell), again)
            else:
                sizes, pair = (small, middle, full), (again, larger)
            pixels = [math.prod(size) for size in sizes]
            first = firsts[cell].seconds - again.seconds
            found.samples.append(_sample(cell, pixels, first, *pair, rounds.get(cell, 0.0)))
        if found.samples:
            _correct_first(found)
            grown = (
                one.again / middles[one.cell].seconds
                for one in found.samples
                if one.cell in middles
            )
            found.sharing = shared * next(grown, 0.0)
            found.building = max(one.building for one in firsts.values())
            found.truths = self._truths(cells[0])
        return found

    def _draw_sharing(self, cells: list[Cell], size: Size) -> tuple[dict[Cell, Drawn], float]:
        """Draw cells at a new size, and return also the seconds of what they share there.

        The first cell uploads the scene and draws exact compositing; then it is drawn again.
        """
        drawn = self._draw_all(cells, size)
        if not drawn:
            return {}, 0.0
        first = next(iter(drawn))
        again = self.draw(first, size)
        if again is None:
            return {}, 0.0
        sharing, drawn[first] = drawn[first].seconds - again.seconds, again
        return drawn, max(0.0, sharing)

    def _draw_all(self, cells: Iterable[Cell], size: Size) -> dict[Cell, Drawn]:
        """Draw cells at a size; those that have no picture are left out."""
        drawn = {cell: self.draw(cell, size) for cell in cells}
        return {cell: one for cell, one in drawn.items() if one is not None}

    def _time(self, drawn: Mapping[Cell, Drawn], size: Size) -> dict[Cell, float]:
        """Return the seconds of each cell in one round of timing at a size."""
        if not drawn:
            return {}
        scored = [
            ScoredCell(msgspec.structs.replace(cell, size=size), one.outcome.plan)
            for cell, one in drawn.items()
        ]
        cells = list(drawn)
        self.on_stage(cells[0].seen, f"probing times at {size[0]}x{size[1]}")
        try:
            reply = self.worker.ask(TimeCells(scored, 1, 0.0, 1), CellsTimed, self.timeout)
        except OitbenchError:
            return {}
        pairs = zip(cells, reply.timings, strict=True)
        return {
            cell: TASKS * timing.time.method_ms.median / 1000
            for cell, timing in pairs
            if timing.time is not None
        }

    def _truths(self, cell: Cell) -> list[ProbedTruth]:
        self.on_stage(cell.seen, "probing its truths")
        try:
            return self.worker.ask(ProbeTruths(cell), TruthsProbed, self.timeout).truths
        except OitbenchError:
            return []


def choose(cells: Sequence[Cell], number: int, count: int) -> list[Cell]:
    """Return cells of one scene, such that scenes of successive numbers sample different methods.

    Parameters
    ----------
    cells : sequence of Cell
    number : int
        Place of the scene among all.
    count : int
        Cells to choose, at most.
    """
    count = min(count, len(cells))
    step = len(cells) / count
    places = ((number + math.floor(step * place)) % len(cells) for place in range(count))
    return [cells[place] for place in places]


def _correct_first(found: SceneSamples) -> None:
    """Do not count for the first sample what all samples share."""
    first, *others = found.samples
    usual = sum(sample.first for sample in others) / max(1, len(others))
    found.samples[0] = replace(first, first=min(first.first, usual))


def _sample(
    cell: Cell,
    pixels: Sequence[int],
    first: float,
    smaller: Drawn | None,
    larger: Drawn,
    round: float,
) -> Sample:
    """Return the costs of a cell at its full size, from two small ones.

    Parameters
    ----------
    cell : Cell
    pixels : sequence of int
        Of the smaller, the larger and the full size.
    first : float
        Seconds that only the first drawing took.
    smaller : Drawn, optional
        Default: costs are proportional to the pixels.
    larger : Drawn
    round : float
        Seconds in one round of timing at the larger size.
    """

    def full(cost: Callable[[Drawn], float]) -> float:
        if smaller is None:
            return cost(larger) * pixels[2] / pixels[1]
        return extrapolate(pixels, cost(smaller), cost(larger))

    seconds = full(lambda drawn: drawn.seconds)
    return Sample(
        cell,
        first=max(0.0, first),
        again=seconds,
        metrics=full(lambda drawn: drawn.metrics),
        round=round * seconds / larger.seconds,
        picture=full(lambda drawn: _bytes(drawn, "color")) + larger.line,
        flip=full(lambda drawn: _bytes(drawn, flip_image(EXACT))),
        shared=full(lambda drawn: _bytes(drawn, EXACT, COMPLEXITY, TRANSMITTANCE)),
        memory=_OWN_BYTES * pixels[-1] + full(lambda drawn: drawn.outcome.memory.bytes),
    )


def extrapolate(pixels: Sequence[int], small: float, middle: float) -> float:
    """Return a cost at the last of three numbers of pixels; it never falls with more of them."""
    if pixels[1] == pixels[0]:
        return middle
    slope = max(0.0, middle - small) / (pixels[1] - pixels[0])
    return middle + slope * (pixels[2] - pixels[1])


def _bytes(drawn: Drawn, *kinds: str) -> int:
    images = drawn.outcome.images
    return sum(images[kind].bytes for kind in kinds if kind in images)


def _divided(size: Size, divisor: int) -> Size:
    """Return a size whose sides are shorter, and not empty."""
    return max(1, size[0] // divisor), max(1, size[1] // divisor)
