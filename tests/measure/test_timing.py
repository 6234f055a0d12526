"""Medians, intervals and rounds of made-up times."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, cast

import numpy as np
import pytest

from oitbench.gl.draws.records import PassRecord
from oitbench.gl.frame import Frame, FrameMeasurement
from oitbench.measure.timing import Samples, interval, measure, times
from oitbench.results.schema import Interval, PassTime


class FakeFrame:
    """A frame that logs its name at each draw."""

    def __init__(self, name: str, log: list[str]) -> None:
        self.name, self.log, self.device, self.software = name, log, self, True

    def sort(self, permutation: int | None) -> float:
        assert permutation is None
        return 0.25

    def issue(self) -> None:
        self.log.append(self.name)

    def finish(self) -> None:
        pass


def rounds_of(names: str, log: Sequence[str]) -> list[tuple[str, ...]]:
    return [tuple(log[i : i + len(names)]) for i in range(0, len(log), len(names))]


def measured(names: str, rounds: int, budget: float, **more: Any) -> tuple[dict[str, Samples], Any]:
    log: list[str] = []
    frames = {name: cast(Frame, FakeFrame(name, log)) for name in names}
    return measure(frames, rounds, budget, **more), rounds_of(names, log)


def test_equal_samples_have_an_interval_of_length_zero() -> None:
    assert interval([3.0] * 5) == Interval(3.0, 3.0, 3.0, [3.0] * 5)


def test_a_single_sample_has_an_interval_of_length_zero() -> None:
    assert interval([7.5]) == Interval(7.5, 7.5, 7.5, [7.5])


def test_the_interval_of_normal_samples_contains_the_median() -> None:
    samples = np.random.default_rng(5).normal(10.0, 1.0, 401).tolist()
    found = interval(samples)
    assert found.samples == samples
    assert found.median == np.median(samples)
    assert found.low < 10.0 < found.high
    # The standard error of the median of a normal sample is 1.253 σ/√n.
    assert (found.high - found.low) / 2 == pytest.approx(1.96 * 1.253 / 401**0.5, rel=0.4)


def test_an_outlier_does_not_change_the_median() -> None:
    assert interval([1.0, 1.0, 1.0, 1.0, 900.0]).median == 1.0


def test_the_interval_is_repeatable() -> None:
    samples = [1.0, 5.0, 2.0, 8.0, 3.0]
    assert interval(samples, seed=3) == interval(samples, seed=3)


def test_every_frame_is_timed_once_per_round_in_random_order() -> None:
    timings, rounds = measured("abcd", rounds=6, budget=60.0, warm_up=2)
    assert len(rounds) == 8
    assert all(sorted(one) == list("abcd") for one in rounds)
    assert len(set(rounds)) > 1
    assert {name: len(t.frame_ms) for name, t in timings.items()} == dict.fromkeys("abcd", 6)


def test_the_order_depends_on_the_seed() -> None:
    assert measured("abcd", 6, 60.0, seed=1)[1] == measured("abcd", 6, 60.0, seed=1)[1]
    assert measured("abcd", 6, 60.0, seed=1)[1] != measured("abcd", 6, 60.0, seed=2)[1]


def test_at_least_three_rounds_are_timed() -> None:
    timings, rounds = measured("ab", rounds=50, budget=0.0, warm_up=1)
    assert len(rounds) == 4
    assert len(timings["a"].frame_ms) == 3


def test_frame_sort_and_passes_have_separate_times() -> None:
    passes = FrameMeasurement([PassRecord("over", 1, 12, 0.5)], [PassRecord("maps", 2, 7, 1.5)], [])
    found = times(Samples([2.0, 4.0, 9.0], [0.5, 0.25, 0.75]), passes)
    assert found.sort_ms == 0.5
    assert found.frame_ms.median == 4.0
    assert found.frame_ms.samples == [2.0, 4.0, 9.0]
    assert found.passes == [PassTime("over", 0.5, 12)]
    assert found.shading == [PassTime("maps", 1.5, 7)]
