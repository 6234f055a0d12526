"""Path-traced light, shadows and reflections against closed forms."""

from __future__ import annotations

import dataclasses
import importlib
import math
from typing import Literal

import numpy as np
import numpy.typing as npt
import pytest

from oitbench.modeling.mesh import quad
from oitbench.path_traced import llvm
from oitbench.path_traced.export.view import View
from oitbench.path_traced.trace.lights import TracedEnvironment
from oitbench.path_traced.trace.path_tracer import is_random
from oitbench.path_traced.trace.render import render
from oitbench.scene import (
    PENUMBRA,
    RGB,
    Camera,
    DirectionalLight,
    EnvironmentLight,
    Floats,
    Material,
    Object,
    Scene,
    SpotLight,
    Texture,
    unit,
)
from oitbench.scene.texturing import constant
from tests.path_traced.agreement import assert_mean, needs_mitsuba

pytestmark = needs_mitsuba

SIZE = (6, 5)
ABOVE = Camera((0.3, 4.0, 3.0))
SUN = DirectionalLight((0.3, -1.0, -0.2), (2.0, 3.0, 4.0))
PAPER: RGB = (0.8, 0.5, 0.2)
PANES = (
    Material(transmission=(0.9, 0.5, 0.2), index=1.5),
    Material(0.7, transmission=(0.3, 0.8, 0.9), albedo=(0.1, 0.2, 0.3)),
)


def _floor(material: Material, half: float = 50.0, height: float = 0.0) -> Object:
    return Object(f"floor {height}", quad((0, height, 0), (half, 0, 0), (0, 0, -half)), material)


def _points(camera: Camera = ABOVE) -> tuple[Floats, Floats]:
    """Return the points where rays hit the floor, and unit vectors from there to the eye."""
    origins, directions = View(camera, *SIZE).rays(0, SIZE[0] * SIZE[1])
    return origins - directions * (origins[:, 1:2] / directions[:, 1:2]), -directions


def _schlick(reflectance: float, cosine: npt.ArrayLike) -> Floats:
    return np.asarray(reflectance + (1 - reflectance) * (1 - np.asarray(cosine)) ** 5)


def _image(scene: Scene) -> Floats:
    estimate = render(scene, SIZE, ssaa=1)
    assert estimate.variance.max() < 1e-12
    return estimate.mean.reshape(-1, 3).astype(np.float64)


def test_a_lambert_plane_under_a_directional_light() -> None:
    scene = Scene("plane", ABOVE, (_floor(Material(albedo=PAPER)),), lights=(SUN,))
    cosine = -unit(np.array(SUN.direction))[1]
    expected = np.multiply(PAPER, SUN.irradiance) / math.pi * cosine
    np.testing.assert_allclose(_image(scene), np.tile(expected, (30, 1)), atol=1e-4)
    below = dataclasses.replace(scene, camera=Camera((0.3, -4.0, 3.0)))
    assert (_image(below) == 0).all()


def test_the_cone_of_a_spot_light_fades_linearly_in_the_angle() -> None:
    spot = SpotLight((0.2, 2.0, 0.1), (0.0, 0.0, 0.3), (5.0, 6.0, 7.0), math.radians(70))
    scene = Scene("spot", ABOVE, (_floor(Material(albedo=PAPER)),), lights=(spot,))
    points, _ = _points()
    offset = np.asarray(spot.position) - points
    squared = (offset**2).sum(axis=1)
    axis = unit(np.subtract(spot.target, spot.position))
    angle = np.arccos(-unit(offset) @ axis)
    half = spot.angle / 2
    falloff = np.clip((half - angle) / (PENUMBRA * half), 0, 1)
    assert ((falloff > 0) & (falloff < 1)).any()
    assert (falloff == 0).any()
    expected = np.outer(falloff / squared * unit(offset)[:, 1], spot.intensity)
    np.testing.assert_allclose(_image(scene), expected * PAPER / math.pi, atol=1e-4)


