"""The hierarchy of nodes: transforms, mirroring, instances, cameras and lights."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from oitbench.errors import SceneError
from oitbench.scene import DirectionalLight, SpotLight
from tests import meshes
from tests.importing.files import Gltf, close, cube

HALF = math.sqrt(0.5)


def test_transforms_of_nodes_are_combined(tmp_path: Path) -> None:
    gltf = Gltf()
    child = gltf.triangle()
    # Scale first, then a quarter turn about y, then translation.
    gltf.document["nodes"][child] |= {
        "scale": [2, 3, 1], "rotation": [0, HALF, 0, HALF], "translation": [10, 0, 0],
    }  # fmt: skip
    matrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1]
    gltf.add("nodes", {"children": [child], "matrix": matrix})
    positions = gltf.one(tmp_path).mesh.positions
    close(positions, [[10, 0, 5], [10, 0, 3], [10, 3, 5]], atol=1e-6)


def test_a_mirroring_transform_keeps_the_front(tmp_path: Path) -> None:
    gltf = Gltf()
    corners, triangles = cube()
    normals = corners / np.linalg.norm(corners, axis=1, keepdims=True)
    attributes = {"POSITION": gltf.array(corners), "NORMAL": gltf.array(normals)}
    mesh = gltf.mesh(attributes, gltf.array(triangles.ravel(), "uint8"))
    gltf.add("nodes", {"mesh": mesh, "scale": [-1, 2, 1]})
    mirrored = gltf.one(tmp_path).mesh
    assert meshes.signed_volume(mirrored) == pytest.approx(2)
    assert (meshes.agreement(mirrored) > 0).all()
    assert meshes.has_unit_normals(mirrored)


def test_normals_follow_a_stretched_surface(tmp_path: Path) -> None:
    gltf = Gltf()
    slope = gltf.array([[0, 0, 0], [1, 1, 0], [0, 0, 1]])
    normal = gltf.array([[HALF, -HALF, 0]] * 3)
    mesh = gltf.mesh({"POSITION": slope, "NORMAL": normal})
    gltf.add("nodes", {"mesh": mesh, "scale": [1, 3, 1]})
    expected = np.array([3, -1, 0]) / math.sqrt(10)
    found = gltf.one(tmp_path).mesh.normals
    close(found, np.tile(expected, (3, 1)), atol=1e-6)


def test_missing_normals_are_flat_and_broken_ones_are_replaced(tmp_path: Path) -> None:
    gltf = Gltf()
    gltf.triangle()
    assert gltf.one(tmp_path).mesh.normals is None
    gltf = Gltf()
    gltf.triangle(NORMAL=gltf.array([[0, 0, 0], [0, 2, 0], [0, 0, 1]]))
    close(gltf.one(tmp_path).mesh.normals, [[0, 0, 1], [0, 1, 0], [0, 0, 1]])


def test_instances_are_one_object(tmp_path: Path) -> None:
    gltf = Gltf()
    node = gltf.triangle()
    attributes = {
        "TRANSLATION": gltf.array([[0, 0, 0], [5, 0, 0]]),
        "SCALE": gltf.array([[1, 1, 1], [2, 2, 2]]),
        "ROTATION": gltf.array([[0, 0, 0, 127], [0, 0, 127, 0]], "int8", normalized=True),
    }
    extension = {"EXT_mesh_gpu_instancing": {"attributes": attributes}}
    gltf.document["nodes"][node] |= {"extensions": extension, "translation": [0, 0, 1]}
    mesh = gltf.one(tmp_path).mesh
    expected = [[0, 0, 1], [1, 0, 1], [0, 1, 1], [5, 0, 1], [3, 0, 1], [5, -2, 1]]
    close(mesh.positions, expected, atol=1e-6)
    np.testing.assert_array_equal(mesh.triangles, [[0, 1, 2], [3, 4, 5]])


@pytest.mark.parametrize(
    "children", [{0: [0]}, {0: [1], 1: [0]}, {0: [2], 1: [2]}], ids=["self", "cycle", "shared"]
)
def test_a_node_has_one_parent(children: dict[int, list[int]], tmp_path: Path) -> None:
    gltf = Gltf()
    for _ in range(3):
        gltf.triangle()
    for parent, found in children.items():
        gltf.document["nodes"][parent]["children"] = found
    gltf.document["scenes"] = [{"nodes": [0, 1]}]
    with pytest.raises(SceneError, match="has two parents, or is its own ancestor"):
        gltf.read(tmp_path)


def test_a_deep_hierarchy_is_no_recursion(tmp_path: Path) -> None:
    gltf = Gltf()
    gltf.triangle()
    for number in range(1500):
        gltf.add("nodes", {"children": [number], "translation": [0, 0, 1]})
    assert gltf.one(tmp_path).mesh.positions[0, 2] == 1500


def test_names_of_objects_are_unique_and_printable(tmp_path: Path) -> None:
    gltf = Gltf()
    for name in ("a", "a", "", "b\nc", "a 2"):
        gltf.document["nodes"][gltf.triangle()]["name"] = name
    names = [item.name for item in gltf.read(tmp_path).scene.objects]
    assert names == ["a", "a 2", "node 2", "b c", "a 2 2"]


def camera(gltf: Gltf, lens: dict[str, Any], **place: Any) -> None:
    number = gltf.add("cameras", lens)
    gltf.add("nodes", {"camera": number, **place})


def test_cameras_become_views(tmp_path: Path) -> None:
    gltf = Gltf()
    gltf.triangle()
    lens = {"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.2, "zfar": 50}}
    camera(gltf, lens, name="front", translation=[0.5, 0.5, 4])
    parallel = {
        "type": "orthographic",
        "orthographic": {"xmag": 3, "ymag": 2, "znear": 0.1, "zfar": 9},
    }
    camera(gltf, parallel, name="main", translation=[4, 0, 0], rotation=[0, HALF, 0, HALF])
    camera(gltf, lens, name="3D ", translation=[0, 0, 9])
    scene = gltf.read(tmp_path).scene
    assert list(scene.views) == ["front", "main_2", "camera_3d", "frame"]
    assert scene.camera is scene.views["front"]
    assert (scene.camera.fov_y, scene.camera.near, scene.camera.far) == (0.5, 0.2, math.inf)
    close(scene.camera.target, (0.5, 0.5, 0))
    side = scene.views["main_2"]
    assert side.height == 4
    close(side.axes, [[0, 0, -1], [0, 1, 0], [1, 0, 0]], atol=1e-12)


def test_many_cameras_and_lights_are_refused(tmp_path: Path) -> None:
    lens = {"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.2}}
    gltf = Gltf()
    gltf.triangle()
    for _ in range(257):
        camera(gltf, lens, name="same")
    with pytest.raises(SceneError, match="more than 256 cameras"):
        gltf.read(tmp_path)
    gltf = Gltf()
    gltf.triangle()
    for _ in range(65):
        lit(gltf, {"type": "point"})
    with pytest.raises(SceneError, match="more than 64 lights"):
        gltf.read(tmp_path)


def lit(gltf: Gltf, light: dict[str, Any], **place: Any) -> None:
    extensions = gltf.document.setdefault("extensions", {"KHR_lights_punctual": {"lights": []}})
    extensions["KHR_lights_punctual"]["lights"].append(light)
    number = len(extensions["KHR_lights_punctual"]["lights"]) - 1
    gltf.add("nodes", {"extensions": {"KHR_lights_punctual": {"light": number}}, **place})


def test_lights_of_a_file(tmp_path: Path) -> None:
    gltf = Gltf()
    gltf.triangle()
    lit(gltf, {"type": "directional", "intensity": 3, "color": [1, 0.5, 0]})
    spot = {"innerConeAngle": 0.27, "outerConeAngle": 0.3}
    lit(gltf, {"type": "spot", "intensity": 7, "spot": spot}, translation=[0, 0, 4])
    found = gltf.read(tmp_path, light="auto")
    sun, lamp = found.scene.beams
    assert isinstance(sun, DirectionalLight)
    assert isinstance(lamp, SpotLight)
    assert (sun.direction, sun.irradiance) == ((0, 0, -1), (3, 1.5, 0))
    assert (lamp.position, lamp.target, lamp.intensity) == ((0, 0, 4), (0, 0, 3), (7, 7, 7))
    assert lamp.angle == pytest.approx(0.6)
    assert found.scene.exposure == 0
    assert found.notes == ()
    assert gltf.read(tmp_path, light="none").scene.beams == ()
    assert gltf.read(tmp_path, light="sun").scene.beams != found.scene.beams


def test_a_light_to_all_sides_reaches_all_of_the_scene(tmp_path: Path) -> None:
    gltf = Gltf()
    gltf.triangle()
    lit(gltf, {"type": "point", "intensity": 40}, translation=[0.5, 0.5, 6])
    (lamp,) = gltf.read(tmp_path, light="file").scene.beams
    assert isinstance(lamp, SpotLight)
    toward = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]]) - lamp.position
    axis = np.subtract(lamp.target, lamp.position)
    cosines = toward @ axis / np.linalg.norm(toward, axis=1) / np.linalg.norm(axis)
    # It is as bright there as in the middle.
    assert np.arccos(cosines).max() < 0.9 * lamp.angle / 2
    gltf.document["nodes"][-1]["translation"] = [0.3, 0.3, 0.01]
    found = gltf.read(tmp_path, light="file")
    assert len(found.scene.beams) == 2
    assert "lights to all sides" in found.notes[0]


def test_the_exposure_suits_lights_in_lux(tmp_path: Path) -> None:
    gltf = Gltf()
    gltf.triangle()
    lit(gltf, {"type": "directional", "intensity": 100_000})
    scene = gltf.read(tmp_path, light="file", environment="auto").scene
    assert 0.25 <= 100_000 / math.pi * 2**scene.exposure <= 1
    assert scene.environment is not None
    assert 0.2 < scene.environment.texels.max() * 2**scene.exposure < 1
    brighter = gltf.read(tmp_path, light="file", exposure=1.5).scene
    assert brighter.exposure == scene.exposure + 1.5
