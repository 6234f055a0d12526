"""Draws a few cells of each scene at small sizes, from which the costs of all are extrapolated.

A cell that is drawn for the first time also compiles its shaders. Most cells are drawn at a quarter
and at half of the sides of their pictures. One that is slow at a quarter is drawn at an eighth
instead of a half, unless it fails there: all layers of hair then lie at few pixels.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import msgspec

from oitbench.errors import OitbenchError, StorageError
from oitbench.matrix.cell import Cell
from oitbench.matrix.probe import ProbedTruth, ProbeTruths, TruthsProbed
from oitbench.matrix.samples import (
    Drawn,
    SceneSamples,
    Size,
    extrapolated,
    permuted_growth,
    separate_shared,
)
from oitbench.matrix.timed_cells import ScoredCell
from oitbench.matrix.worker import CellDone, CellsTimed, RunCell, TimeCells
from oitbench.truths import EXACT
from oitbench.workers.process import Process

OnStage = Callable[[str, str], None]
LEAST_SAMPLES, MOST_SAMPLES = 2, 4
"""Cells of each scene that are drawn."""
_TINY, _SMALL, _MIDDLE = 8, 4, 2
"""Divisors of the sides of the small sizes; the first one is for slow cells alone."""
_SLOW = 4.0
"""Seconds of a cell at the small size beyond which it is drawn at the tiny one."""
_NOT_DRAWING = ("permutations", "building", "metrics", "references")
"""Kinds of work of a cell that are no drawing at its own size."""
TASKS = 2
"""Tasks of a cell in a round of timing: the whole method, and its passes."""


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

    def draw(self, cell: Cell, size: Size, *, permuted: bool = False) -> Drawn | None:
        """Draw a cell at a size, with or without permuted draws; None if it has no picture."""
        count = cell.permutations if permuted else 0
        small = msgspec.structs.replace(cell, size=size, truths=(EXACT,), permutations=count)
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
        permutations, building, metrics, _ = other
        seconds, line = done.record.seconds - sum(other), len(msgspec.json.encode(done.record))
        return Drawn(seconds, permutations, building, metrics, line, done.record.outcome)

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
        agains = self._draw_all(firsts, small, permuted=True)
        slow = [cell for cell, one in agains.items() if one.seconds > _SLOW]
        tinies, _ = self._draw_sharing(slow, tiny)
        # Permuted pictures of a quarter may be smaller than those of the whole.
        permuted = permuted_growth(cells[0], small) > 1
        others = [cell for cell in agains if cell not in tinies]
        middles, shared = self._draw_sharing(others, middle, permuted=permuted)
        rounds: dict[Cell, float] = {}
        if self.timed:
            smalls = {cell: one for cell, one in agains.items() if cell not in middles}
            rounds = self._time(smalls, small)
            rounds |= self._time(middles, middle)
        for cell, again in agains.items():
            smaller: Drawn | None = again
            sizes, larger = (small, middle, full), middles.get(cell)
            if larger is None:
                sizes, smaller, larger = (tiny, small, full), tinies.get(cell), again
            size, drawn = (middle, larger) if permuted and cell in middles else (small, again)
            found.samples.append(
                extrapolated(
                    cell,
                    [math.prod(size) for size in sizes],
                    smaller,
                    larger,
                    first=max(0.0, firsts[cell].seconds - again.seconds),
                    permutations=drawn.permutations * permuted_growth(cell, size),
                    round=rounds.get(cell, 0.0),
                )
            )
        if found.samples:
            found.building = max(one.building for one in firsts.values())
            pixels = [math.prod(size) for size in (small, middle, full)]
            alone = agains[found.samples[0].cell]
            separate_shared(found, alone, shared if middles else None, pixels)
            found.truths = self._truths(cells[0])
        return found

    def _draw_sharing(
        self, cells: list[Cell], size: Size, *, permuted: bool = False
    ) -> tuple[dict[Cell, Drawn], float]:
        """Draw cells at a new size, and return also the seconds of what they share there.

        The first cell uploads the scene and draws exact compositing; then it is drawn again.
        """
        drawn = self._draw_all(cells, size, permuted=permuted)
        if not drawn:
            return {}, 0.0
        first = next(iter(drawn))
        again = self.draw(first, size, permuted=permuted) or drawn[first]
        sharing, drawn[first] = drawn[first].seconds - again.seconds, again
        return drawn, max(0.0, sharing)

    def _draw_all(
        self, cells: Iterable[Cell], size: Size, *, permuted: bool = False
    ) -> dict[Cell, Drawn]:
        """Draw cells at a size; those that have no picture are left out."""
        drawn = {cell: self.draw(cell, size, permuted=permuted) for cell in cells}
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


def _divided(size: Size, divisor: int) -> Size:
    """Return a size whose sides are shorter, and not empty."""
    return max(1, size[0] // divisor), max(1, size[1] // divisor)
