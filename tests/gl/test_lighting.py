"""Light on surfaces against closed forms and a float64 model of reflection."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from oitbench.gl.device import Device
from oitbench.modeling.mesh import quad
from oitbench.scene import (
    LEAST_LOBE,
    PENUMBRA,
    RGB,
    Camera,
    DirectionalLight,
    EnvironmentLight,
    Floats,
    Light,
    Material,
    Object,
    Scene,
    SpotLight,
    Texture,
    sample_density,
    unit,
)
from oitbench.scene.texturing import constant
from tests.helpers import Empty, moved, opened
from tests.models.view import rays

SIZE = (33, 33)
EYE = (0.3, 2.0, 1.5)
CAMERA = Camera(position=EYE, target=(0, 0, 0), fov_y=math.radians(30))


def floor(material: Material) -> Object:
    return Object("floor", quad((0, 0, 0), (4, 0, 0), (0, 0, -4)), material)


def points() -> Floats:
    """Return the points where the rays of the pixels meet the floor, shape (h, w, 3)."""
    ray = rays(CAMERA, SIZE)
    return np.asarray(np.asarray(EYE) + ray * (-EYE[1] / ray[..., 1:2]))


def shown(device: Device, material: Material, *lights: Light) -> Floats:
    scene = Scene("floor", CAMERA, (floor(material),), lights=lights)
    with opened(device, scene, Empty(), SIZE) as frame:
        frame.render()
        return frame.image().astype(np.float64)


def lobe(material: Material, to_light: Floats, to_eye: Floats) -> Floats:
    """Return the microfacet lobe times the cosine, for a horizontal floor."""
    assert not isinstance(material.roughness, Texture)
    a, f0 = material.roughness**2, material.reflectance
    half = unit(to_light + to_eye)
    nl, nv, nh = to_light[..., 1], to_eye[..., 1], half[..., 1]
    density = a**2 / (np.pi * (nh**2 * (a**2 - 1) + 1) ** 2)
    smith = nl * np.sqrt(nv**2 * (1 - a**2) + a**2) + nv * np.sqrt(nl**2 * (1 - a**2) + a**2)
    fresnel = f0 + (1 - f0) * (1 - (half * to_eye).sum(axis=-1)) ** 5
    cosine_weighted: Floats = density * 0.5 / smith * fresnel * nl
    return cosine_weighted[..., None]


def test_a_lambert_surface_reflects_a_directional_light(device: Device) -> None:
    albedo, irradiance = (0.8, 0.4, 0.2), (2.0, 3.0, 4.0)
    sun = DirectionalLight((1.0, -2.0, 0.5), irradiance)
    cosine = 2 / math.sqrt(1 + 4 + 0.25)
    expected = np.multiply(albedo, irradiance) / math.pi * cosine
    found = shown(device, Material(albedo=albedo), sun)
    np.testing.assert_allclose(found, np.broadcast_to(expected, found.shape), rtol=1e-5)


def test_light_from_below_does_not_pass_the_floor(device: Device) -> None:
    assert not shown(device, Material(albedo=(1, 1, 1)), DirectionalLight((0.0, 1.0, 0.0))).any()


@pytest.mark.parametrize("roughness", [0.3, 0.6, 1.0])
def test_highlights_equal_the_model(device: Device, roughness: float) -> None:
    material = Material(specular=0.08, roughness=roughness)
    direction = np.array([0.1, -1.0, 0.8])
    to_light = np.broadcast_to(unit(-direction), (*SIZE, 3))
    expected = lobe(material, to_light, unit(np.asarray(EYE) - points()))
    found = shown(device, material, DirectionalLight((0.1, -1.0, 0.8), (1, 1, 1)))
    np.testing.assert_allclose(found, np.broadcast_to(expected, found.shape), rtol=2e-3, atol=1e-6)
    assert found.max() > 3 * np.median(found) or roughness > 0.3


def test_a_mirror_shows_a_beam_in_a_narrow_lobe(device: Device) -> None:
    mirror = Material(specular=0.5, roughness=0.0)
    narrow = Material(specular=0.5, roughness=LEAST_LOBE)
    mirrored = (0.3, -2.0, 1.5)
    to_light = np.broadcast_to(unit(-np.array(mirrored)), (*SIZE, 3))
    expected = lobe(narrow, to_light, unit(np.asarray(EYE) - points()))
    found = shown(device, mirror, DirectionalLight(mirrored))
    np.testing.assert_allclose(found, np.broadcast_to(expected, found.shape), rtol=5e-3)
    assert found.max() > 300
    assert np.median(found) < 0.01 * found.max()


def test_a_spot_light_falls_off_with_distance_and_angle(device: Device) -> None:
    position, angle = (0.4, 1.2, 0.1), math.radians(50)
    spot = SpotLight(position, (0.2, 0.0, -0.1), (5.0, 5.0, 5.0), angle)
    offset = points() - position
    distance = np.linalg.norm(offset, axis=-1)
    axis = unit(np.subtract((0.2, 0.0, -0.1), position))
    off_axis = np.arccos(np.clip(unit(offset) @ axis, -1, 1))
    falloff = np.clip((angle / 2 - off_axis) / (PENUMBRA * angle / 2), 0, 1)
    cosine = -unit(offset)[..., 1]
    expected = 0.5 / math.pi * 5.0 * falloff / distance**2 * cosine
    found = shown(device, Material(albedo=(0.5, 0.5, 0.5)), spot)[..., 0]
    allowed = 2e-4 + moved(device, expected)
    np.testing.assert_allclose(found, expected, rtol=1e-3, atol=allowed)
    assert (found == 0).any()
    assert ((falloff > 0) & (falloff < 1)).any()


def test_a_particle_scatters_equally_in_all_directions(device: Device) -> None:
    smoke = Material(albedo=(0.9, 0.6, 0.3), isotropic=True)
    for direction in ((0.0, -1.0, 0.0), (0.7, 0.2, 0.1)):
        found = shown(device, smoke, DirectionalLight(direction, (2, 2, 2)))
        expected = np.multiply(constant(smoke.albedo), 2 / (4 * math.pi))
        np.testing.assert_allclose(found, np.broadcast_to(expected, found.shape), rtol=1e-5)


def test_a_constant_environment_lights_surfaces_and_is_reflected(device: Device) -> None:
    sky: RGB = (0.5, 0.7, 1.0)
    lambert = shown(device, Material(albedo=(0.4, 0.4, 0.4)), EnvironmentLight(sky))
    np.testing.assert_allclose(
        lambert, np.broadcast_to(np.multiply(sky, 0.4), lambert.shape), rtol=1e-4
    )
    mirror = shown(device, Material(specular=0.04, roughness=0.0), EnvironmentLight(sky))
    cosine = unit(np.asarray(EYE) - points())[..., 1:2]
    expected = (0.04 + 0.96 * (1 - cosine) ** 5) * np.asarray(sky)
    np.testing.assert_allclose(mirror, expected, rtol=1e-3)


def test_transmission_loses_the_reflected_and_the_scattered_light(device: Device) -> None:
    """The transmittance is t = T (1 - F) (1 - albedo)."""
    pane = Material(transmission=(0.9, 0.8, 0.7), albedo=(0.1, 0.0, 0.2), specular=0.06)
    scene = Scene("pane", CAMERA, (floor(pane),))
    cosine = unit(np.asarray(EYE) - points())[..., 1:2]
    kept = 1 - (0.06 + 0.94 * (1 - cosine) ** 5)
    expected = np.multiply((0.9, 0.8, 0.7), (0.9, 1.0, 0.8)) * kept
    with opened(device, scene, "phenomenological[precision=float]", SIZE) as frame:
        frame.render(transmittance=True)
        np.testing.assert_allclose(frame.image(), expected, rtol=1e-4)


def test_a_particle_has_no_fresnel_term(device: Device) -> None:
    smoke = Material(transmission=(0.9, 0.8, 0.7), isotropic=True, specular=0.5)
    scene = Scene("smoke", CAMERA, (floor(smoke),))
    with opened(device, scene, "phenomenological[precision=float]", SIZE) as frame:
        frame.render(transmittance=True)
        found = frame.image()
    np.testing.assert_allclose(
        found, np.broadcast_to(constant(smoke.transmission), found.shape), rtol=1e-5
    )


DIRECTIONS: list[tuple[str, RGB]] = [
    ("up", (0, 1, 0)), ("down", (0, -1, 0)), ("ahead", (0, 0, -1)),
    ("behind", (0, 0, 1)), ("right", (1, 0, 0)), ("left", (-1, 0, 0)),
]  # fmt: skip


def lit_from(direction: RGB, width: int = 64, height: int = 32) -> Floats:
    """Return a map that is white within 30 degrees of `direction` and black elsewhere."""
    polar = (np.arange(height) + 0.5) / height * math.pi
    longitude = ((np.arange(width) + 0.5) / width - 0.5) * 2 * math.pi
    vectors = np.stack(
        [
            np.sin(polar)[:, None] * np.sin(longitude),
            np.broadcast_to(np.cos(polar)[:, None], (height, width)),
            -np.sin(polar)[:, None] * np.cos(longitude),
        ],
        axis=-1,
    )
    inside = vectors @ np.asarray(direction, dtype=np.float64) > math.cos(math.radians(30))
    return np.repeat(inside[..., None].astype(np.float64), 3, axis=2)


@pytest.mark.parametrize(("name", "direction"), DIRECTIONS)
def test_an_environment_map_is_seen_in_its_direction(
    device: Device, name: str, direction: RGB
) -> None:
    texels = lit_from(direction).astype(np.float32)
    up = (0.0, 0.0, 1.0) if name in ("up", "down") else (0.0, 1.0, 0.0)
    dot = Object("dot", quad((30, 40, 50), (0.01, 0, 0), (0, 0.01, 0)), Material())
    for sign, bright in ((1, True), (-1, False)):
        camera = Camera(
            (0, 0, 0), (sign * direction[0], sign * direction[1], sign * direction[2]), up
        )
        scene = Scene("sky", camera, (dot,), lights=(EnvironmentLight(Texture(texels)),))
        with opened(device, scene, Empty(), SIZE) as frame:
            frame.render()
            assert (frame.image()[16, 16, 0] > 0.9) == bright


def test_a_map_of_one_channel_equals_its_gray_map(device: Device) -> None:
    gray = np.linspace(0.1, 0.9, 8, dtype=np.float32).reshape(2, 4)
    wall = Material(albedo=(0.4, 0.4, 0.4), specular=0.04)
    one, other = (
        shown(device, wall, EnvironmentLight(Texture(texels)))
        for texels in (gray, np.repeat(gray[..., None], 3, axis=2))
    )
    np.testing.assert_array_equal(one, other)


def test_density_is_sampled_at_cell_centers() -> None:
    def height(points: Floats) -> Floats:
        return np.asarray(points[..., 1])

    density = sample_density(height, (0, 0, 0), (2, 1, 4), (2, 4, 3))
    assert density.shape == (3, 4, 2)
    np.testing.assert_allclose(density[0, :, 0], [0.125, 0.375, 0.625, 0.875])


Check = Callable[[], object]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: DirectionalLight((0.0, 0.0, 0.0)), "no length"),
        (lambda: SpotLight((0, 1, 0), (0, 1, 0)), "coincide"),
        (lambda: SpotLight((0, 1, 0), (0, 0, 0), angle=4.0), "angle"),
    ],
)
def test_lights_without_a_direction_are_refused(make: Check, message: str) -> None:
    from oitbench.errors import SceneError

    with pytest.raises(SceneError, match=message):
        make()
