"""A camera that moves through an uploaded scene sees what one sees that was always there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from oitbench.gl.device import Device
from oitbench.gl.frame import Frame, Image
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.gl.view import transparent_range
from oitbench.modeling.mesh import quad
from oitbench.scene import Camera, Material, Medium, Object, Scene
from oitbench.shading import read_shading
from tests.gl.test_coincidence import decal
from tests.helpers import collection, method, opened, random_lists, render, scene_of

SIZE = (48, 32)
COARSE = read_shading("shadow_map=128,slices=8")
CASES = [
    ("tumblers[detail=0.2]", "a_buffer"),
    ("bottles[detail=0.1]", "sorted_over[sort=object]"),
    ("foliage[light=sky,detail=0.1]", "adaptive[msaa=4]"),
    ("foggy_street[detail=0.1]", "phenomenological"),
]


def turned(camera: Camera, angle: float) -> Camera:
    """Return the camera turned about its target and the vertical, and a little nearer."""
    x, y, z = np.subtract(camera.position, camera.target)
    offset = np.array(
        [x * np.cos(angle) + z * np.sin(angle), y, z * np.cos(angle) - x * np.sin(angle)]
    )
    place = np.asarray(camera.target) + 0.95 * offset
    return replace(camera, position=tuple(place.tolist()), fov_y=0.9 * camera.fov_y)


def seen_after_moving(device: Device, scene: Scene, chosen: str, cameras: list[Camera]) -> Image:
    """Return the last of the pictures that one frame shows of an uploaded scene."""
    entry = method(chosen)
    with (
        UploadedScene(device, scene, COARSE) as uploaded,
        Frame(uploaded, entry, SIZE, scene.effects & entry.shows) as frame,
    ):
        frame.render()
        for camera in cameras:
            uploaded.move(camera)
            frame.render()
        return frame.image()


@pytest.mark.parametrize(("name", "chosen"), CASES)
def test_a_moved_camera_sees_the_same(device: Device, name: str, chosen: str) -> None:
    scene = collection().build_scene(name)
    ways = [turned(scene.camera, angle) for angle in (2.0, 0.5)]
    found = seen_after_moving(device, scene, chosen, ways)
    there = replace(scene, camera=ways[-1])
    expected = render(device, there, chosen, size=SIZE, settings=COARSE)
    before = render(device, scene, chosen, size=SIZE, settings=COARSE)
    # Vertices are rounded relative to another place, so edges may miss a pixel's center.
    off = abs(found - expected).max(axis=-1) > 0.01
    assert off.mean() < 0.01
    assert (abs(before - expected).max(axis=-1) > 0.01).mean() > 0.2


def test_a_camera_that_returns_sees_the_same_bits(device: Device) -> None:
    scene = collection().build_scene("foliage[light=sky,detail=0.1]")
    found = seen_after_moving(
        device, scene, "a_buffer", [turned(scene.camera, 1.0), replace(scene.camera)]
    )
    expected = render(device, scene, "a_buffer", size=SIZE, settings=COARSE)
    np.testing.assert_array_equal(found, expected)


def test_fragments_are_counted_again(device: Device) -> None:
    scene = collection().build_scene("bottles[detail=0.1]")
    away = replace(scene.camera, target=(0.0, 1000.0, 0.0))
    with opened(device, scene, "a_buffer", SIZE) as frame:
        frame.render()
        assert frame.complexity.max() > 0
        frame.scene.move(away)
        frame.render()
        assert frame.complexity.max() == 0


def test_lengths_are_those_of_the_scene(device: Device) -> None:
    scene = replace(collection().build_scene("bottles[detail=0.1]"), meters_per_unit=0.01)
    way = turned(scene.camera, 0.5)
    found = seen_after_moving(device, scene, "weighted_sum", [way])
    there = replace(scene, camera=way)
    expected = render(device, there, "weighted_sum", size=SIZE, settings=COARSE)
    assert (abs(found - expected).max(axis=-1) > 0.01).mean() < 0.01


@pytest.mark.parametrize(
    "scene",
    [scene_of(random_lists(2)), decal(0.0), collection().build_scene("smoke_ball[detail=0.1]")],
    ids=["lists", "common planes", "sprites"],
)
def test_some_geometry_belongs_to_its_camera(device: Device, scene: Scene) -> None:
    with UploadedScene(device, scene) as uploaded:
        assert not uploaded.movable


def test_the_range_of_transparent_geometry_moves_with_the_camera(device: Device) -> None:
    scene = collection().build_scene("bottles[detail=0.1]")
    camera = scene.camera
    away = np.asarray(camera.target) + 3 * np.subtract(camera.position, camera.target)
    way = replace(camera, position=tuple(away.tolist()))
    there = replace(scene, camera=way)
    with UploadedScene(device, scene, COARSE) as uploaded:
        before = transparent_range(uploaded.geometry.scene)
        uploaded.move(way)
        found = transparent_range(uploaded.geometry.scene)
        assert uploaded.geometry.transparent_range == found
    assert found[0] > before[1]
    np.testing.assert_allclose(found, transparent_range(there.seen_from_camera()), rtol=1e-6)


def test_an_orthographic_camera_moves_beside_fog(device: Device) -> None:
    blue = Material(emission=(0.2, 0.4, 0.6))
    wall = Object("wall", quad((0, 0, -6), (9, 0, 0), (0, 9, 0)), blue)
    fog = Medium(1.5, (-0.5, -0.5, -3.0), (0.5, 0.5, -2.0), ambient=(0.9, 0.5, 0.3))
    camera = Camera((0.0, 0.0, 0.0), (0.0, 0.0, -1.0), height=3.0)
    scene = Scene("fog", camera, (wall,), medium=fog)
    way = replace(camera, position=(0.8, 0.3, 0.5), target=(0.8, 0.3, -1.0))
    found = seen_after_moving(device, scene, "phenomenological", [way])
    there = replace(scene, camera=way)
    expected = render(device, there, "phenomenological", size=SIZE, settings=COARSE)
    assert np.ptp(expected) > 0.2
    assert (abs(found - expected).max(axis=-1) > 0.01).mean() < 0.01


def test_an_orthographic_camera_moves(device: Device) -> None:
    scene = collection().build_scene("glass_bars[detail=0.2]").from_view("plan")
    way = replace(scene.camera, position=(0.5, 0.2, 4.0), height=2.0)
    found = seen_after_moving(device, scene, "sorted_over", [way])
    expected = render(device, replace(scene, camera=way), "sorted_over", size=SIZE)
    assert (abs(found - expected).max(axis=-1) > 0.01).mean() < 0.01
