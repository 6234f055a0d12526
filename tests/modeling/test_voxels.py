"""Voxels: values in between, gradients, densities, and integrals along rays."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.modeling.voxels import Voxels, density, sampled
from oitbench.scene import Floats, Vector

LOW, HIGH = (0.0, 0.0, 0.0), (1.0, 2.0, 3.0)


def slope(points: Floats) -> Floats:
    return np.asarray(points @ [1.0, -2.0, 0.5])


def test_a_linear_function_is_exact_inside_and_held_outside() -> None:
    voxels = sampled(slope, LOW, HIGH, 0.3)
    points = np.random.default_rng(0).random((50, 3)) * HIGH
    np.testing.assert_allclose(voxels.at(points), slope(points), atol=1e-12)
    assert voxels.at(np.array([(9.0, 0.0, 0.0)]))[0] == pytest.approx(1.0)
    rising = np.array([1.0, -2.0, 0.5]) / np.sqrt(5.25)
    np.testing.assert_allclose(voxels.gradient(points), np.tile(rising, (50, 1)), atol=1e-9)


@pytest.mark.parametrize("direction", [(0, 1, 0), (0, 0, -2), (0.3, 1, -0.2), (-1, 0.2, 0.4)])
def test_integrals_are_lengths_of_the_way_out(direction: Vector) -> None:
    whole = Voxels(LOW, HIGH, np.ones((21, 41, 61)))
    middle = np.array([(0.5, 1.0, 1.5)])
    way = np.asarray(direction) / np.linalg.norm(direction)
    room = np.where(way > 0, np.subtract(HIGH, middle[0]), middle[0])
    out = (room[way != 0] / np.abs(way[way != 0])).min()
    found = whole.integral_toward(direction).at(middle)[0]
    assert found == pytest.approx(out, rel=0.07)


def test_what_is_behind_casts_no_shadow() -> None:
    values = np.zeros((11, 11, 11))
    values[:, 8] = 1.0
    above = Voxels(LOW, (1.0, 1.0, 1.0), values).integral_toward((0, 1, 0))
    assert above.at(np.array([(0.5, 0.3, 0.5)]))[0] == pytest.approx(0.1)
    assert above.at(np.array([(0.5, 0.95, 0.5)]))[0] == 0


def test_a_density_holds_all_weight() -> None:
    points = np.random.default_rng(1).random((200, 3)) * HIGH
    found = density(points, 0.5, LOW, HIGH, 0.25)
    assert found.values.sum() * found.spacing.prod() == pytest.approx(100)
    flat = density(points, 0.5, LOW, HIGH, (0.25, 2.0, 0.25))
    assert flat.values.shape == (5, 2, 13)
    assert found.smoothed(0.01).values.sum() == pytest.approx(found.values.sum())
