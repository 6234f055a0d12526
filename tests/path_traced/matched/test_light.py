"""Matched pictures of beams and of the environment against closed forms and quadrature."""

from __future__ import annotations

import math

import numpy as np
import pytest

from oitbench.modeling.mesh import quad
from oitbench.path_traced.export.view import View
from oitbench.path_traced.trace.render import render
from oitbench.scene import (
    Camera,
    DirectionalLight,
    EnvironmentLight,
    Material,
    Object,
    Scene,
    SpotLight,
    unit,
)
from oitbench.scene.texturing import constant
from tests.models import environment as model
from tests.path_traced.agreement import needs_mitsuba
from tests.path_traced.matched.scenes import ABOVE, PAPER, SIZE, SUN, floor, image

pytestmark = needs_mitsuba

MATTE = floor(Material(albedo=PAPER))
PANES = (
    floor(Material(transmission=(0.9, 0.5, 0.2), index=1.5), 50.0, 5.0),
    floor(Material(0.7, transmission=(0.3, 0.8, 0.9), albedo=(0.1, 0.2, 0.3)), 50.0, 6.0),
)
SPOT = SpotLight((0.2, 2.0, 0.1), (0.0, 0.0, 0.3), (5.0, 6.0, 7.0), math.radians(70))


@pytest.mark.parametrize(
    "scene",
    [
        Scene("plane", ABOVE, (MATTE,), lights=(SUN, SPOT)),
        Scene("panes", ABOVE, (MATTE, PANES[1]), lights=(SUN,)),
        Scene("films", ABOVE, (MATTE, floor(Material(0.3, emission=(1, 2, 3)), 9.0, 1.0))),
        Scene("dust", ABOVE, (floor(Material(0.4, albedo=PAPER, isotropic=True)),), lights=(SUN,)),
        Scene("empty", ABOVE, (floor(Material(0.5), 0.1),), background=(0.1, 0.2, 0.3)),
    ],
    ids=lambda scene: scene.name,
)
def test_without_random_events_the_path_tracer_gives_the_same(scene: Scene) -> None:
    expected = render(scene, SIZE, ssaa=1)
    assert expected.variance.max() == 0
    np.testing.assert_allclose(image(scene), expected.mean.reshape(-1, 3), rtol=1e-5, atol=1e-7)


def test_a_shadow_is_colored_by_each_pane() -> None:
    cosine = -unit(np.array(SUN.direction))[1]
    clear = np.multiply(PAPER, SUN.irradiance) / math.pi * cosine
    first, second = (pane.material for pane in PANES)
    fresnel = 0.04 + 0.96 * (1 - cosine) ** 5
    passed = np.asarray(first.transmission) * (1 - fresnel)
    passed *= 0.3 + 0.7 * np.multiply(
        constant(second.transmission), np.subtract(1, constant(second.albedo))
    )
    scene = Scene("panes", ABOVE, (MATTE, *PANES), lights=(SUN,))
    np.testing.assert_allclose(image(scene), np.tile(clear * passed, (30, 1)), rtol=1e-4)


def test_a_gloss_has_the_highlight_of_the_path_tracer() -> None:
    light = DirectionalLight((-0.1, -1.0, -0.9), (1.0, 2.0, 3.0))
    gloss = floor(Material(specular=0.3, roughness=0.35))
    scene = Scene("gloss", ABOVE, (gloss,), lights=(light,))
    expected = render(scene, SIZE, ssaa=1).mean.reshape(-1, 3)
    np.testing.assert_allclose(image(scene), expected, rtol=1e-5)


def test_equal_pictures_are_equal_bit_for_bit() -> None:
    objects = (floor(Material(albedo=PAPER, specular=0.2, roughness=0.5)), *PANES)
    scene = Scene("twice", ABOVE, objects, lights=(SUN, SPOT, EnvironmentLight(model.sky())))
    np.testing.assert_array_equal(image(scene), image(scene))


@pytest.mark.parametrize("isotropic", [False, True])
def test_a_matte_surface_gathers_the_whole_sky(isotropic: bool) -> None:
    material = Material(albedo=PAPER, isotropic=isotropic)
    scene = Scene("matte", ABOVE, (floor(material),), lights=(EnvironmentLight(model.sky()),))
    d, radiance, solid = model.around(model.sky())
    weight = 1 / (4 * math.pi) if isotropic else np.maximum(d[:, 1], 0) / math.pi
    expected = PAPER * ((weight * solid) @ radiance)
    np.testing.assert_allclose(image(scene), np.tile(expected, (30, 1)), rtol=4e-3)


@pytest.mark.parametrize("normal", [(1, 0, 0), (-1, 0, 0), (0, 0, -1)])
def test_a_wall_gathers_the_sky_that_it_faces(normal: tuple[int, int, int]) -> None:
    n = np.asarray(normal, dtype=np.float64)
    right = np.roll(n, 1)
    mesh = quad((0, 0, 0), tuple(right), tuple(np.cross(n, right)))
    camera = Camera(tuple(3 * n), fov_y=0.02, up=tuple(right))
    screen = Object("wall", mesh, Material(albedo=PAPER))
    found = image(Scene("wall", camera, (screen,), lights=(EnvironmentLight(model.sky()),)))
    d, radiance, solid = model.around(model.sky())
    expected = PAPER * ((np.maximum(d @ n, 0) / math.pi * solid) @ radiance)
    np.testing.assert_allclose(found, np.tile(expected, (30, 1)), rtol=4e-3)


@pytest.mark.parametrize(("roughness", "allowed"), [(0.5, 0.03), (1.0, 0.03)])
def test_a_rough_mirror_integrates_its_lobe(roughness: float, allowed: float) -> None:
    gloss = floor(Material(specular=0.3, roughness=roughness))
    scene = Scene("mirror", ABOVE, (gloss,), lights=(EnvironmentLight(model.sky()),))
    _, directions = View(ABOVE, *SIZE).rays(0, SIZE[0] * SIZE[1])
    expected = [model.mirrored(model.sky(), (0, 1, 0), -v, 0.3, roughness) for v in directions]
    np.testing.assert_allclose(image(scene), expected, rtol=allowed)


def test_a_smooth_mirror_shows_a_point_of_the_sky_times_f() -> None:
    scene = Scene(
        "mirror", ABOVE, (floor(Material(specular=0.3, roughness=0.0)),),
        lights=(EnvironmentLight((1.0, 2.0, 3.0)),),
    )  # fmt: skip
    _, directions = View(ABOVE, *SIZE).rays(0, SIZE[0] * SIZE[1])
    fresnel = 0.3 + 0.7 * (1 + directions[:, 1]) ** 5
    np.testing.assert_allclose(image(scene), np.outer(fresnel, (1, 2, 3)), rtol=1e-4)
