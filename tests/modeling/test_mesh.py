"""Procedural meshes: volumes, winding, seams, and the errors for what cannot be built."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from oitbench.modeling.detail import divisions
from oitbench.modeling.mesh import box, grid, lathe, quad, sphere
from oitbench.modeling.placement import (
    frames,
    merge,
    rotation,
    scaling,
    scatter,
    transform,
    translation,
)
from oitbench.modeling.profiles import smooth_curve
from oitbench.scene import Mesh

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


def corners(mesh: Mesh) -> np.ndarray:
    return mesh.positions.astype(np.float64)[mesh.triangles]


def signed_volume(mesh: Mesh) -> float:
    a, b, c = corners(mesh).swapaxes(0, 1)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def edge_counts(mesh: Mesh) -> dict[tuple[int, int], int]:
    _, welded = np.unique(mesh.positions, axis=0, return_inverse=True)
    counts: dict[tuple[int, int], int] = {}
    for triangle in welded.reshape(-1)[mesh.triangles]:
        for start, end in zip(triangle, np.roll(triangle, -1), strict=True):
            counts[int(start), int(end)] = counts.get((int(start), int(end)), 0) + 1
    return counts


@pytest.mark.parametrize("name", CLOSED)
def test_closed_meshes_are_watertight_and_turned_outwards(name: str) -> None:
    mesh = CLOSED[name]
    counts = edge_counts(mesh)
    # Each edge is met once from either side: no crack, no doubled or flattened triangle.
    assert all(count == 1 and counts.get(edge[::-1]) == 1 for edge, count in counts.items())
    assert signed_volume(mesh) > 0


@pytest.mark.parametrize("name", CLOSED | OPEN)
def test_normals_are_unit_vectors_on_the_side_of_the_winding(name: str) -> None:
    mesh = (CLOSED | OPEN)[name]
    assert mesh.normals is not None
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1, atol=1e-5)
    a, b, c = corners(mesh).swapaxes(0, 1)
    faces = np.cross(b - a, c - a)
    assert (np.einsum("ij,ikj->ik", faces, mesh.normals[mesh.triangles]) > 0).all()


def test_volumes_approach_those_of_the_solids() -> None:
    assert signed_volume(box((1, 2, 3), (0.5, 1, 2))) == pytest.approx(1.0, rel=1e-6)
    assert signed_volume(sphere((3, 1, 0), 0.7, 96, 48)) == pytest.approx(
        4 / 3 * math.pi * 0.7**3, rel=5e-3
    )


def test_a_reversed_profile_turns_inwards() -> None:
    assert signed_volume(lathe(CUP[::-1], 16)) == pytest.approx(-signed_volume(lathe(CUP, 16)))


def test_grid_spans_its_edges_with_uvs() -> None:
    mesh = grid((1, 2, 3), (0.5, 0, 0), (0, 0, -2), 4, 3)
    assert mesh.uvs is not None
    assert len(mesh.triangles) == 24
    np.testing.assert_allclose(mesh.positions[0], (0.5, 2, 5))
    np.testing.assert_allclose(mesh.positions[-1], (1.5, 2, 1))
    np.testing.assert_allclose(mesh.uvs[[0, 4, -1]], [(0, 0), (1, 0), (1, 1)])


def test_sphere_vertices_lie_on_the_sphere_along_their_normals() -> None:
    mesh = sphere((1, 2, 3), 0.5, 12, 6)
    assert mesh.normals is not None
    np.testing.assert_allclose(mesh.positions, [1, 2, 3] + 0.5 * mesh.normals, atol=1e-6)


def test_scatter_keeps_order_uvs_and_radiance() -> None:
    template = replace(
        quad((0, 0, 0), (1, 0, 0), (0, 1, 0)), radiance=np.full((4, 3), 0.5, dtype=np.float32)
    )
    mesh = scatter(template, frames([(0, 0, 1), (0, 0, 2)], [(2, 0, 0)] * 2, [(0, 3, 0)] * 2))
    np.testing.assert_allclose(mesh.positions[:, 2], [1] * 4 + [2] * 4)
    np.testing.assert_allclose(np.ptp(mesh.positions[:4], axis=0), (4, 6, 0))
    assert mesh.uvs is not None
    assert template.uvs is not None
    np.testing.assert_array_equal(mesh.uvs, np.tile(template.uvs, (2, 1)))
    assert mesh.radiance is not None
    assert mesh.triangles.max() == 7


def test_scatter_refuses_to_mirror_or_flatten() -> None:
    template = quad((0, 0, 0), (1, 0, 0), (0, 1, 0))
    with pytest.raises(ValueError, match="inside out"):
        transform(template, scaling((-1, 1, 1)))
    with pytest.raises(ValueError, match="flattens"):
        transform(template, scaling((1, 0, 1)))


def test_merge_joins_in_order_and_refuses_mixed_attributes() -> None:
    first, second = quad((0, 0, 0), (1, 0, 0), (0, 1, 0)), sphere((0, 0, 0), 1, 4, 2)
    both = merge([first, second])
    np.testing.assert_array_equal(corners(both), np.concatenate([corners(first), corners(second)]))
    with pytest.raises(ValueError, match="uvs"):
        merge([first, replace(second, uvs=None)])


def test_transform_moves_points_and_keeps_normals_perpendicular() -> None:
    slope = quad((0, 0, 0), (1, 1, 0), (0, 0, -1))
    mesh = transform(slope, translation((5, 0, 0)) @ scaling((3, 1, 1)))
    assert mesh.normals is not None
    np.testing.assert_allclose(mesh.positions.mean(axis=0), (5, 0, 0), atol=1e-6)
    edge = mesh.positions[1] - mesh.positions[0]
    assert abs(float(edge @ mesh.normals[0])) < 1e-5


def test_rotation_is_right_handed() -> None:
    np.testing.assert_allclose(
        rotation((0, 0, 2), math.pi / 2)[:3, :3] @ [1, 0, 0], (0, 1, 0), atol=1e-12
    )


@pytest.mark.parametrize(
    ("profile", "slices"),
    [([(1, 0)], 8), ([(1, 0), (1, 1)], 2), ([(-1, 0), (1, 1)], 8), ([(1, 0), (1, 0)], 8)],
)
def test_lathe_refuses_what_is_no_surface(profile: list[tuple[float, float]], slices: int) -> None:
    with pytest.raises(ValueError, match="lathe"):
        lathe(profile, slices)


def test_smooth_curve_keeps_its_ends_and_spaces_evenly() -> None:
    curve = smooth_curve([(0, 0), (1, 0), (1, 1)], 40)
    np.testing.assert_allclose(curve[[0, -1]], [(0, 0), (1, 1)])
    steps = np.linalg.norm(np.diff(curve, axis=0), axis=1)
    np.testing.assert_allclose(steps, steps.mean(), rtol=1e-2)
    # The corner itself is cut off.
    assert np.linalg.norm(curve - [1, 0], axis=1).min() > 0.1


def test_divisions_make_triangles_grow_with_detail() -> None:
    assert divisions(16, 1.0) == 16
    assert divisions(16, 4.0) == 32
    assert divisions(16, 0.0, least=3) == 3
