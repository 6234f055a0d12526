"""Errors and their bounds."""

from __future__ import annotations

import math

import numpy as np
import pytest

from oitbench.stability.check import Bound, Expectation
from oitbench.stability.judge import Deviation, judge
from oitbench.stability.tolerance import rounding, tolerance
from tests.helpers import method

EXACT, RANDOM = "a_buffer[node=compact]", "stochastic"
ONES = np.ones((4, 4, 3))


def test_equal_means_equal() -> None:
    nearly = Expectation(ONES, ONES + 1e-6, bound=Bound.EQUAL)
    found = judge(method(EXACT), nearly)
    assert not found.holds
    assert found.allowed == 0.0
    assert found.error == pytest.approx(1e-6)
    assert judge(method(EXACT), Expectation(ONES, ONES, bound=Bound.EQUAL)).holds


@pytest.mark.parametrize(
    ("bound", "allowed"),
    [
        (Bound.TARGETS, rounding(method(EXACT), 3, 2.0)),
        (Bound.FORMATS, tolerance(method(EXACT), 3, 2.0)),
        (Bound.DISPLAY, 2 / 255),
    ],
)
def test_bounds_grow_with_the_expected_values(bound: Bound, allowed: float) -> None:
    found = judge(method(EXACT), Expectation(2 * ONES, 2 * ONES, 3, bound))
    assert found.allowed == pytest.approx(allowed)
    slack = judge(method(EXACT), Expectation(2 * ONES, 2 * ONES, 3, bound, slack=0.5))
    assert slack.allowed == pytest.approx(allowed + 0.5)


def test_a_smaller_array_is_repeated() -> None:
    expected = np.arange(12.0).reshape(2, 2, 3)
    found = np.repeat(np.repeat(expected, 3, axis=0), 2, axis=1)
    assert judge(method(EXACT), Expectation(found, expected, bound=Bound.EQUAL)).error == 0.0


@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize("name", [EXACT, RANDOM])
def test_values_that_are_not_finite_break(name: str, value: float) -> None:
    found = judge(method(name), Expectation(np.full((4, 4, 3), value), ONES))
    assert not found.holds
    assert found.excess == math.inf


def test_random_pixels_are_compared_in_the_mean() -> None:
    scattered = ONES + 0.5 * np.where(np.indices((4, 4)).sum(axis=0) % 2, 1, -1)[..., None]
    assert not judge(method(EXACT), Expectation(scattered, ONES)).holds
    found = judge(method(RANDOM), Expectation(scattered, ONES))
    assert (found.holds, found.in_mean, found.error) == (True, True, 0.0)
    shifted = judge(method(RANDOM), Expectation(scattered + 0.9, ONES))
    assert (shifted.holds, shifted.in_mean) == (False, True)
    assert shifted.error == pytest.approx(0.9)


def test_means_are_compared_within_four_standard_errors() -> None:
    for name in (EXACT, RANDOM):
        near, far = (
            judge(method(name), Expectation(ONES + x, ONES, noise=0.1)) for x in (0.3, 0.5)
        )
        assert (near.holds, far.holds) == (True, False)
        assert near.allowed == pytest.approx(0.4 + tolerance(method(name), 1, 1.0))


def test_the_worst_deviation_exceeds_its_bound_most() -> None:
    pairs = [(0.0, 0.0), (0.1, 0.2), (0.1, 0.05), (1e-9, 0.0), (math.nan, 1.0)]
    deviations = [Deviation(error, allowed, 0.0, error) for error, allowed in pairs]
    assert [item.holds for item in deviations] == [True, True, False, False, False]
    assert [item.excess for item in deviations] == [0.0, 0.5, 2.0, math.inf, math.inf]


def test_both_values_of_the_worst_channel_are_kept() -> None:
    found, expected = ONES.copy(), np.linspace(0.9, 1.0, 12).reshape(2, 2, 3)
    found[3, 2, 1] = 3.0
    worst = judge(method(EXACT), Expectation(found, expected))
    # The smaller array is repeated: this is its last pixel.
    assert worst.found == 3.0
    assert worst.expected == pytest.approx(expected[1, 1, 1])


def test_in_the_mean_both_values_are_means_of_the_worst_channel() -> None:
    scattered = ONES + 0.5 * np.where(np.indices((4, 4)).sum(axis=0) % 2, 1, -1)[..., None]
    scattered[..., 2] += 2.0
    worst = judge(method(RANDOM), Expectation(scattered, ONES))
    assert worst.in_mean
    assert worst.found == pytest.approx(3.0)
    assert worst.expected == pytest.approx(1.0)
