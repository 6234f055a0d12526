"""Scenes that were built in Python, as files."""

from __future__ import annotations

import math
import zipfile
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from oitbench.errors import SceneError
from oitbench.fingerprints.scene import scene_fingerprint
from oitbench.importing.written import encode_scene, read_written
from oitbench.scene import Camera, Mesh, Object, Scene, Texture, Wrap
from oitbench.stability.layers import random_lists, scene_of
from tests.damage import cut, flip_bit
from tests.helpers import collection

# Together they have every class and kind of value of a scene.
SCENES = (
    "bottles[detail=0.05]", "hair[detail=0.01]", "smoke_ball[detail=0.1]", "tumblers[detail=0.1]",
    "atrium_fog[detail=0.1]", "foliage[detail=0.05,light=sky]", "courtyard[detail=0.1]",
)  # fmt: skip


def write(scene: Scene, folder: Path) -> Path:
    path = folder / "mine.npz"
    path.write_bytes(encode_scene(scene))
    return path


def rewrite(path: Path, change: Any) -> None:
    """Change the JSON of a file, or an array of it."""
    with np.load(path) as file:
        members = dict(file)
    content = msgspec.json.decode(members["scene"].tobytes())
    change(content, members)
    members["scene"] = np.frombuffer(msgspec.json.encode(content), np.uint8)
    np.savez(path, **members)


@pytest.mark.parametrize("label", SCENES)
def test_a_file_gives_the_same_scene(label: str, tmp_path: Path) -> None:
    scene = collection().build_scene(label)
    found = read_written(write(scene, tmp_path), "mine")
    assert found.name == "mine"
    assert scene_fingerprint(found) == scene_fingerprint(scene)
    assert (found.view_names, len(found.path)) == (scene.view_names, len(scene.path))
    assert found.full_samples == scene.full_samples
    for one, other in zip(found.objects, scene.objects, strict=True):
        assert one.name == other.name
        assert type(one.mesh) is type(other.mesh)
        np.testing.assert_array_equal(one.mesh.positions, other.mesh.positions)
    for view in scene.views:
        assert found.views[view] == scene.views[view]


def test_fragment_lists_are_kept(tmp_path: Path) -> None:
    scene = scene_of(random_lists(3))
    found = read_written(write(scene, tmp_path), scene.name)
    assert scene_fingerprint(found) == scene_fingerprint(scene)


def test_equal_scenes_have_equal_files_and_share_what_objects_share(tmp_path: Path) -> None:
    mesh = Mesh.from_arrays([(0, 0, -2), (1, 0, -2), (0, 1, -2)], [(0, 1, 2)], uvs=np.zeros((3, 2)))
    tiles = Texture(np.ones((2, 2), np.float32), (Wrap.MIRROR, Wrap.REPEAT))
    scene = collection().build_scene("layer_stack")
    material = replace(scene.objects[0].material, coverage=tiles)
    objects = tuple(Object(name, mesh, material) for name in ("a", "b"))
    made = Scene("two", Camera((0, 0, 0), (0, 0, -1), far=math.inf), objects)
    assert encode_scene(made) == encode_scene(replace(made))
    found = read_written(write(made, tmp_path), "two")
    assert found.objects[0].mesh is found.objects[1].mesh
    assert found.objects[0].material is found.objects[1].material
    coverage = found.objects[0].material.coverage
    assert isinstance(coverage, Texture)
    assert coverage.wrap == (Wrap.MIRROR, Wrap.REPEAT)
    assert found.camera.far == math.inf


class Foreign(Mesh):
    """A mesh of a class that only its author has."""


def test_what_no_file_can_hold_is_refused() -> None:
    scene = collection().build_scene("layer_stack")
    item = scene.objects[0]
    mesh = Foreign(item.mesh.positions, item.mesh.triangles)
    with pytest.raises(SceneError, match="it holds a Foreign, which no file can hold; use classes"):
        encode_scene(replace(scene, objects=(replace(item, mesh=mesh),)))


def test_damaged_files_are_refused(tmp_path: Path) -> None:
    path = write(collection().build_scene("layer_stack"), tmp_path)
    whole = path.read_bytes()
    for number in range(0, 8 * len(whole), 8 * len(whole) // 60 + 1):
        flip_bit(path, number)
        # A bit of a value or of padding may give another scene; nothing else may be raised.
        with suppress(SceneError):
            assert isinstance(read_written(path, "mine"), Scene)
        path.write_bytes(whole)
    cut(path, 30)
    with pytest.raises(SceneError, match=r"is damaged \(.*\); write it again"):
        read_written(path, "mine")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda content, members: content.update(version=2), "of version 2, not 1"),
        (
            lambda content, members: content["parts"].pop(),
            r"holds a \w+, not a scene",
        ),
        (lambda content, members: content["parts"][0].update(kind="open"), "'open'"),
        (lambda content, members: content["parts"][0]["fields"].update(x=1), "has no x"),
        (lambda content, members: members.pop("0"), "0"),
        (lambda content, members: content["parts"][-1]["fields"].update(exposure="+"), "damaged"),
        (lambda content, members: content["parts"][-1]["fields"].update(exposure=500), "exposure"),
        (
            lambda content, members: content["parts"][-1]["fields"].update(lights={"code": "1"}),
            "a value of the kind code",
        ),
    ],
)
def test_wrong_content_is_refused(change: Any, message: str, tmp_path: Path) -> None:
    path = write(collection().build_scene("layer_stack"), tmp_path)
    rewrite(path, change)
    with pytest.raises(SceneError, match=message):
        read_written(path, "mine")


def test_code_in_a_file_is_not_run(tmp_path: Path) -> None:
    class Trap:
        def __reduce__(self) -> Any:
            return open, (str(tmp_path / "ran"), "w")

    path = write(collection().build_scene("layer_stack"), tmp_path)
    members = {"scene": np.array([Trap()], dtype=object)}
    np.savez(path, **members)  # type: ignore[arg-type]
    with pytest.raises(SceneError, match="is damaged"):
        read_written(path, "mine")
    assert not (tmp_path / "ran").exists()
    with zipfile.ZipFile(path, "w"):
        pass
    with pytest.raises(SceneError, match="is damaged"):
        read_written(path, "mine")
