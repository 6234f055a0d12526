"""Refraction by phenomenological transparency: offsets of the background."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.modeling.mesh import quad, slab, sphere
from oitbench.modeling.placement import rotation, transform
from oitbench.scene import WHITE, Camera, Material, Object, Scene
from tests.helpers import moved, opened
from tests.methods.sheets import (
    CAMERA,
    CLEAR,
    FLOAT,
    FOCAL,
    SIZE,
    read,
    sheet_scene,
    wall,
    with_parameter,
)
from tests.models import phenomenological as model
from tests.models.view import rays


@pytest.mark.parametrize("entering", [True, False])
@pytest.mark.parametrize("tilt", [0.0, 0.4, -0.7])
@pytest.mark.parametrize("index", [1.31, 1.5, 2.4])
def test_offsets_follow_snell(device: Device, tilt: float, index: float, entering: bool) -> None:
    """Both faces of a solid bend by the direction inside it; leaving undoes what entering did."""
    turned = tilt if entering else tilt + math.pi
    scene = sheet_scene(replace(CLEAR, index=index, solid=True), tilt=turned)
    with opened(device, scene, with_parameter("reach=fixed"), SIZE) as frame:
        found = read(frame, "delta").astype(np.float64) * (1, -1)  # rows run down
    if not entering:
        found = -found
    ray = rays(CAMERA, SIZE)
    normal = np.array([-math.sin(tilt), 0, math.cos(tilt)])
    position = ray * (-2.0 * normal[2] / (ray @ normal))[..., None]
    toward_eye = -ray / np.linalg.norm(ray, axis=-1, keepdims=True)
    direction = model.bent(toward_eye, np.broadcast_to(normal, ray.shape), 1 / index)
    # The direction of the bent ray, from its offset in a plane 2 m behind the surface.
    shifted = ray[..., :2] + found * (1, -1) / FOCAL
    target = np.concatenate([shifted, -np.ones((*ray.shape[:2], 1))], axis=-1)
    target *= 2.0 - position[..., 2:]
    recovered = target - position
    recovered /= np.linalg.norm(recovered, axis=-1, keepdims=True)
    allowed = 1e-5 + moved(device, direction)
    np.testing.assert_allclose(recovered, direction, rtol=0, atol=allowed)
    sines = [np.linalg.norm(np.cross(d, normal), axis=-1) for d in (recovered, toward_eye)]
    np.testing.assert_allclose(sines[0], sines[1] / index, rtol=0, atol=allowed)


def test_offsets_equal_the_model(device: Device) -> None:
    """A ball in front of the wall: the nearest face is an entry, the farthest one an exit."""
    glass = replace(CLEAR, index=1.5, solid=True)
    ball = Object("ball", sphere((0, 0, -2.0), 0.3, 96, 48), glass)
    with opened(device, Scene("ball", CAMERA, (wall(), ball)), FLOAT, SIZE) as frame:
        found = read(frame, "delta").astype(np.float64)
    ray = rays(CAMERA, SIZE)
    # |z ray - center| = radius at both faces; z is the view distance.
    square, along = (ray**2).sum(axis=-1), 2.0
    root = np.sqrt(np.maximum(along**2 - square * (2.0**2 - 0.3**2), 0))
    expected = np.zeros_like(found)
    for z, entering in (((along - root) / square, True), ((along + root) / square, False)):
        position = z[..., None] * ray
        outward = (position - (0, 0, -2.0)) / 0.3
        normal = outward if entering else -outward
        reach = 4.0 - z
        expected += model.offset(FOCAL, position, normal, 1.5, reach, entering=entering)
    inside = root > 0.15  # facets of the mesh show at the rim
    assert inside.sum() > 50
    assert abs(expected[inside]).max() > 5
    np.testing.assert_allclose(found[inside], expected[inside], rtol=0, atol=0.1)


@pytest.mark.parametrize(
    ("degrees", "ratio", "tolerance"),
    [
        (10, 1.0, 0.25),
        (20, 1.0, 0.25),
        (30, 1.0, 0.25),
        (40, 1.0, 0.25),
        (45, 1.30, 0.02),
        (60, 1.80, 0.02),
    ],
)
def test_a_tilted_slab_shifts_the_background(
    device: Device, degrees: float, ratio: float, tolerance: float
) -> None:
    """By Snell's lateral shift, or as much more as the docstring of the method says."""
    tilt, thickness, pixel, size = math.radians(degrees), 0.1, 0.005, (128, 4)
    behind = 3.0
    distant = Camera((0, 0, 100), (0, 0, 0), fov_y=2 * math.atan(2 * pixel / (100 + behind)))
    bright = Object("bright", quad((1, 0, -behind), (1, 0, 0), (0, 1, 0)), Material(emission=WHITE))
    dark = Object("dark", quad((-1, 0, -behind), (1, 0, 0), (0, 1, 0)), Material())
    glass = replace(CLEAR, index=1.5, solid=True)
    mesh = transform(
        slab((-2, -1, -thickness / 2), (2, 1, thickness / 2)), rotation((0, 1, 0), tilt)
    )
    scenes = {
        "plain": Scene("plain", distant, (bright, dark)),
        "slab": Scene("slab", distant, (bright, dark, Object("slab", mesh, glass))),
    }
    lit = {}
    for name, scene in scenes.items():
        with opened(device, scene, "phenomenological[precision=half]", size) as frame:
            frame.render()
            lit[name] = frame.image()[..., 0].sum(axis=1).mean()
    normal = np.array([math.sin(tilt), 0, math.cos(tilt)])
    inside = model.bent(np.array([0.0, 0, 1]), normal, 1 / 1.5)
    snell = inside[0] * thickness / -(inside @ normal)
    assert (lit["slab"] - lit["plain"]) * pixel == pytest.approx(ratio * snell, rel=tolerance)