@pytest.mark.parametrize("roughness", [0.35, 1.0])
def test_a_highlight_equals_its_formula(roughness: float) -> None:
    gloss = Material(specular=0.3, roughness=roughness)
    light = DirectionalLight((-0.1, -1.0, -0.9), (1.0, 2.0, 3.0))
    scene = Scene("gloss", ABOVE, (_floor(gloss),), lights=(light,))
    _, v = _points()
    toward = -unit(np.array(light.direction))
    half = unit(v + toward)
    nl, nv, nh, hv = toward[1], v[:, 1], half[:, 1], (half * v).sum(axis=1)
    a2 = roughness**4
    density = a2 / (math.pi * (nh**2 * (a2 - 1) + 1) ** 2)
    shared = nl * np.sqrt(nv**2 * (1 - a2) + a2) + nv * np.sqrt(nl**2 * (1 - a2) + a2)
    lobe = density * 0.5 / shared * _schlick(0.3, hv) * nl
    np.testing.assert_allclose(_image(scene), np.outer(lobe, light.irradiance), rtol=2e-4)


def test_a_shadow_through_panes_has_the_color_of_their_product() -> None:
    panes = [_floor(pane, 50.0, 5.0 + i) for i, pane in enumerate(PANES)]
    objects = (_floor(Material(albedo=PAPER)), *panes)
    scene = Scene("panes", ABOVE, objects, lights=(SUN,))
    cosine = -unit(np.array(SUN.direction))[1]
    clear = np.multiply(PAPER, SUN.irradiance) / math.pi * cosine
    first = np.asarray(PANES[0].transmission) * (1 - _schlick(0.04, cosine))
    second = 0.3 + 0.7 * np.multiply(
        constant(PANES[1].transmission), np.subtract(1, constant(PANES[1].albedo))
    )
    expected = np.tile(clear * first * second, (30, 1))
    np.testing.assert_allclose(_image(scene), expected, rtol=1e-4)


def test_opaque_shadows_are_hard_and_black() -> None:
    lid = Object("lid", quad((0.3, 6, 0), (1.0, 0, 0), (0, 0, -60)), Material())
    down = DirectionalLight((0.0, -1.0, 0.0), (1.0, 1.0, 1.0))
    objects = (_floor(Material(albedo=PAPER)), lid)
    image = _image(Scene("lid", ABOVE, objects, lights=(down,)))
    shaded = np.abs(_points()[0][:, 0] - 0.3) < 1
    assert shaded.any()
    assert not shaded.all()
    expected = np.where(shaded[:, None], 0, np.asarray(PAPER) / math.pi)
    np.testing.assert_allclose(image, expected, atol=1e-5)


def test_transmission_loses_the_reflected_light() -> None:
    wall = Object(
        "wall", quad((0, 0, -1), (9, 0, 0), (0, 9, 0)), Material(emission=(1.0, 2.0, 3.0))
    )
    pane = Object("pane", quad((0, 0, 0), (9, 0, 0), (0, 9, 0)), PANES[0])
    narrow = Camera((0.0, 0.0, 4.0), fov_y=0.01)
    estimate = render(Scene("pane", narrow, (wall, pane)), (48, 48))
    assert_mean(estimate, np.multiply(constant(PANES[0].transmission), (1.0, 2.0, 3.0)) * 0.96)


def test_isotropic_particles_scatter_equally_to_all_sides() -> None:
    dust = Material(0.4, albedo=PAPER, isotropic=True, index=1.5)
    scene = Scene("dust", ABOVE, (_floor(dust),), lights=(SUN,))
    expected = 0.4 * np.multiply(PAPER, SUN.irradiance) / (4 * math.pi)
    for camera in (ABOVE, Camera((0.3, -4.0, 3.0))):
        image = _image(dataclasses.replace(scene, camera=camera))
        np.testing.assert_allclose(image, np.tile(expected, (30, 1)), rtol=1e-4)


