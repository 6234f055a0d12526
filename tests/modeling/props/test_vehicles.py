"""Vehicles: their size, symmetry, and windows between body and roof."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.modeling.props.vehicles import SEDAN, VAN, Shape, vehicle
from tests.meshes import bounds, coincident


@pytest.mark.parametrize("shape", [SEDAN, VAN])
def test_a_vehicle_is_life_size_and_stands_on_its_wheels(shape: Shape) -> None:
    car = vehicle(shape, 0.5)
    low, high = bounds(car.paint)
    assert 4 < high[0] - low[0] < 5
    assert high[1] == pytest.approx(shape.roof + 0.05, abs=0.04)
    assert high[2] - low[2] == pytest.approx(shape.width, rel=0.03)
    assert bounds(car.rubber)[0][1] == pytest.approx(0, abs=0.02)
    assert low[1] > 0.2
    assert coincident([car.paint, car.glass, car.rubber, car.metal]) == 0


@pytest.mark.parametrize("shape", [SEDAN, VAN])
def test_windows_are_all_around_between_belt_and_roof(shape: Shape) -> None:
    glass = vehicle(shape, 0.5).glass.positions
    assert glass[:, 1].min() > 0.7
    assert glass[:, 1].max() == pytest.approx(shape.roof)
    np.testing.assert_allclose(np.sort(glass[:, 2]), np.sort(-glass[:, 2]), atol=1e-12)
    assert glass[:, 0].min() == pytest.approx(shape.glass[0])
    assert glass[:, 0].max() == pytest.approx(shape.glass[3])