def test_rays_without_a_change_of_index_or_an_angle_are_not_bent(device: Device) -> None:
    forced = Effect.COVERAGE | Effect.REFRACTION
    with opened(device, sheet_scene(CLEAR, tilt=0.5), FLOAT, SIZE, effects=forced) as frame:
        assert not read(frame, "delta").any()
    # Every ray meets a sphere around the eye perpendicularly.
    glass = replace(CLEAR, index=1.5, solid=True)
    bubble = Object("bubble", sphere((0, 0, 0), 2.0, 96, 48), glass)
    with opened(device, Scene("bubble", CAMERA, (wall(), bubble)), FLOAT, SIZE) as frame:
        assert abs(read(frame, "delta")).max() < 1e-3


def test_rays_are_traced_to_the_background_or_over_a_fixed_distance(device: Device) -> None:
    glass = replace(CLEAR, index=1.5, solid=True)
    offsets = {}
    for behind in (3.0, 5.0):
        for reach in ("background", "fixed", "fixed,dz=0.5"):
            scene = sheet_scene(glass, z=2.0, behind=behind, tilt=0.5)
            with opened(device, scene, with_parameter(f"reach={reach}"), SIZE) as frame:
                offsets[behind, reach] = read(frame, "delta")
    np.testing.assert_array_equal(offsets[3.0, "fixed"], offsets[5.0, "fixed"])
    assert abs(offsets[3.0, "background"]).max() < abs(offsets[5.0, "background"]).max()
    ray = rays(CAMERA, SIZE)
    normal = np.array([-math.sin(0.5), 0, math.cos(0.5)])
    position = ray * (-2.0 * normal[2] / (ray @ normal))[..., None]
    normals = np.broadcast_to(normal, ray.shape)
    for reach, distance in (("fixed", 2.0), ("fixed,dz=0.5", 0.5), ("background", None)):
        far = np.full(ray.shape[:2], distance) if distance else 3.0 + position[..., 2]
        expected = model.offset(FOCAL, position, normals, 1.5, far, entering=True)
        allowed = 2e-4 + moved(device, expected)
        np.testing.assert_allclose(offsets[3.0, reach], expected, atol=allowed)


@pytest.mark.parametrize("offset", ["alpha", "net", "normalized"])
def test_offsets_are_weighted_by_the_chosen_rule(device: Device, offset: str) -> None:
    glass = Material(
        coverage=0.5, transmission=(0.6, 0.6, 0.6), specular=0.0, index=1.5, solid=True
    )
    values = {}
    for coverage in (0.5, 1.0):
        scene = sheet_scene(replace(glass, coverage=coverage), tilt=0.4)
        with opened(device, scene, with_parameter(f"offset={offset}"), SIZE) as frame:
            delta = read(frame, "delta")
            values[coverage] = delta / frame.read("bending") if offset == "normalized" else delta
    part = {"alpha": 0.5, "net": 0.5, "normalized": 1.0}[offset]
    np.testing.assert_allclose(values[0.5], part * values[1.0], rtol=1e-5)
    scale = {"alpha": 1.0, "net": 0.4, "normalized": 1.0}[offset]
    with opened(device, sheet_scene(replace(glass, coverage=1.0), tilt=0.4), FLOAT, SIZE) as frame:
        np.testing.assert_allclose(values[1.0], scale * read(frame, "delta"), rtol=1e-4)
