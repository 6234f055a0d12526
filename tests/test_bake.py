"""Baked lighting against closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from oitbench.bake import (
    Rig,
    box_blocks,
    cone,
    diffuse,
    gloss,
    revolved_chord,
    sphere_chord,
    tint,
    with_radiance,
)
from oitbench.geometry import lathe, sphere
from oitbench.scene import Camera

UP = (0.0, 1.0, 0.0)
RIG = Rig(toward_key=(0, 2, 0), key=(1, 0.5, 0.25), sky=(0.2, 0.2, 0.2), ground=(0.1, 0.0, 0.0))


def test_diffuse_is_key_plus_a_blend_of_sky_and_ground() -> None:
    shade = diffuse([UP, (1, 0, 0), (0, -1, 0)], RIG)
    np.testing.assert_allclose(shade, [(1.2, 0.7, 0.45), (0.15, 0.1, 0.1), (0.1, 0, 0)])


def test_diffuse_scales_key_and_fill_apart() -> None:
    np.testing.assert_allclose(diffuse([UP], RIG, lit=0.5, openness=0.0), [(0.5, 0.25, 0.125)])
    np.testing.assert_allclose(diffuse([UP], RIG, lit=0.0, openness=0.5), [(0.1, 0.1, 0.1)])


def test_gloss_is_the_same_on_both_sides_and_brightest_at_the_mirror_direction() -> None:
    camera = Camera(position=(0, 5, 5), target=(0, 0, 0))
    ball = sphere((0, 0, 0), 1, 48, 24)
    bare = Rig(toward_key=(0, 1, 1), key=(1, 1, 1), sky=(0, 0, 0), ground=(0, 0, 0))
    shade = gloss(ball, camera, bare, exponent=50, rim=0.5)
    seen = ball.positions @ [0, 1, 1] > 1
    peak = ball.positions[seen][shade[seen, 0].argmax()]
    np.testing.assert_allclose(peak, np.array([0, 1, 1]) / np.sqrt(2), atol=0.1)
    assert ball.normals is not None
    turned = replace(ball, normals=-ball.normals)
    np.testing.assert_allclose(
        gloss(turned, camera, RIG, 20, 0.4), gloss(ball, camera, RIG, 20, 0.4), atol=1e-12
    )


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


def test_box_blocks_only_rays_that_pass_its_inside() -> None:
    low, high = (-1.0, 1.0, -1.0), (1.0, 2.0, 1.0)
    points = [(0, 0, 0), (3, 0, 0), (0, 3, 0), (0, 2, 0), (0, 1.5, 0)]
    np.testing.assert_array_equal(
        box_blocks(points, UP, low, high), [True, False, False, False, True]
    )
    slanted = np.array([1.0, 1.0, 0.0]) / np.sqrt(2)
    np.testing.assert_array_equal(
        box_blocks([(-1.5, 0, 0), (1.5, 0, 0)], slanted, low, high), [True, False]
    )


def test_revolved_chord_of_a_ball_is_the_balls() -> None:
    polar = np.linspace(0, np.pi, 200)
    profile = np.stack([np.sin(polar), 1 - np.cos(polar)], axis=1)
    direction = np.array([0.4, 1.0, 0.2]) / np.linalg.norm([0.4, 1.0, 0.2])
    points = np.random.default_rng(2).uniform(-1, 1, (50, 3)) * [1.5, 0, 1.5]
    expected = sphere_chord(points, direction, (0.2, 1.0, 0.0), 1.0)
    found = revolved_chord(points, direction, profile, (0.2, 0, 0), steps=400)
    np.testing.assert_allclose(found, expected, atol=0.02)


def test_tint_runs_through_its_stops() -> None:
    ramp = tint([0, 0.25, 0.5, 1], [(0, 0, 0), (1, 0, 0), (1, 1, 1)])
    np.testing.assert_allclose(ramp, [(0, 0, 0), (0.5, 0, 0), (1, 0, 0), (1, 1, 1)])


def test_with_radiance_spreads_one_color_and_needs_matching_vertices() -> None:
    mesh = with_radiance(lathe([(1, 0), (1, 1)], 4), (0.1, 0.2, 0.3))
    assert mesh.radiance is not None
    assert mesh.radiance.shape == mesh.positions.shape
    with pytest.raises(ValueError, match="broadcast"):
        with_radiance(mesh, np.ones((3, 3)))
