"""Furniture: stands on the floor, and lamps whose flame is inside of the flue."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from oitbench.modeling.props.furniture import (
    FLAME,
    around_table,
    chair,
    cloth,
    oil_lamp,
    plate_of_china,
    pot,
    round_table,
)
from oitbench.scene import Mesh
from tests.meshes import agreement, boundary, bounds, has_unit_normals, hits, signed_volume

CLOSED: dict[str, Callable[[float], Mesh]] = {
    "table": lambda detail: round_table(0.5, 0.74, detail),
    "chair": chair,
    "plate": lambda detail: plate_of_china(0.13, detail),
    "pot": lambda detail: pot(0.3, 0.46, detail),
    "lamp": lambda detail: oil_lamp(detail).base,
    "flame": lambda detail: oil_lamp(detail).flame,
}


@pytest.mark.parametrize("detail", [0.02, 1.0])
@pytest.mark.parametrize("name", CLOSED)
def test_furniture_is_closed(name: str, detail: float) -> None:
    mesh = CLOSED[name](detail)
    assert not len(boundary(mesh))
    assert signed_volume(mesh) > 0
    assert has_unit_normals(mesh)
    if name != "flame":
        assert bounds(mesh)[0][1] == pytest.approx(0, abs=0.003)


def test_the_flame_is_inside_of_a_flue_that_is_open_above() -> None:
    lamp = oil_lamp(1.0)
    low, high = bounds(lamp.flame)
    np.testing.assert_allclose((low + high) / 2, FLAME, atol=1e-3)
    for ray in ((1, 0, 0.1), (-1, 0, 0.2), (0.1, 0, -1)):
        assert len(hits(lamp.flue, FLAME, ray)) == 1
        assert hits(lamp.flue, FLAME, ray)[0] > 0.012
    assert not len(hits(lamp.flue, FLAME, (0, 1, 0)))


def test_a_cloth_is_flat_on_the_table_and_hangs_down_in_folds() -> None:
    drape = cloth(0.5, 0.22, 9, 1.0)
    assert has_unit_normals(drape)
    assert (agreement(drape).sum(axis=1) > 0).all()
    low, high = bounds(drape)
    assert (low[1], high[1]) == (pytest.approx(-0.22), 0.0)
    hem = drape.positions[drape.positions[:, 1] == low[1]]
    radii = np.hypot(hem[:, 0], hem[:, 2])
    rising = np.diff(radii) > 0
    assert (rising[1:] != rising[:-1]).sum() == pytest.approx(18, abs=2)


def test_things_around_a_table_look_at_its_middle() -> None:
    places = around_table(0.8, 3, 0.5)
    assert places.shape == (3, 3, 4)
    np.testing.assert_allclose(np.linalg.norm(places[:, :, 3], axis=1), 0.8)
    # A chair faces +z.
    np.testing.assert_allclose(places[:, :, 2], -places[:, :, 3] / 0.8, atol=1e-12)
    assert places[0, :, 3] == pytest.approx([0.8 * math.sin(0.5), 0, 0.8 * math.cos(0.5)])
