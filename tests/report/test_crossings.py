"""Where errors of two families cross."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest

from oitbench.report import crossings
from oitbench.report.crossings import Grid, crossing, lead, sweeps, swept_rows
from oitbench.report.families import Case


def stack(row: str, layers: float, seed: str, opacity: float, **errors: float) -> Case:
    return Case(f"{row} {layers} {seed}", True, row, seed, layers, opacity, errors, {})


def grid_of(stacks: Iterable[Case]) -> Grid | None:
    return crossings.grid_of(swept_rows(stacks))


def grid(seeds: str = "123", layers: tuple[int, ...] = (4, 16, 64)) -> Grid:
    """Return stacks in which `list` grows with layers and `curve` with opacity."""
    found = grid_of(
        stack(f"row {o}", n, seed, o, list=1e-3 * n * (1 + 0.1 * int(seed)), curve=0.1 * o)
        for o in (0.4, 0.1)
        for n in layers
        for seed in seeds
    )
    assert found is not None
    return found


def test_a_crossing_is_interpolated_on_logarithms() -> None:
    assert crossing((4, 16, 64), (-1, -1, 1)) == pytest.approx(32)
    assert crossing((4, 16, 64), (-3, 1, 2)) == pytest.approx(4 * 4**0.75)
    assert crossing((0.4, 0.1), (-1, 1)) == pytest.approx(0.2)


def test_the_second_family_must_stay_better() -> None:
    assert crossing((1, 2, 4, 8, 16), (1, 1, -1, 1, 1)) == pytest.approx(4 * math.sqrt(2))
    assert crossing((1, 2, 4), (1, 1, -1)) == math.inf
    assert crossing((4, 2, 1), (1, 1, -1)) == 0


def test_a_family_that_always_wins_has_no_crossing() -> None:
    assert crossing((1, 2, 4), (1, 1, 1)) == 0
    assert crossing((1, 2, 4), (-1, -1, 0)) == math.inf
    assert crossing((4, 2, 1), (1, 1, 1)) == math.inf


def test_errors_that_no_display_shows_are_equal() -> None:
    found = lead(np.array([1e-9, 1e-2]), np.array([1e-5, 1e-3]))
    np.testing.assert_allclose(found, [0, math.log(10)])


def test_rows_are_sorted_by_opacity_and_hold_all_combinations() -> None:
    found = grid()
    assert found.rows == ("row 0.1", "row 0.4")
    assert found.opacities == pytest.approx((0.1, 0.4))
    assert (found.layers, found.seeds) == ((4, 16, 64), 3)
    errors = found.errors(["list", "curve"])
    assert errors.shape == (2, 3, 3)
    assert errors[1, 0, 0] == pytest.approx(4.4e-3)  # the list, of the first seed
    assert errors[0, 2, 0] == pytest.approx(0.01)  # the curve
    assert np.isinf(found.errors([])).all()


def test_rows_without_all_stacks_are_left_out() -> None:
    whole = [stack("a", n, s, 0.1) for n in (1, 2, 3) for s in "12"]
    part = [stack("b", n, s, 0.2) for n in (1, 2, 3) for s in "12"][:-1]
    found = grid_of([*part, *whole])
    assert found is not None
    assert found.rows == ("a",)
    assert grid_of(case for case in whole if case.layers < 3) is None
    assert grid_of([]) is None


def test_stacks_without_all_methods_do_not_count() -> None:
    whole = [stack("a", n, "1", 0.1, list=1.0, curve=1.0) for n in (1, 2, 3)]
    part = [stack("b", n, "1", 0.2, list=1.0, curve=1.0) for n in (1, 2, 3)]
    part[0] = replace(part[0], rmse={"list": 1.0})
    found = grid_of([*part, *whole])
    assert found is not None
    assert found.rows == ("a",)
    assert grid_of([part[0], *whole[1:]]) is None


def test_each_row_and_each_number_of_layers_is_swept() -> None:
    found = grid()
    swept = list(sweeps(found, found.errors(["list"]), found.errors(["curve"])))
    assert [(s.by_layers, s.at) for s in swept] == [
        (True, 0), (True, 1), (False, 0), (False, 1), (False, 2)
    ]  # fmt: skip
    # list = curve at 1e-3 n (1 + seed / 10) = 0.1 opacity: both are exact powers.
    by_layers = swept[1]
    assert by_layers.fixed == pytest.approx(0.4)
    expected = [40 / (1 + 0.1 * seed) for seed in (1, 2, 3)]
    assert by_layers.crossings == pytest.approx(expected)
    assert by_layers.middle == pytest.approx(expected[1])
    assert (by_layers.crosses, by_layers.nearest) == (True, 2)
    by_opacity = swept[3]
    assert by_opacity.crossings == pytest.approx([0.176, 0.192, 0.208])
    assert by_opacity.nearest == 0
    assert not swept[2].crosses
    errors = found.errors(["curve"])
    np.testing.assert_allclose(by_opacity.along(errors), [0.01, 0.04])
    np.testing.assert_allclose(by_layers.along(errors), 0.04)


def test_a_single_row_is_swept_over_layers_alone() -> None:
    found = grid_of(stack("a", n, "1", 0.1, list=n, curve=1) for n in (1, 2, 3))
    assert found is not None
    (only,) = crossings.sweeps(found, found.errors(["list"]), found.errors(["curve"]))
    assert only.by_layers
