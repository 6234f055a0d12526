"""Tubes: round, without twist, with outward normals."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.modeling.tubes import straight, tubes
from tests.meshes import agreement, has_unit_normals


def test_a_straight_tube_is_a_cylinder() -> None:
    mesh = tubes(straight([[0, 0, 0]], [[0, 2, 0]], 3), 0.5, 16)
    assert len(mesh.triangles) == 2 * 16 * 2
    np.testing.assert_allclose(np.hypot(mesh.positions[:, 0], mesh.positions[:, 2]), 0.5)
    assert has_unit_normals(mesh)
    assert (agreement(mesh) > 0).all()


def test_radii_change_along_a_tube_and_between_tubes() -> None:
    curves = straight([[0, 0, 0], [3, 0, 0]], [[0, 1, 0], [3, 1, 0]])
    mesh = tubes(curves, np.array([[0.1, 0.2], [0.3, 0.4]]), 8)
    places = mesh.positions.reshape(2, 2, 9, 3) - curves[:, :, None]
    reach = np.linalg.norm(places, axis=3)
    np.testing.assert_allclose(
        reach, np.broadcast_to([[[0.1], [0.2]], [[0.3], [0.4]]], reach.shape)
    )


@pytest.mark.parametrize("direction", [1, -1])
def test_a_tube_around_corners_keeps_its_radius_and_does_not_twist(direction: int) -> None:
    corners = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (1, 1, 1)], dtype=np.float64)
    curve = corners[::direction][None]
    mesh = tubes(curve, 0.1, 12)
    rings = mesh.positions.reshape(4, 13, 3)
    steps = np.diff(curve[0], axis=0)
    for ring, following, step in zip(rings[:-1], rings[1:], steps, strict=True):
        # A line of a tube that does not twist runs along it.
        lines = following - ring
        lines /= np.linalg.norm(lines, axis=1, keepdims=True)
        assert (lines @ (step / np.linalg.norm(step)) > 0.97).all()
    assert (agreement(mesh) > -1e-12).all()
