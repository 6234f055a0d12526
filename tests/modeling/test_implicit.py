"""Surfaces of signed distances: balls, unions without a crease, and carved bodies."""

from __future__ import annotations

import math

import numpy as np
import pytest

from oitbench.modeling.implicit import capsule, carved, ellipsoid, gradients, joined, surface
from oitbench.scene import Floats
from tests.meshes import agreement, boundary, signed_volume


def ball(points: Floats) -> Floats:
    return ellipsoid(points, (0.1, 0.0, 0.0), (0.5, 0.5, 0.5))


def test_distances_to_balls_and_capsules_are_exact() -> None:
    points = np.array([(0.1, 0.9, 0.0), (0.3, 0.0, 0.0)])
    np.testing.assert_allclose(ball(points), [0.4, -0.3])
    rod = capsule(np.array([(1.0, 0.5, 0.0), (0.0, 2.0, 0.0)]), (0, 0, 0), (0, 1, 0), 0.2, 0.4)
    np.testing.assert_allclose(rod, [0.7, 0.6])


def test_a_union_fills_the_crease_and_nothing_else() -> None:
    first, second = np.array([0.0, 1.0, 0.05]), np.array([0.0, -1.0, 0.0])
    np.testing.assert_allclose(joined(first, second, 0.1), [-0.025, -1.0, -0.00625])


def test_carving_takes_a_body_away() -> None:
    body, tool = np.array([-1.0, -1.0]), np.array([-0.5, 2.0])
    np.testing.assert_allclose(carved(body, tool, 0.1), [0.5, -1.0])


def test_gradients_point_away() -> None:
    np.testing.assert_allclose(
        gradients(ball, np.array([(0.1, 0.0, -2.0)])), [(0, 0, -1)], atol=1e-9
    )


@pytest.mark.parametrize("cell", [0.05, 0.023])
def test_a_surface_is_closed_smooth_and_of_the_right_size(cell: float) -> None:
    mesh = surface(ball, (-0.5, -0.6, -0.6), (0.7, 0.6, 0.6), cell)
    assert not len(boundary(mesh))
    assert signed_volume(mesh) == pytest.approx(4 / 3 * math.pi * 0.125, rel=0.02)
    assert (agreement(mesh) > 0).all()
    distance = np.linalg.norm(mesh.positions - [0.1, 0, 0], axis=1)
    np.testing.assert_allclose(distance, 0.5, atol=0.1 * cell)
