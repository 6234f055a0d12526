"""The Utah teapot (Newell 1975): its patches, size and volume."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.modeling.props.teapot import patches, teapot
from tests.meshes import agreement, boundary, bounds, signed_volume


def test_the_teapot_has_32_patches_that_share_control_points() -> None:
    control = patches()
    assert control.shape == (32, 4, 4, 3)
    # 17 rings of 12 points and 3 points on the axis; 7 rings of 6 points for each of two tubes. One
    # point, at the foot of the handle, belongs to the body too.
    distinct = np.unique(control.reshape(-1, 3).round(6), axis=0)
    assert len(distinct) == 17 * 12 + 3 + 2 * 7 * 6 - 1


def test_the_teapot_has_its_size_and_its_spout_along_x() -> None:
    mesh = teapot(3.15, 1.0)
    low, high = bounds(mesh)
    np.testing.assert_allclose([low[1], high[1]], [0, 3.15], atol=1e-6)
    np.testing.assert_allclose([low[0], low[2], high[2]], [-3, -2, 2], atol=1e-6)
    assert high[0] == pytest.approx(3.434, abs=0.002)
    small = teapot(0.315, 1.0)
    np.testing.assert_allclose(small.positions * 10, mesh.positions, atol=1e-5)


def test_the_teapot_keeps_its_volume() -> None:
    # In cubic units, with lid, handle and spout. A changed control point changes the volume.
    assert signed_volume(teapot(3.15, 1.0)) == pytest.approx(25.6806, rel=1e-4)


@pytest.mark.parametrize("detail", [1.0, 4.0])
def test_the_teapot_has_outward_normals(detail: float) -> None:
    mesh = teapot(1.0, detail)
    assert (agreement(mesh) > 0).all()
    assert signed_volume(mesh) > 0


def test_the_teapot_is_closed_except_at_its_rim_lid_and_tubes() -> None:
    places = np.unique(boundary(teapot(3.15, 1.0)), axis=0)
    radii = np.hypot(places[:, 0], places[:, 2])
    rings = (np.abs(radii - 1.3) < 0.01) | (np.abs(radii - 1.4) < 0.01)
    assert np.abs(places[rings, 1] - 2.4).max() < 1e-5
    # The rest are the ends of the handle, and the mouth and the start of the spout.
    assert set(np.sign(places[~rings, 0])) == {-1.0, 1.0}
    assert (radii[~rings] > 1.45).all()


def test_detail_adds_triangles() -> None:
    assert len(teapot(1.0, 1.0).triangles) == 4032
    assert len(teapot(1.0, 0.25).triangles) < 4032 / 3
