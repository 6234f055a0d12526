"""What is added to files that lack a camera, lights or a ground."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from oitbench.importing import read_scene
from oitbench.importing.framing import frame
from oitbench.scene import Camera, DirectionalLight, Floats
from tests.importing.files import Gltf, cube, write

SHAPES = [(1, 1, 1), (10, 0.1, 0.1), (0.1, 10, 0.1), (1e-3, 1e-3, 2e-3), (5e4, 0, 5e4)]


def seen(camera: Camera, points: Floats) -> Floats:
    """Return the places of points in a square picture, from −1 to 1."""
    offset = points - np.asarray(camera.position)
    depth = camera.view_distance(points)
    assert (depth > camera.near).all()
    places = np.stack([offset @ axis for axis in camera.axes[:2]], axis=1)
    return np.asarray(places / depth[:, None] / np.tan(camera.fov_y / 2))


@pytest.mark.parametrize("size", SHAPES)
def test_the_camera_shows_everything_and_little_else(size: tuple[float, ...]) -> None:
    corners = cube()[0] * size + [100, 0, -3]
    places = seen(frame(corners.min(axis=0), corners.max(axis=0)), corners)
    assert np.abs(places).max() <= 1
    assert np.abs(places).max() > 0.75


def cubes(*heights: float, floor: float | None = None) -> str:
    """Return a file of cubes at some heights, and of a square floor."""
    lines, count = [], 0
    for height in heights:
        corners, triangles = cube()
        lines += [f"v {x} {y + height} {z}" for x, y, z in corners.tolist()]
        lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in (triangles + count).tolist()]
        count += 8
    if floor is not None:
        lines += [f"v {x} {floor} {z}" for x, z in ((-1, -1), (-1, 1), (1, 1), (1, -1))]
        lines.append("f -4 -3 -2 -1")
    return "\n".join(lines)


@pytest.mark.parametrize(
    ("text", "added"),
    [
        (cubes(0), True),
        (cubes(0, floor=-0.5), False),
        (cubes(0, floor=-0.501), False),
        (cubes(0, floor=0.5), True),
        (cubes(0, 3, floor=1), True),
    ],
    ids=["cube", "on a floor", "near a floor", "below", "between"],
)
def test_a_ground_is_added_where_there_is_none(text: str, added: bool, tmp_path: Path) -> None:
    path = write(tmp_path, "model.obj", text)
    objects = read_scene(path).scene.objects
    assert (objects[-1].name == "ground") == added
    if added:
        assert not objects[-1].casts
        top = objects[-1].mesh.positions[:, 1].max()
        lowest = min(item.mesh.positions[:, 1].min() for item in objects[:-1])
        assert lowest - 0.05 < top < lowest
    for choice in ("yes", "no"):
        names = [item.name for item in read_scene(path, ground=choice).scene.objects]
        assert ("ground" in names) == (choice == "yes")


def test_lights_and_a_sky_are_added(tmp_path: Path) -> None:
    path = write(tmp_path, "model.obj", cubes(0))
    scene = read_scene(path).scene
    (sun,) = scene.beams
    assert isinstance(sun, DirectionalLight)
    assert scene.environment is not None
    assert read_scene(path, environment="none").scene.environment is None
    assert read_scene(path, light="file").scene.beams == ()


def test_a_far_plane_is_kept_only_if_it_hides_something(tmp_path: Path) -> None:
    for far, kept in ((3.5, True), (500, False)):
        gltf = Gltf()
        gltf.triangle()
        lens = {"yfov": 0.5, "znear": 0.1, "zfar": far}
        number = gltf.add("cameras", {"type": "perspective", "perspective": lens})
        gltf.add("nodes", {"camera": number, "translation": [0, 0, 4]})
        assert np.isfinite(gltf.read(tmp_path).scene.camera.far) == kept
