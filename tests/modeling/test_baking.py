"""Baked lighting against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.modeling.baking import Rig, cone, diffuse, sphere_chord, tint, with_radiance
from oitbench.modeling.mesh import lathe

UP = (0.0, 1.0, 0.0)
RIG = Rig(toward_key=(0, 2, 0), key=(1, 0.5, 0.25), sky=(0.2, 0.2, 0.2), ground=(0.1, 0.0, 0.0))


def test_diffuse_is_key_plus_a_blend_of_sky_and_ground() -> None:
    shade = diffuse([UP, (1, 0, 0), (0, -1, 0)], RIG)
    np.testing.assert_allclose(shade, [(1.2, 0.7, 0.45), (0.15, 0.1, 0.1), (0.1, 0, 0)])


def test_diffuse_scales_key_and_fill_apart() -> None:
    np.testing.assert_allclose(diffuse([UP], RIG, lit=0.5, openness=0.0), [(0.5, 0.25, 0.125)])
    np.testing.assert_allclose(diffuse([UP], RIG, lit=0.0, openness=0.5), [(0.1, 0.1, 0.1)])


def test_cone_stays_within_its_spread_round_its_axis() -> None:
    axis = np.array([1.0, 2.0, -0.5]) / np.linalg.norm([1.0, 2.0, -0.5])
    directions = cone(axis, 0.3, 64)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1)
    angles = np.arccos(directions @ axis)
    assert 0.25 < angles.max() < 0.3
    mean = directions.mean(axis=0)
    np.testing.assert_allclose(mean / np.linalg.norm(mean), axis, atol=0.02)


def test_sphere_chord_from_outside_inside_and_beyond() -> None:
    points = [(0, -5, 0), (0, 0, 0), (0, 5, 0), (1.2, -5, 0), (3, -5, 0)]
    chord = sphere_chord(points, UP, (0, 0, 0), 2.0)
    np.testing.assert_allclose(chord, [4, 2, 0, 3.2, 0])


def test_tint_runs_through_its_stops() -> None:
    ramp = tint([0, 0.25, 0.5, 1], [(0, 0, 0), (1, 0, 0), (1, 1, 1)])
    np.testing.assert_allclose(ramp, [(0, 0, 0), (0.5, 0, 0), (1, 0, 0), (1, 1, 1)])


def test_with_radiance_spreads_one_color_and_needs_matching_vertices() -> None:
    mesh = with_radiance(lathe([(1, 0), (1, 1)], 4), (0.1, 0.2, 0.3))
    assert mesh.radiance is not None
    assert mesh.radiance.shape == mesh.positions.shape
    with pytest.raises(ValueError, match="broadcast"):
        with_radiance(mesh, np.ones((3, 3)))
