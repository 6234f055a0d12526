"""Clocks that time the work of a frame: the wall clock, and the GPU's own."""

from __future__ import annotations

import time
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Literal, Protocol

from oitbench.gl.device import Device
from oitbench.gl.draws.records import Lap
from oitbench.gl.timestamps import Timestamps

Name = Literal["wall", "gpu"]
_MILLISECONDS, _NANOSECONDS = 1e3, 1e-6


@dataclass
class Parts:
    """The time of each part of a frame in milliseconds, and the number of laps.

    A part that ends several times, as the passes of a loop do, has the sum of its laps.
    """

    ms: dict[Hashable, float] = field(default_factory=dict)
    laps: int = 0

    def add(self, key: Hashable, milliseconds: float) -> None:
        """Add the time of a lap."""
        self.ms[key] = self.ms.get(key, 0.0) + milliseconds
        self.laps += 1

    @property
    def total(self) -> float:
        """Sum of all parts."""
        return sum(self.ms.values())


@dataclass(frozen=True)
class Drawn:
    """Time of issued work in milliseconds; `gpu` is the GPU's part, None on a software renderer."""

    ms: float
    gpu: float | None = None


class Clock(Protocol):
    """Times work in milliseconds. All earlier work is complete before the time begins."""

    @property
    def name(self) -> Name:
        """The kind of clock, as a record names it."""

    def run(self, work: Callable[[], object]) -> float:
        """Return the time until work of the CPU, and all that it uploads, is complete."""

    def draw(self, work: Callable[[], object]) -> Drawn:
        """Return the time of drawing."""

    def parts(self, work: Callable[[Lap], object]) -> Parts:
        """Return the time of each part of drawing; `work` receives the function that ends one."""


@dataclass(frozen=True)
class WallClock:
    """Times work by the wall clock, between two waits for the renderer.

    Parameters
    ----------
    finish : callable
        Waits until the renderer has completed all work.
    now : callable
        Returns the time in seconds.
    """

    finish: Callable[[], None]
    now: Callable[[], float] = time.perf_counter
    name: Name = "wall"

    def run(self, work: Callable[[], object]) -> float:
        """Return the time until `work` and everything that it issues is complete."""
        self.finish()
        start = self.now()
        work()
        self.finish()
        return _MILLISECONDS * (self.now() - start)

    def draw(self, work: Callable[[], object]) -> Drawn:
        """Return the time of drawing: a software renderer draws on the CPU."""
        return Drawn(self.run(work))

    def parts(self, work: Callable[[Lap], object]) -> Parts:
        """Return the time of each part; the renderer is waited for at the end of each."""
        found = Parts()
        self.finish()
        start = self.now()

        def lap(key: Hashable) -> None:
            nonlocal start
            self.finish()
            end = self.now()
            found.add(key, _MILLISECONDS * (end - start))
            start = end

        work(lap)
        return found


@dataclass(frozen=True)
class GpuClock:
    """Times work of the CPU by the wall clock, and drawing by timestamps of the GPU.

    Parameters
    ----------
    wall : WallClock
    stamps : Timestamps
        Or an object with the same methods.
    """

    wall: WallClock
    stamps: Timestamps
    name: Name = "gpu"

    def run(self, work: Callable[[], object]) -> float:
        """Return the time until `work` and everything that it uploads is complete."""
        return self.wall.run(work)

    def draw(self, work: Callable[[], object]) -> Drawn:
        """Return the GPU's time, or the time that the CPU takes to submit if that is longer."""
        self.wall.finish()
        start = self.wall.now()
        self.stamps.stamp()
        work()
        self.stamps.stamp()
        submitted = _MILLISECONDS * (self.wall.now() - start)
        first, last = self.stamps.read()
        gpu = _NANOSECONDS * (last - first)
        return Drawn(max(submitted, gpu), gpu)

    def parts(self, work: Callable[[Lap], object]) -> Parts:
        """Return the GPU's time of each part, without waiting between them."""
        keys: list[Hashable] = []

        def lap(key: Hashable) -> None:
            self.stamps.stamp()
            keys.append(key)

        self.wall.finish()
        self.stamps.stamp()
        work(lap)
        times = self.stamps.read()
        found = Parts()
        for key, start, end in zip(keys, times[:-1], times[1:], strict=True):
            found.add(key, _NANOSECONDS * (end - start))
        return found


@contextmanager
def clock_of(device: Device) -> Iterator[Clock]:
    """Yield the clock that fits the renderer.

    Software renderers are timed by the wall clock: their time queries end before rasterization.
    """
    wall = WallClock(device.finish)
    with Timestamps(device) as stamps:
        yield wall if device.software else GpuClock(wall, stamps)
