"""Basic meshes: volumes, winding, seams and refused input."""

from __future__ import annotations

import math

import numpy as np
import pytest

from oitbench.modeling.mesh import box, grid, lathe, slab, sphere
from oitbench.modeling.placement import rotation, scaling, transform
from tests.meshes import agreement, boundary, bounds, has_unit_normals, signed_volume

CUP = [(0.0, 0.0), (0.5, 0.1), (0.8, 0.6), (0.6, 1.0), (0.0, 1.2)]
CLOSED = {
    "box": box((1, 2, 3), (0.5, 1, 2), cells=3),
    "sphere": sphere((0, 1, 0), 0.7, 24, 12),
    "lathe": lathe(CUP, 16),
    "turned": transform(lathe(CUP, 16), rotation((1, 1, 0), 0.7) @ scaling((1, 2, 3))),
}
OPEN = {
    "grid": grid((0, 0, 0), (1, 0, 0), (0, 2, 0), 3, 2),
    "tube": lathe([(1, 0), (0.5, 1)], 8),
    "lining": lathe([(0.5, 1), (1, 0)], 8),
}


@pytest.mark.parametrize("name", CLOSED)
def test_closed_meshes_are_watertight_with_outward_normals(name: str) -> None:
    assert not len(boundary(CLOSED[name]))
    assert signed_volume(CLOSED[name]) > 0


@pytest.mark.parametrize("name", CLOSED | OPEN)
def test_normals_are_unit_vectors_that_agree_with_the_winding(name: str) -> None:
    mesh = (CLOSED | OPEN)[name]
    assert has_unit_normals(mesh)
    assert (agreement(mesh) > 0).all()


def test_a_missing_triangle_shows_in_the_boundary() -> None:
    assert len(boundary(OPEN["grid"])) == 2 * (3 + 2)


def test_volumes_approach_those_of_the_solids() -> None:
    assert signed_volume(box((1, 2, 3), (0.5, 1, 2))) == pytest.approx(1.0, rel=1e-6)
    assert signed_volume(sphere((3, 1, 0), 0.7, 96, 48)) == pytest.approx(
        4 / 3 * math.pi * 0.7**3, rel=5e-3
    )


def test_a_slab_lies_between_its_corners() -> None:
    low, high = bounds(slab((-1, 0, 2), (1, 0.5, 5)))
    np.testing.assert_allclose(low, (-1, 0, 2))
    np.testing.assert_allclose(high, (1, 0.5, 5))


def test_a_reversed_profile_has_inward_normals() -> None:
    assert signed_volume(lathe(CUP[::-1], 16)) == pytest.approx(-signed_volume(lathe(CUP, 16)))


def test_a_grid_spans_its_edges_with_uvs() -> None:
    mesh = grid((1, 2, 3), (0.5, 0, 0), (0, 0, -2), 4, 3)
    assert mesh.uvs is not None
    assert len(mesh.triangles) == 24
    np.testing.assert_allclose(mesh.positions[0], (0.5, 2, 5))
    np.testing.assert_allclose(mesh.positions[-1], (1.5, 2, 1))
    np.testing.assert_allclose(mesh.uvs[[0, 4, -1]], [(0, 0), (1, 0), (1, 1)])


def test_the_vertices_of_a_sphere_lie_on_it_along_their_normals() -> None:
    mesh = sphere((1, 2, 3), 0.5, 12, 6)
    assert mesh.normals is not None
    np.testing.assert_allclose(mesh.positions, [1, 2, 3] + 0.5 * mesh.normals, atol=1e-6)


@pytest.mark.parametrize(
    ("profile", "slices"),
    [([(1, 0)], 8), ([(1, 0), (1, 1)], 2), ([(-1, 0), (1, 1)], 8), ([(1, 0), (1, 0)], 8)],
)
def test_profiles_that_are_no_surface_are_refused(
    profile: list[tuple[float, float]], slices: int
) -> None:
    with pytest.raises(ValueError, match="lathe"):
        lathe(profile, slices)
