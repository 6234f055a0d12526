"""Single scattering in matched pictures against closed forms."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.measure.oracle import composite
from oitbench.modeling.mesh import quad
from oitbench.path_traced.matched.render import matched
from oitbench.scene import (
    Camera,
    DirectionalLight,
    EnvironmentLight,
    Floats,
    Light,
    Material,
    Medium,
    Object,
    Scene,
    SpotLight,
    sample_density,
)
from tests.helpers import BACKGROUND, opened
from tests.methods.foggy import CAMERA, FAR_CAMERA, FLOAT, HIGH, LAMP, LOW, SIZE, SUN, wall
from tests.methods.foggy import FOG as HAZE
from tests.models import fog as model
from tests.path_traced.agreement import needs_mitsuba
from tests.path_traced.matched.scenes import ABOVE, PAPER, floor, image

pytestmark = needs_mitsuba

LEVEL = Camera((0.0, 1.0, 20.0), (0.0, 1.0, 0.0), fov_y=1e-5)
"""Looks at fog ten meters deep, one meter below the fog's top."""
FOG = Medium(0.2, (-90.0, -2.0, -10.0), (90.0, 2.0, 0.0), albedo=(0.9, 0.6, 0.3))
DOWN = DirectionalLight((0.0, -1.0, 0.0), (2.0, 3.0, 4.0))
SKY = EnvironmentLight((1.0, 2.0, 3.0))
ASIDE = floor(Material(), 0.1, -40.0)
PASSED = math.exp(-0.2 * 10)


def _fog(medium: Medium, *lights: Light) -> Scene:
    return Scene("fog", LEVEL, (ASIDE,), lights=lights, medium=medium)


def _same(found: Floats, expected: Floats, rtol: float = 1e-3) -> None:
    np.testing.assert_allclose(found, np.tile(expected, (30, 1)), rtol=rtol)


def test_ambient_light_scatters_out_of_fog() -> None:
    sky = np.array([1.0, 2.0, 3.0])
    _same(image(_fog(FOG, SKY)), PASSED * sky + (1 - PASSED) * np.asarray(FOG.albedo) * sky)


def test_fog_dims_the_beams_that_it_scatters_once() -> None:
    arriving = np.asarray(DOWN.irradiance) * math.exp(-0.2 * 1)
    expected = np.asarray(FOG.albedo) * arriving / (4 * math.pi) * (1 - PASSED)
    _same(image(_fog(FOG, DOWN)), expected)


def test_a_varying_density_is_marched() -> None:
    density = np.full((4, 4, 4), 0.5, dtype=np.float32)
    half = dataclasses.replace(FOG, extinction=0.4, density=density)
    expected = image(_fog(FOG, DOWN, SKY))
    np.testing.assert_allclose(image(_fog(half, DOWN, SKY)), expected, rtol=1e-3)


def test_light_scatters_by_the_phase_function() -> None:
    g = 0.5
    forward = dataclasses.replace(FOG, anisotropy=g)
    factor = (1 - g * g) / (1 + g * g) ** 1.5  # at right angles, relative to isotropic fog
    found = image(_fog(forward, DOWN))
    np.testing.assert_allclose(found, factor * image(_fog(FOG, DOWN)), rtol=2e-3)


def test_fog_dims_beams_on_their_way_to_surfaces() -> None:
    matte = floor(Material(albedo=PAPER))
    layer = Medium(0.3, (-90.0, 5.0, -90.0), (90.0, 7.0, 90.0))
    scene = Scene("under", ABOVE, (matte,), lights=(DOWN,), medium=layer)
    bare = image(dataclasses.replace(scene, medium=None))
    np.testing.assert_allclose(image(scene), bare * math.exp(-0.3 * 2), rtol=1e-4)


def test_a_lid_above_fog_leaves_it_dark() -> None:
    lid = floor(Material(), 200.0, 9.0)
    scene = dataclasses.replace(_fog(FOG, DOWN), objects=(ASIDE, lid))
    assert (image(scene) == 0).all()
    assert (image(scene, scene.effects & ~Effect.SHADOWS) > 0).all()


def test_fog_that_is_left_out_is_not_there() -> None:
    scene = _fog(FOG, DOWN, SKY)
    found = image(scene, scene.effects & ~Effect.VOLUME)
    np.testing.assert_array_equal(found, image(dataclasses.replace(scene, medium=None)))


def test_a_medium_may_have_its_own_ambient_light() -> None:
    brown = dataclasses.replace(FOG, ambient=(0.3, 0.2, 0.1))
    expected = PASSED * np.array([1.0, 2.0, 3.0])
    expected += (1 - PASSED) * np.multiply(FOG.albedo, (0.3, 0.2, 0.1))
    _same(image(_fog(brown, SKY)), expected)


@pytest.mark.parametrize("light", [SUN, LAMP], ids=["sun", "lamp"])
def test_slices_that_are_composited_in_order_give_the_same_fog(
    light: DirectionalLight | SpotLight,
) -> None:
    """The slices are those of OpenGL's march, see `test_the_march_follows_the_model`."""
    density = sample_density(
        lambda p: 0.5 + 0.1 * p[..., 0] - 0.15 * p[..., 2], LOW, HIGH, (5, 4, 3)
    )
    medium = dataclasses.replace(HAZE, density=density)
    scene = Scene("haze", CAMERA, (wall(),), lights=(light,), medium=medium)
    slices = model.march(CAMERA, medium, SIZE, 256, 3.0, (light,)).lists()
    expected = composite(slices, BACKGROUND)
    found = matched(scene, SIZE, 1, Effect.VOLUME | Effect.COVERAGE, samples=8)
    np.testing.assert_allclose(found, expected, rtol=0.03)
    np.testing.assert_allclose(found.mean(axis=(0, 1)), expected.mean(axis=(0, 1)), rtol=2e-3)


def test_fog_before_a_sheet_dims_it_but_not_in_one_unordered_pass(device: Device) -> None:
    """The right values by Beer and Lambert, beside those of `phenomenological`."""
    absorbing = Medium(0.5, (-9, -9, -4), (9, 9, -2), albedo=(0.0, 0.0, 0.0))
    white = Object("wall", quad((0, 0, -7), (9, 0, 0), (0, 9, 0)), Material(emission=(1, 1, 1)))
    for z, before, right, one_pass in (
        (1.0, 0.0, 0.684, 0.915),
        (3.0, 1.0, 0.487, 0.467),
        (5.0, 2.0, 0.368, 0.467),
    ):
        red = Material(coverage=0.5, emission=(1.0, 0.0, 0.0))
        sheet = Object("sheet", quad((0, 0, -z), (8, 0, 0), (0, 8, 0)), red)
        scene = Scene("sheet", FAR_CAMERA, (white, sheet), medium=absorbing)
        passed = 0.5 * math.exp(-0.5 * 2)
        expected = np.array([0.5 * math.exp(-0.5 * before) + passed, passed, passed])
        _same(image(scene), expected)
        assert expected[0] == pytest.approx(right, abs=1e-3)
        with opened(device, scene, FLOAT, SIZE) as frame:
            frame.render()
            assert frame.image()[0, 0, 0] == pytest.approx(one_pass, abs=2e-3)
