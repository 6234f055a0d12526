"""Clocks that count work, with a made-up renderer; and the timestamps of a real one."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable
from typing import cast

import pytest

from oitbench.gl.device import Device
from oitbench.gl.timestamps import Timestamps
from oitbench.measure.clock import Drawn, GpuClock, WallClock


class Renderer:
    """A made-up renderer with a clock: it begins with its work when it is waited for."""

    def __init__(self) -> None:
        self.time = 0.0
        self._queue: list[float] = []
        self._stamps: list[int] = []

    def now(self) -> float:
        return self.time

    def compute(self, seconds: float) -> None:
        """Keep the CPU busy."""
        self.time += seconds

    def submit(self, seconds: float) -> None:
        """Give the renderer work."""
        self._queue.append(seconds)

    def stamp(self) -> None:
        self._queue.append(math.nan)

    def finish(self) -> None:
        for seconds in self._queue:
            if math.isnan(seconds):
                self._stamps.append(round(1e9 * self.time))
            else:
                self.time += seconds
        self._queue = []

    def read(self) -> list[int]:
        self.finish()
        found, self._stamps = self._stamps, []
        return found

    @property
    def wall_clock(self) -> WallClock:
        return WallClock(self.finish, self.now)

    @property
    def gpu_clock(self) -> GpuClock:
        return GpuClock(self.wall_clock, cast(Timestamps, self))


def test_the_wall_clock_waits_for_earlier_work_and_for_its_own() -> None:
    renderer = Renderer()
    renderer.submit(5.0)

    def work() -> None:
        renderer.compute(0.25)
        renderer.submit(0.5)

    assert renderer.wall_clock.run(work) == 750.0
    assert renderer.wall_clock.draw(work) == Drawn(750.0)


@pytest.mark.parametrize(
    ("submission", "drawing", "time"), [(0.25, 0.5, 500.0), (0.5, 0.25, 500.0)]
)
def test_the_longer_of_submission_and_drawing_counts_on_a_gpu(
    submission: float, drawing: float, time: float
) -> None:
    renderer = Renderer()
    renderer.submit(5.0)

    def work() -> None:
        renderer.submit(drawing)
        renderer.compute(submission)

    found = renderer.gpu_clock.draw(work)
    assert found == Drawn(time, 1000 * drawing)


def test_work_of_the_cpu_counts_on_a_gpu_with_its_upload() -> None:
    renderer = Renderer()

    def work() -> None:
        renderer.compute(0.5)
        renderer.submit(0.125)

    assert renderer.gpu_clock.run(work) == 625.0


def parts(renderer: Renderer) -> Callable[[Callable[[Hashable], None]], None]:
    def work(lap: Callable[[Hashable], None]) -> None:
        for key, seconds in (("a", 0.5), ("b", 0.25), ("a", 1.0)):
            renderer.submit(seconds)
            lap(key)

    return work


@pytest.mark.parametrize("kind", ["wall_clock", "gpu_clock"])
def test_laps_of_one_part_are_added_up(kind: str) -> None:
    renderer = Renderer()
    found = getattr(renderer, kind).parts(parts(renderer))
    assert found.ms == {"a": 1500.0, "b": 250.0}
    assert found.laps == 3
    assert found.total == 1750.0


def test_a_gpu_does_not_wait_between_parts() -> None:
    renderer = Renderer()
    waits = []
    clock = GpuClock(
        WallClock(lambda: waits.append(renderer.time), renderer.now), cast(Timestamps, renderer)
    )
    clock.parts(parts(renderer))
    assert waits == [0.0]


def test_timestamps_rise_and_are_used_again(device: Device) -> None:
    with Timestamps(device) as stamps:
        for count in (3, 2):
            for _ in range(count):
                stamps.stamp()
            found = stamps.read()
            assert len(found) == count
            assert found == sorted(found)
        assert stamps.read() == []
