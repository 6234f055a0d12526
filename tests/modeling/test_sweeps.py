"""Tubes, cylinders and plates: closed, facing outwards, of the size that they state."""

from __future__ import annotations

import math

import numpy as np
import pytest

from oitbench.modeling.sweeps import (
    around,
    circle,
    cylinder,
    gear,
    helix,
    plate,
    tube,
    upright_to,
)
from oitbench.scene import Mesh, unit
from tests.meshes import agreement, boundary, bounds, has_unit_normals, signed_volume

BODIES = {
    "tube": tube([(0, 0, 0), (0, 1, 0), (1, 2, 0), (1, 2, 2)], 0.2, 12),
    "spring": tube(helix(1.0, 3.0, 4, 120), 0.1, 6),
    "cone": tube([(0, 0, 0), (0, 0, 1)], [0.3, 0.1], 8),
    "cylinder": cylinder((1, 2, 3), (2, 2, 5), 0.4, 0.05, 16),
    "ring": plate(circle(2, 24), circle(1, 24), 0.5),
    "gear": plate(gear(12, 1.6, 2), unit(gear(12, 1.6, 2)), 0.5),
}


@pytest.mark.parametrize("mesh", BODIES.values(), ids=BODIES)
def test_bodies_are_watertight_and_face_outwards(mesh: Mesh) -> None:
    assert not len(boundary(mesh))
    assert signed_volume(mesh) > 0
    assert has_unit_normals(mesh)
    assert (agreement(mesh).sum(axis=1) > 0).all()
    assert mesh.uvs is None


def test_a_straight_tube_has_its_radius_and_length() -> None:
    low, high = bounds(tube([(0, 0, 0), (0, 3, 0)], 0.5, 64))
    np.testing.assert_allclose(low, [-0.5, 0, -0.5], atol=2e-3)
    np.testing.assert_allclose(high, [0.5, 3, 0.5], atol=2e-3)


def test_a_curved_tube_does_not_twist() -> None:
    path = np.stack([np.cos(np.linspace(0, 3, 40)), np.sin(np.linspace(0, 3, 40))], axis=1)
    bend = tube(np.concatenate([path, np.zeros((40, 1))], axis=1), 0.1, 8)
    rings = bend.positions[1:-1].reshape(40, 8, 3)
    steps = np.linalg.norm(np.diff(rings, axis=0), axis=2)
    assert steps.max() < 1.3 * steps.min()


def test_the_volume_of_a_plate_is_its_area_times_its_depth() -> None:
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    assert signed_volume(plate(square, square / 2, 0.3)) == pytest.approx(0.9)


def test_smooth_outlines_share_normals_and_creases_do_not() -> None:
    round_rim = plate(circle(1, 36), circle(0.5, 36), 1.0)
    corner = plate(circle(1, 4), circle(0.5, 4), 1.0)
    assert round_rim.normals is not None
    assert corner.normals is not None
    at = np.isclose(round_rim.positions[:, :2], [1, 0], atol=1e-9).all(axis=1)
    sides = round_rim.normals[at & (np.abs(round_rim.normals[:, 2]) < 0.5)]
    np.testing.assert_allclose(sides, np.tile([1, 0, 0], (len(sides), 1)), atol=1e-6)
    at = np.isclose(corner.positions[:, :2], [1, 0], atol=1e-9).all(axis=1)
    sides = corner.normals[at & (np.abs(corner.normals[:, 2]) < 0.5)]
    np.testing.assert_allclose(np.abs(sides[:, :2]), math.sqrt(0.5), atol=1e-6)


def test_a_band_around_two_circles_is_tangent_to_both() -> None:
    band = around([(0, 0, 1), (4, 0, 1)], 360)
    assert band[:, 1].max() == pytest.approx(1, abs=1e-3)
    assert band[:, 0].min() == pytest.approx(-1)
    assert band[:, 0].max() == pytest.approx(5)
    # Points of equal index face in the same direction.
    thin = around([(0, 0, 0.5), (4, 0, 0.5)], 360)
    np.testing.assert_allclose(np.linalg.norm(band - thin, axis=1), 0.5)


@pytest.mark.parametrize("direction", [(0, 1, 0), (0, -2, 0), (1, 0, 0), (1, 2, -3)])
def test_upright_turns_the_y_axis(direction: tuple[float, float, float]) -> None:
    turned = upright_to(direction)[:3, :3] @ [0, 1, 0]
    np.testing.assert_allclose(turned, np.array(direction) / np.linalg.norm(direction), atol=1e-12)
