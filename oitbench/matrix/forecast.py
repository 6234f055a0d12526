"""The time that a run has left, from its finished cells."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from oitbench.matrix.cell import Cell
from oitbench.matrix.cost_model import CostModel
from oitbench.measure.rounds import Schedule

_Scene = tuple[str, tuple[int, int]]
_MINUTE, _HOUR = 60.0, 3600.0


class Forecast:
    """The time left, as it is expected from the cells that are finished.

    Cells of costly scenes and methods weigh more. Timing is expected to take its budget until a
    scene is timed, and then what scenes have taken.

    Parameters
    ----------
    cells : iterable of Cell
    schedule : Schedule
    workers : int
        Processes that render at once.
    """

    def __init__(self, cells: Iterable[Cell], schedule: Schedule, workers: int) -> None:
        self._open = dict.fromkeys(cells)
        self._total, self._workers = len(self._open), workers
        self._samples: list[tuple[Cell, float]] = []
        self._schedule = schedule
        self._timed: dict[_Scene, float] = {}

    @property
    def total(self) -> int:
        """Number of all cells."""
        return self._total

    @property
    def done(self) -> int:
        """Number of cells that are finished or kept."""
        return self._total - len(self._open)

    def finish(self, cell: Cell, seconds: float | None) -> None:
        """Take a cell off the list; `seconds` is None for one that is kept, or that failed."""
        self._open.pop(cell, None)
        if seconds is not None:
            self._samples.append((cell, seconds))

    def finish_timing(self, cells: Sequence[Cell], seconds: float) -> None:
        """Take cells off the list that were timed together."""
        self._timed |= {_scene(cell): seconds for cell in cells}

    def left(self) -> float | None:
        """Return the seconds left; None while no cell is finished."""
        if self._open and not self._samples:
            return None
        rendering = 0.0
        if self._open:
            rendering = float(CostModel(self._samples).predict([*self._open]).sum())
        return rendering / self._workers + self._timing()

    def _timing(self) -> float:
        if not self._schedule.rounds:
            return 0.0
        # Scenes whose cells are all kept have their times.
        due = {_scene(cell) for cell in (*self._open, *(cell for cell, _ in self._samples))}
        mean = self._schedule.budget
        if self._timed:
            mean = sum(self._timed.values()) / len(self._timed)
        return mean * len(due - self._timed.keys())


def _scene(cell: Cell) -> _Scene:
    """Return the name of the cells that are timed together."""
    return cell.seen, cell.size


def duration(seconds: float) -> str:
    """Return seconds in words with two digits at most, as in "45 s", "3 min" or "1.5 h"."""
    if seconds < 1.5 * _MINUTE:
        return f"{seconds:.0f} s"
    if seconds < 1.5 * _HOUR:
        return f"{seconds / _MINUTE:.0f} min"
    return f"{seconds / _HOUR:.1f} h"
