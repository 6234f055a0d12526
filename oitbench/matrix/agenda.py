"""Scenes as units of work: one for each worker, and one for several when some would be idle."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

from oitbench.matrix.cell import Cell
from oitbench.results.schema import Fingerprints
from oitbench.workers.process import WorkerError


@dataclass(eq=False)
class SceneWork:
    """The cells of one scene, which several workers may share; any thread may use it.

    Parameters
    ----------
    cells : sequence of Cell

    Attributes
    ----------
    content : dict of Cell to Fingerprints or None
        Of the cells that had a result before.
    lost : WorkerError or None
        Why a part of the work failed that all cells need.
    """

    cells: Sequence[Cell]
    content: dict[Cell, Fingerprints | None] = field(default_factory=dict, init=False)
    lost: WorkerError | None = field(default=None, init=False)
    _left: deque[Cell] = field(default_factory=deque, init=False)
    _workers: int = field(default=0, init=False)
    _preparing: float = field(default=0.0, init=False)
    _seconds: list[float] = field(default_factory=list, init=False)
    _lock: threading.Lock = field(default_factory=threading.Lock, init=False)

    def join(self) -> bool:
        """Add a worker; return whether it is the first one, which must call `begin`."""
        with self._lock:
            self._workers += 1
            return self._workers == 1

    def begin(self, cells: Iterable[Cell]) -> None:
        """Put down the cells that are drawn."""
        with self._lock:
            self._left.extend(cells)

    def take(self) -> Iterator[Cell]:
        """Yield cells that no other worker has taken, until none is left."""
        while True:
            with self._lock:
                if not self._left:
                    return
                cell = self._left.popleft()
            yield cell

    def count(self, seconds: float, *, first: bool) -> None:
        """Count the seconds of a cell; the first one of a worker also prepares the scene."""
        with self._lock:
            if first:
                self._preparing = max(self._preparing, seconds)
            else:
                self._seconds.append(seconds)

    @property
    def gain(self) -> float:
        """Seconds by which one more worker ends the scene earlier; negative if it ends it later."""
        with self._lock:
            if not self._left or not self._seconds or self.lost is not None:
                return 0.0
            left = len(self._left) * sum(self._seconds) / len(self._seconds)
            return left / self._workers - (left + self._preparing) / (self._workers + 1)


class Agenda:
    """The scenes of a matrix, which workers take one by one.

    An idle worker for which no scene is left joins the one that it ends earlier, if there is any:
    otherwise one worker alone would draw the densest scene while all others have nothing to do.

    Parameters
    ----------
    cells : iterable of Cell
    """

    def __init__(self, cells: Iterable[Cell]) -> None:
        scenes: dict[str, list[Cell]] = {}
        for cell in cells:
            scenes.setdefault(cell.scene, []).append(cell)
        self._waiting = deque(map(SceneWork, scenes.values()))
        self._begun: list[SceneWork] = []

    def __len__(self) -> int:
        return len(self._waiting) + (self._shared is not None)

    def popleft(self) -> SceneWork:
        """Return the scene for the next worker.

        Raises
        ------
        IndexError
            If there is none.
        """
        if self._waiting:
            self._begun.append(self._waiting.popleft())
            return self._begun[-1]
        shared = self._shared
        if shared is None:
            raise IndexError("no scene is left")
        return shared

    @property
    def _shared(self) -> SceneWork | None:
        """The scene that gains most from one more worker; None if all lose."""
        best = max(self._begun, key=lambda scene: scene.gain, default=None)
        return best if best is not None and best.gain > 0 else None