def test_particles_have_the_mean_of_all_layers() -> None:
    films = tuple(
        _floor(Material(0.5, transmission=(0.2, 0.5, 0.9), albedo=(0.2 * i, 0.4, 0.5)), 50, 0.1 * i)
        for i in range(4)
    )
    scene = Scene("layers", ABOVE, films, lights=(SUN, DirectionalLight((0.0, -1.0, 0.5))))
    assert not is_random(scene)
    exact = render(scene, (24, 24))
    chosen = dataclasses.replace(
        scene, objects=tuple(dataclasses.replace(film, particles=True) for film in films)
    )
    assert_mean(render(chosen, (24, 24)), exact.mean.mean(axis=(0, 1)))


def _map() -> Texture:
    """Return a map that is red upward, green to the right (+x) and blue ahead (−z)."""
    texels = np.full((16, 32, 3), 0.05, dtype=np.float32)
    texels[:3, :, 0] = 4.0
    texels[6:10, 22:26, 1] = 5.0
    texels[6:10, 14:18, 2] = 6.0
    return Texture(texels)


@pytest.mark.parametrize(
    ("target", "channel"), [((0.01, 5.0, 0.0), 0), ((5.0, 0.0, 0.0), 1), ((0.0, 0.0, -5.0), 2)]
)
def test_a_map_of_the_environment_is_seen_in_the_right_direction(target: RGB, channel: int) -> None:
    camera = Camera((0.0, 0.0, 0.0), target, fov_y=0.05)
    aside = _floor(Material(), 0.1, -3.0)
    scene = Scene("map", camera, (aside,), lights=(EnvironmentLight(_map()),))
    assert not is_random(scene)
    expected = np.full(3, 0.05)
    expected[channel] = 4.0 + channel
    np.testing.assert_allclose(_image(scene), np.tile(expected, (30, 1)), atol=1e-5)


@pytest.mark.parametrize("normal", [(0, 1, 0), (1, 0, 0), (0, 0, -1)])
def test_a_map_of_the_environment_lights_the_surface_that_faces_it(
    normal: tuple[int, int, int],
) -> None:
    texture = _map()
    n = np.asarray(normal, dtype=np.float64)
    right = np.roll(n, 1)
    mesh = quad((0, 0, 0), tuple(right), tuple(np.cross(n, right)))
    camera = Camera(tuple(3 * n + 0.1 * right), fov_y=0.02, up=tuple(right + 0.2))
    screen = Object("screen", mesh, Material(albedo=(1.0, 1.0, 1.0)))
    scene = Scene("lit", camera, (screen,), lights=(EnvironmentLight(texture),))
    theta = (np.arange(160) + 0.5) / 160 * math.pi
    phi = ((np.arange(320) + 0.5) / 320 - 0.5) * 2 * math.pi
    up, around = np.meshgrid(theta, phi, indexing="ij")
    d = np.stack([np.sin(up) * np.sin(around), np.cos(up), -np.sin(up) * np.cos(around)], axis=-1)
    solid = np.sin(up) * (math.pi / 160) * (2 * math.pi / 320)
    fine = _bilinear(_bilinear(texture.texels, 0, "edge"), 1, "wrap")
    irradiance = (fine * (np.maximum(d @ n, 0) * solid)[..., None]).sum(axis=(0, 1))
    assert_mean(render(scene, (64, 64)), irradiance / math.pi)


def test_directions_are_sampled_in_proportion_to_the_radiance() -> None:
    """Half a texel aside, most of a small sun would be missed."""
    mitsuba, drjit = llvm.load(), importlib.import_module("drjit")
    texels = np.full((32, 64, 3), 0.2, dtype=np.float32)
    texels[6, 40], texels[20, 3] = 500.0, 100.0
    lights = (EnvironmentLight(Texture(texels)),)
    scene = Scene("sun", ABOVE, (_floor(Material()),), lights=lights)
    environment = TracedEnvironment.build(mitsuba, drjit, scene)
    d = unit(np.random.default_rng(5).normal(size=(20000, 3))).astype(np.float32)
    sample = drjit.zeros(mitsuba.DirectionSample3f)
    sample.d = mitsuba.Vector3f(*d.T)
    si = drjit.zeros(mitsuba.SurfaceInteraction3f)
    density = environment.emitter.pdf_direction(si, sample).numpy()
    radiance = environment.radiance(sample.d).numpy()[0]
    assert (radiance > 50).sum() > 10
    expected = radiance / (4 * math.pi * environment.mean[0])
    np.testing.assert_allclose(density, expected, rtol=0.1)


