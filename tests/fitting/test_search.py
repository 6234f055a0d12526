"""The search in a box: places and values, and what it finds."""

from __future__ import annotations

from collections.abc import Mapping

import pytest

from oitbench.errors import UsageError
from oitbench.fitting.search import Axis, free_axes, minimize
from oitbench.parameters import AnyParameter, Parameter

RATIO, LINE = Axis("ratio", 0.01, 100.0), Axis("line", 0.0, 4.0)


def test_positive_ranges_have_equal_ratios_and_others_equal_steps() -> None:
    assert [RATIO.value(p) for p in (0, 0.25, 0.5, 1)] == [0.01, 0.1, 1, 100]
    assert [LINE.value(p) for p in (0, 0.25, 0.5, 1)] == [0, 1, 2, 4]
    for axis in (RATIO, LINE):
        assert axis.value(axis.place(3.0)) == 3.0


def test_values_have_three_digits_and_stay_in_their_bounds() -> None:
    assert Axis("x", 0.0, 1.0).value(1 / 3) == 0.333
    assert Axis("x", 1.0, 1.2345).value(1.0) == 1.23
    assert Axis("x", 1.2345, 2.0).value(0.0) == 1.2345


def test_decimal_numbers_with_two_bounds_that_are_not_fixed_are_free() -> None:
    parameters: dict[str, AnyParameter] = {
        "a": Parameter(1.0, low=0.5, high=2.0),
        "fixed": Parameter(1.0, low=0.5, high=2.0),
        "open": Parameter(1.0, low=0.5),
        "whole": Parameter(1, low=0, high=2),
        "text": Parameter("x", choices=("x", "y")),
    }
    assert free_axes("m", parameters, ["fixed"]) == (Axis("a", 0.5, 2.0),)
    with pytest.raises(UsageError, match="m has no parameter to fit"):
        free_axes("m", parameters, ["a", "fixed"])


def test_the_search_finds_the_bottom_of_a_valley() -> None:
    asked: list[Mapping[str, float]] = []

    def error(values: Mapping[str, float]) -> float:
        asked.append(values)
        return (RATIO.place(values["ratio"]) - 0.7) ** 2 + (LINE.place(values["line"]) - 0.2) ** 2

    start = {"ratio": 1.0, "line": 2.0}
    best = minimize((RATIO, LINE), start, error, 80)
    assert asked[0] == start
    assert len(asked) <= 80
    assert len({tuple(values.items()) for values in asked}) == len(asked)
    assert RATIO.place(best["ratio"]) == pytest.approx(0.7, abs=0.02)
    assert LINE.place(best["line"]) == pytest.approx(0.2, abs=0.02)
    assert error(best) == min(error(values) for values in [*asked])


def test_a_start_that_nothing_beats_is_the_result() -> None:
    start = {"ratio": 1.0}
    assert minimize((RATIO,), start, lambda values: abs(values["ratio"] - 1), 10) == start


def test_the_number_of_evaluations_is_a_limit() -> None:
    asked: list[float] = []

    def error(values: Mapping[str, float]) -> float:
        asked.append(values["line"])
        return -values["line"]

    minimize((LINE,), {"line": 1.0}, error, 3)
    assert len(asked) == 3
