"""Path-traced media against closed forms."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from oitbench.modeling.mesh import quad
from oitbench.path_traced.trace.render import render
from oitbench.path_traced.trace.sections import Estimate
from oitbench.scene import (
    RGB,
    Camera,
    DirectionalLight,
    EnvironmentLight,
    Material,
    Medium,
    Object,
    Scene,
    sample_density,
)
from tests.path_traced.agreement import assert_mean, needs_mitsuba

pytestmark = needs_mitsuba

WHITE: RGB = (1.0, 1.0, 1.0)
BOX: tuple[RGB, RGB] = ((-8.0, -8.0, -1.0), (8.0, 8.0, 1.0))
OUTSIDE = Camera((0.0, 0.0, 6.0), fov_y=0.02)
WALL = Object("wall", quad((0, 0, -3), (40, 0, 0), (0, 40, 0)), Material(emission=(1.0, 2.0, 3.0)))
ASIDE = Object("aside", quad((0, 0, 900), (0.1, 0, 0), (0, 0.1, 0)), Material())
SMOKE = Medium(0.8, *BOX, albedo=(0.0, 0.0, 0.0))


def _seen(medium: Medium, camera: Camera = OUTSIDE) -> Estimate:
    return render(Scene("fog", camera, (WALL,), medium=medium), (64, 64))


def test_black_fog_dims_a_wall_seen_from_outside_and_inside() -> None:
    light = np.array([1.0, 2.0, 3.0])
    assert_mean(_seen(SMOKE), light * math.exp(-0.8 * 2))
    # Rays start on the near plane, 0.1 m in front of the camera.
    inside = Camera((0.0, 0.0, 0.6), fov_y=0.02)
    assert_mean(_seen(SMOKE, inside), light * math.exp(-0.8 * 1.5))


def test_the_density_is_linear_between_the_centers_of_cells() -> None:
    density = sample_density(lambda p: 0.5 * (p[..., 2] + 1), *BOX, (2, 2, 4))
    assert density.shape == (4, 2, 2)
    medium = dataclasses.replace(SMOKE, density=density)
    assert_mean(_seen(medium), np.array([1.0, 2.0, 3.0]) * math.exp(-0.8))
    # The denser half is the nearer one.
    z = np.linspace(-1, 0, 401)
    farther = np.interp(z, [-0.75, -0.25, 0.25, 0.75], density[:, 0, 0]).mean()
    assert farther < 0.3
    estimate = _seen(medium, Camera((0.0, 0.0, 0.1), fov_y=0.02))
    assert_mean(estimate, np.array([1.0, 2.0, 3.0]) * math.exp(-0.8 * farther))


@pytest.mark.parametrize("anisotropy", [0.0, 0.6])
@pytest.mark.parametrize("varying", [False, True])
def test_thin_fog_scatters_once(anisotropy: float, varying: bool) -> None:
    extinction, depth = 0.01, 2.0
    sun = DirectionalLight((0.3, -0.5, -1.0), (5.0, 6.0, 7.0))
    density = np.full((2, 2, 2), 0.5, dtype=np.float32) if varying else None
    factor = 0.5 if varying else 1.0
    medium = Medium(extinction, *BOX, (0.9, 0.8, 0.7), anisotropy, density=density)
    camera = Camera((0.0, 0.3, 6.0), (0.0, 0.3, 0.0), fov_y=0.002)
    scene = Scene("fog", camera, (ASIDE,), lights=(sun,), medium=medium)
    toward = -np.asarray(sun.direction) / np.linalg.norm(sun.direction)
    cosine = -toward[2]
    phase = (1 - anisotropy**2) / (4 * math.pi)
    phase /= (1 + anisotropy**2 - 2 * anisotropy * cosine) ** 1.5
    # Light that scatters at the depth x travels x/cos in the fog before and x after it.
    rate = factor * extinction
    slant = rate * (1 + 1 / toward[2])
    once = rate * phase * (1 - math.exp(-slant * depth)) / slant
    expected = np.multiply(medium.albedo, sun.irradiance) * once
    estimate = render(scene, (128, 128), spp=4)
    mean = estimate.mean.mean(axis=(0, 1))
    # Light that is scattered twice adds about as many percent as the fog absorbs.
    np.testing.assert_allclose(mean, expected, rtol=0.06)


@pytest.mark.parametrize("varying", [False, True])
def test_white_fog_in_a_white_environment_is_invisible(varying: bool) -> None:
    density = np.array([0.2, 1.0], dtype=np.float32).repeat(4).reshape(2, 2, 2)
    medium = Medium(0.7, *BOX, anisotropy=0.4, density=density if varying else None)
    camera = Camera((0.0, 0.5, 4.0), (0.0, -1.0, 0.0), fov_y=0.4)
    scene = Scene("furnace", camera, (ASIDE,), lights=(EnvironmentLight(WHITE),), medium=medium)
    estimate = render(scene, (8, 8))
    np.testing.assert_allclose(estimate.mean, 1, atol=1e-3)


def test_fog_dims_the_light_that_a_surface_receives() -> None:
    sun = DirectionalLight((0.0, -1.0, 0.0), (math.pi, math.pi, math.pi))
    medium = Medium(0.5, (-8.0, 1.0, -8.0), (8.0, 3.0, 8.0), albedo=(0.0, 0.0, 0.0))
    floor = Object("floor", quad((0, 0, 0), (9, 0, 0), (0, 0, -9)), Material(albedo=WHITE))
    camera = Camera((0.0, 0.5, 4.0), (0.0, 0.0, 0.0), fov_y=0.05)
    scene = Scene("shade", camera, (floor,), lights=(sun,), medium=medium)
    image = render(scene, (4, 4)).mean
    np.testing.assert_allclose(image, math.exp(-0.5 * 2), rtol=1e-4)
    dense = dataclasses.replace(medium, density=np.full((2, 2, 2), 0.5, dtype=np.float32))
    assert_mean(
        render(dataclasses.replace(scene, medium=dense), (32, 32)), math.exp(-0.5) * np.ones(3)
    )
