"""Orthographic cameras in OpenGL: places, depths, coincidence, fog, occlusion and bends."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from oitbench.gl.device import Device
from oitbench.gl.probe import probe
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.modeling.mesh import quad
from oitbench.scene import (
    WHITE,
    Camera,
    DirectionalLight,
    EnvironmentLight,
    Floats,
    Material,
    Object,
    Scene,
    SpotLight,
    as_vector,
    unit,
)
from tests.gl.test_coincidence import TILTS, decal
from tests.gl.test_occlusion import corner, found_openness
from tests.helpers import moved, opened, render
from tests.methods.foggy import AMBIENT, FLOAT, FOG, LAMP, SIZE, STEPS, SUN, foggy
from tests.models import fog as model
from tests.models import phenomenological
from tests.models.view import origins, rays

FLAT = Camera((0.2, 0.1, 3.0), (0.2, 0.1, 0.0), height=2.0)
HALF = Material(coverage=0.5, emission=(1.0, 0.0, 0.0))
GLASS = Material(transmission=WHITE, index=1.5, solid=True)


def sheet(z: float, half: float = 5.0) -> Object:
    return Object(f"sheet {z}", quad((0, 0, z), (half, 0, 0), (0, half, 0)), HALF)


@pytest.mark.parametrize("far", [math.inf, 50.0])
@pytest.mark.parametrize("unit", [1.0, 1000.0])
def test_a_fragment_has_its_distance_along_the_axis(
    device: Device, unit: float, far: float
) -> None:
    distances = (0.5, 2.0, 2.0 + 1e-5, 20.0)
    scene = Scene(
        "sheets",
        replace(FLAT, far=far).relocated((0, 0, 0), unit),
        tuple(
            replace(item, mesh=item.mesh.relocated((0, 0, 0), unit))
            for item in (sheet(3.0 - distance) for distance in distances)
        ),
        meters_per_unit=1 / unit,
    )
    with UploadedScene(device, scene) as uploaded:
        found = np.sort(probe(uploaded, (8, 8), (1, 6)).z[:, 0, 0].astype(np.float64))
    np.testing.assert_allclose(found, distances, atol=4e-6)
    assert found[1] < found[2]


def test_the_picture_has_its_height_at_any_distance(device: Device) -> None:
    for distance in (0.5, 40.0):
        scene = Scene("square", FLAT, (sheet(3.0 - distance, half=0.25),))
        with UploadedScene(device, scene) as uploaded:
            covered = uploaded.fragment_counts((64, 32))[::-1] > 0
        # A pixel is 1/16 m. Centers of pixels are between −1/4 and 1/4 m of (0, 0).
        across, up = (np.arange(64) - 31.5) / 16 + 0.2, (15.5 - np.arange(32)) / 16 + 0.1
        expected = (np.abs(up)[:, None] < 0.25) & (np.abs(across) < 0.25)
        np.testing.assert_array_equal(covered, expected)


def test_what_lies_behind_the_far_plane_is_not_drawn(device: Device) -> None:
    scene = Scene("far", replace(FLAT, far=4.0), (sheet(-0.5), sheet(-1.5)))
    with UploadedScene(device, scene) as uploaded:
        np.testing.assert_array_equal(uploaded.fragment_counts((4, 4)), 1)


@pytest.mark.parametrize("tilt", TILTS)
@pytest.mark.parametrize("chosen", ["a_buffer", "sorted_over"])
def test_a_decal_is_before_its_wall(device: Device, chosen: str, tilt: float) -> None:
    camera = Camera((0.3, 0.2, 9.0), (0.2, 0.3, -1.0), height=2.0)
    front = render(device, replace(decal(tilt), camera=camera), chosen, size=(24, 16))
    np.testing.assert_allclose(front, np.broadcast_to((1.0, 0.5, 0.5), front.shape), atol=2e-3)
    turned = replace(decal(tilt, turned=True), camera=camera)
    back = render(device, turned, chosen, size=(24, 16))
    np.testing.assert_allclose(back, 1.0, atol=2e-3)


def test_surfaces_in_a_plane_through_the_camera_coincide(device: Device) -> None:
    """Such a plane is seen edge on by a pinhole, but not by parallel rays."""
    camera = Camera((0.0, 0.0, 0.0), (0.0, 0.0, -1.0), height=2.0, near=0.5)
    up, right = (0.0, 1.5, -3.0), (1.0, 0.0, 0.0)
    middle = (0.0, 1.5, -3.0)
    wall = Object("wall", quad(middle, (3, 0, 0), up), Material(emission=(1.0, 1.0, 1.0)))
    scene = Scene("plane", camera, (wall, Object("decal", quad(middle, right, up), HALF)))
    assert scene.coincidence is not None
    image = render(device, scene, "a_buffer", size=(16, 16))
    np.testing.assert_allclose(image[:4, 6:10], np.broadcast_to((1.0, 0.5, 0.5), (4, 4, 3)))


@pytest.mark.parametrize("beam", [SUN, LAMP], ids=["sun", "lamp"])
def test_fog_follows_the_model(device: Device, beam: DirectionalLight | SpotLight) -> None:
    camera = Camera((0.0, 0.0, 0.0), (0.1, -0.1, -1.0), height=1.6)
    scene = foggy(FOG, (beam, EnvironmentLight(AMBIENT)), camera=camera)
    with opened(device, scene, FLOAT, SIZE) as frame:
        frame.render()
        accum, beta = frame.read("accum"), frame.read("beta")
        behind = distances(camera)
    far = 1.01 * camera.view_distance(scene.objects[0].mesh.positions).max()
    slices = model.march(camera, FOG, SIZE, STEPS, behind, (beam,), AMBIENT)
    depth = (slices.z - camera.near) / (far - camera.near)
    weight = phenomenological.depth_weight(slices.coverage, depth) * slices.coverage
    light = np.concatenate([slices.radiance, np.ones((*slices.z.shape, 1))], axis=-1)
    np.testing.assert_allclose(accum, (weight[..., None] * light).sum(0), rtol=2e-4, atol=2e-6)
    left = (1 - slices.coverage).prod(axis=0)
    # GPUs snap the wall's vertices, and so move its distance.
    snapped = FOG.extinction * moved(device, np.broadcast_to(behind, left.shape))
    allowed = 2e-6 + float(left.max()) * snapped
    np.testing.assert_allclose(beta[..., :3], np.repeat(left[..., None], 3, -1), atol=allowed)


def distances(camera: Camera) -> Floats:
    """Return the view distance of the wall of `foggy` at each pixel, top row first."""
    start, ray = origins(camera, SIZE), rays(camera, SIZE)
    return np.asarray((-3.0 - start[..., 2]) / ray[..., 2])


@pytest.mark.parametrize("tilt", [0.1, 0.5, 2.0])
def test_a_plane_is_not_occluded(device: Device, tilt: float) -> None:
    scene = corner(wall=False, tilt=tilt)
    flat = replace(scene, camera=replace(scene.camera, height=1.5))
    assert found_openness(device, flat).min() >= 1 - 1 / 255


def test_a_crease_has_the_openness_of_perspective(device: Device) -> None:
    scene = corner(radius=2.0)
    height = scene.camera.span * math.dist(scene.camera.position, scene.camera.target)
    flat = replace(scene, camera=replace(scene.camera, height=height))
    near, parallel = found_openness(device, scene), found_openness(device, flat)
    middle = np.s_[len(near) // 2 - 3 : len(near) // 2 + 3, 8:-8]
    assert parallel[middle].mean() == pytest.approx(near[middle].mean(), abs=0.02)
    assert parallel.min() < 0.75


def test_a_tilted_surface_bends_all_rays_alike(device: Device) -> None:
    """Snell's law for one direction of the view, times pixels per meter."""
    normal = unit(np.array([0.3, 0.2, 1.0]))
    right = np.cross((0.0, 1.0, 0.0), normal)
    up = np.cross(normal, right)
    pane = Object("pane", quad((0, 0, 0), as_vector(9 * right), as_vector(9 * up)), GLASS)
    wall = Object("wall", quad((0, 0, -2), (9, 0, 0), (0, 9, 0)), Material(emission=WHITE))
    scene = Scene("pane", Camera((0.0, 0.0, 5.0), height=2.0), (wall, pane))
    with opened(
        device, scene, "phenomenological[precision=float,reach=background]", (8, 8)
    ) as frame:
        frame.render()
        found = frame.read("delta").astype(np.float64)
    (inside,) = phenomenological.bent(np.array([[0.0, 0.0, 1.0]]), normal[None], 1 / 1.5)
    start, ray = origins(scene.camera, (8, 8)), rays(scene.camera, (8, 8))
    along = -(start @ normal) / (ray @ normal)
    reach = 2.0 + (start + along[..., None] * ray)[..., 2]
    expected = 4.0 * reach[..., None] * inside[:2] / -inside[2]
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-5)
