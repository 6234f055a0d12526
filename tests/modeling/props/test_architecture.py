"""Architecture: openings, reveals and normals."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.modeling.props.architecture import arcade, arch, column, globe, lamp_post, window_wall
from oitbench.scene import Mesh
from tests.meshes import agreement, bounds, has_unit_normals, hits


@pytest.mark.parametrize(
    "part",
    [
        column(3, 0.3, 1),
        arch(3, 2, 2, 0.5, 12),
        window_wall(3, 6, 0.5, 1.2, 1, 4, 12),
        lamp_post(4, 0.9, 1),
        globe((0, 4, 0), 0.13, 1),
    ],
    ids=["column", "arch", "window wall", "lamp post", "globe"],
)
def test_normals_fit_the_triangles(part: Mesh) -> None:
    assert has_unit_normals(part)
    # Where a profile turns sharply, its smooth normals round the edge off.
    assert (agreement(part).sum(axis=1) > 0).mean() > 0.97


def test_a_window_wall_has_one_opening() -> None:
    wall = window_wall(3, 6, 0.5, 1.2, 1, 4, 24)
    for x, y, expected in ((0.1, 3, 0), (0.1, 4.5, 0), (0.1, 0.5, 2), (1.2, 3, 2), (0.1, 5, 2)):
        assert len(hits(wall, (x, y + 0.017, 5), (0, 0, -1))) == expected
    low, high = bounds(wall)
    np.testing.assert_allclose(low, [-1.5, 0, -0.25], atol=1e-12)
    assert high.tolist() == [1.5, 6, 0.25]


def test_an_arch_is_open_below() -> None:
    bay = arch(3, 2, 2, 0.5, 24)
    for x, y, expected in ((0.1, 0.9, 0), (0.9, 0.2, 0), (1.2, 0.1, 2), (0.1, 1.5, 2)):
        assert len(hits(bay, (x, y + 0.013, 5), (0, 0, -1))) == expected


def test_reveals_face_into_their_openings() -> None:
    for bay, middle in ((arch(3, 2, 2, 0.5, 24), 0), (window_wall(3, 6, 0.5, 1.2, 1, 4, 24), 3)):
        assert bay.normals is not None
        reveal = bay.normals[:, 2] == 0
        inward = np.array([0, middle, 0]) - bay.positions[reveal]
        # The springing line of an arch is in the plane of its middle and faces down.
        assert (np.einsum("ij,ij->i", inward, bay.normals[reveal]) > -1e-6).all()
        assert reveal.sum() >= 4 * 24


def test_an_arcade_is_open_between_its_columns() -> None:
    wall, columns = arcade(3, 2.6, 2.2, 1.5, 5.0, 1.0)
    for x, expected in ((-2.6, 0), (0, 0), (2.6, 0), (1.3, 2)):
        assert len(hits(columns, (x + 0.013, 1.0, 5), (0, 0, -1))) == expected
        assert len(hits(wall, (x + 0.013, 2.5, 5), (0, 0, -1))) == expected
    assert bounds(wall)[1].tolist() == pytest.approx([3.9, 5.0, 0.21])
    assert bounds(columns)[0][1] == 0