def _bilinear(values: npt.ArrayLike, axis: int, mode: Literal["edge", "wrap"]) -> Floats:
    """Return ten times as many values along `axis`, linear between texel centers."""
    texels = np.moveaxis(np.asarray(values, dtype=np.float64), axis, 0)
    padded = np.pad(texels, [(1, 1)] + [(0, 0)] * (texels.ndim - 1), mode=mode)
    place = (np.arange(10 * len(texels)) + 0.5) / 10 + 0.5
    low = place.astype(int)
    part = (place - low)[:, None, None]
    return np.moveaxis((1 - part) * padded[low] + part * padded[low + 1], 0, axis)


def test_surfaces_in_a_white_environment_are_white() -> None:
    around = EnvironmentLight((1.0, 1.0, 1.0))
    white = Material(albedo=(1.0, 1.0, 1.0), specular=0.0)
    scene = Scene("furnace", ABOVE, (_floor(white),), lights=(around,))
    np.testing.assert_allclose(_image(scene), 1, atol=1e-4)
    mirror = Material(specular=0.5, roughness=0.6, transmission=(1.0, 1.0, 1.0))
    glossy = dataclasses.replace(scene, objects=(_floor(mirror),))
    np.testing.assert_allclose(_image(glossy), 1, atol=1e-4)


def test_the_environment_is_hidden_by_a_lid() -> None:
    lid = Object("lid", quad((0, 1, 0), (1, 0, 0), (0, 0, -1)), Material())
    camera = Camera((3.0, 0.5, 0.0), fov_y=0.002)
    objects = (_floor(Material(albedo=(1.0, 1.0, 1.0))), lid)
    lights = (EnvironmentLight((1.0, 1.0, 1.0)),)
    estimate = render(Scene("lid", camera, objects, lights=lights), (48, 48))
    # The form factor of a square, for a point below its center at a distance of half its side.
    part = 4 * 2 / (2 * math.pi) * (1 / math.sqrt(2)) * math.atan(1 / math.sqrt(2))
    assert_mean(estimate, 1 - np.full(3, part))


@pytest.mark.parametrize("shape", [(1, 1), (2, 1), (1, 4, 3)])
@pytest.mark.parametrize("radiance", [0.0, 0.5])
def test_maps_of_few_texels_light_uniformly(shape: tuple[int, ...], radiance: float) -> None:
    around = EnvironmentLight(Texture(np.full(shape, radiance, dtype=np.float32)))
    white = Material(albedo=(1.0, 1.0, 1.0))
    scene = Scene("even", ABOVE, (_floor(white),), lights=(around,))
    mean = render(scene, (32, 32)).mean.mean(axis=(0, 1))
    np.testing.assert_allclose(mean, radiance, rtol=0.05)


def test_normals_are_interpolated_and_turned_to_the_eye() -> None:
    floor = _floor(Material(albedo=PAPER))
    tilted = np.tile(np.array([0.6, 0.8, 0.0], dtype=np.float32), (4, 1))
    smooth = dataclasses.replace(floor, mesh=dataclasses.replace(floor.mesh, normals=tilted))
    scene = Scene("smooth", ABOVE, (smooth,), lights=(SUN,))
    cosine = -unit(np.array(SUN.direction)) @ (0.6, 0.8, 0.0)
    expected = np.multiply(PAPER, SUN.irradiance) / math.pi * cosine
    facing = _points()[1] @ (0.6, 0.8, 0.0) > 0
    assert facing.any()
    np.testing.assert_allclose(
        _image(scene)[facing], np.tile(expected, (facing.sum(), 1)), rtol=1e-4
    )
