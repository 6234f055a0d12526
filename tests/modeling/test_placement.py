"""Placement: order and attributes of copies, normals under transforms, and refused input."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from oitbench.modeling.mesh import quad, sphere
from oitbench.modeling.placement import (
    frames,
    merge,
    random_directions,
    repeated,
    rotation,
    scaling,
    scatter,
    transform,
    translation,
)
from tests.meshes import corners


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
    assert template.radiance is not None
    np.testing.assert_array_equal(mesh.radiance, np.tile(template.radiance, (2, 1)))
    assert mesh.triangles.max() == 7


def test_scatter_refuses_to_mirror_or_flatten() -> None:
    template = quad((0, 0, 0), (1, 0, 0), (0, 1, 0))
    with pytest.raises(ValueError, match="inside out"):
        transform(template, scaling((-1, 1, 1)))
    with pytest.raises(ValueError, match="flattens"):
        transform(template, scaling((1, 0, 1)))


def test_repeated_copies_are_translated() -> None:
    template = quad((0, 0, 0), (1, 0, 0), (0, 1, 0))
    mesh = repeated(template, [(0, 0, 0), (5, 0, -1)])
    np.testing.assert_array_equal(mesh.positions[:4], template.positions)
    np.testing.assert_array_equal(mesh.positions[4:], np.add(template.positions, (5, 0, -1)))


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


def test_random_directions_are_uniform_over_the_sphere() -> None:
    directions = random_directions(np.random.default_rng(1), 20_000)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1)
    # Each coordinate of a uniform direction is uniform in [−1, 1] (Archimedes).
    np.testing.assert_allclose((directions**2).mean(axis=0), 1 / 3, atol=0.01)
    np.testing.assert_allclose(directions.mean(axis=0), 0, atol=0.02)


def test_copies_and_unions_keep_the_factors_of_vertices() -> None:
    flat = quad((0, 0, 0), (1, 0, 0), (0, 1, 0))
    part = np.array([0, 0.5, 1, 1], np.float32)
    color = np.arange(12, dtype=np.float32).reshape(4, 3) / np.float32(12)
    mesh = replace(flat, coverage=part, albedo=color, transmission=1 - color)
    for found in (merge([mesh, mesh]), repeated(mesh, [(0, 0, 0), (3, 0, 0)])):
        assert found.coverage is not None
        assert found.albedo is not None
        assert found.transmission is not None
        np.testing.assert_array_equal(found.coverage, np.tile(part, 2))
        np.testing.assert_array_equal(found.albedo, np.tile(color, (2, 1)))
        np.testing.assert_array_equal(found.transmission, np.tile(1 - color, (2, 1)))
    with pytest.raises(ValueError, match="only some of the meshes to merge have coverage"):
        merge([mesh, replace(mesh, coverage=None)])
