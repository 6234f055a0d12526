"""`oitbench reference`: rendering and checking a reference."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from oitbench.path_traced.references import storage
from tests.cli.helpers import Call
from tests.path_traced.agreement import needs_mitsuba

SCENE = '''"""A film over a background."""
import numpy as np
from oitbench.scene import Camera, Material, Mesh, Object, Scene
from oitbench.parameters import Parameter

parameters = {"coverage": Parameter(0.5)}


def build(*, name: str, coverage: float) -> Scene:
    corners = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0)], dtype=np.float32)
    mesh = Mesh(corners, np.array([(0, 1, 2)], dtype=np.uint32))
    film = Object("film", mesh, Material(coverage, emission=(1.0, 0.5, 0.25)))
    return Scene(name, Camera((0.0, 0.0, 4.0)), (film,), background=(0.1, 0.2, 0.3))
'''
SIZE = (12, 8)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A collection with one scene, `pane`."""
    (tmp_path / "mine" / "scenes").mkdir(parents=True)
    (tmp_path / "mine" / "scenes" / "pane.py").write_text(SCENE)
    return tmp_path / "mine"


@needs_mitsuba
def test_a_check_passes_until_the_reference_or_the_scene_changes(
    call: Call, folder: Path, tmp_path: Path
) -> None:
    check = ("reference", "--collection", folder, "-o", tmp_path / "failures", "--check", "pane")
    answer = call("reference", "pane", "--size", "12x8", "--collection", folder)
    assert answer.code == 0, answer
    references = folder / storage.FOLDER
    assert storage.read_manifest(references).keys() == {"pane@12x8"}
    answer = call(*check)
    assert (answer.code, "passed" in answer.out) == (0, True), answer
    reference = storage.read(references, "pane", SIZE)
    assert reference is not None
    changed = dataclasses.replace(reference, mean=reference.mean * np.float32(1.1))
    storage.save(references, changed)
    assert len(list(references.glob("pane@12x8.mean-*.exr"))) == 1
    answer = call(*check)
    assert (answer.code, "failed" in answer.out) == (1, True), answer
    scene = folder / "scenes" / "pane.py"
    scene.write_text(SCENE.replace("(0.1, 0.2, 0.3)", "(0.9, 0.2, 0.3)"))
    answer = call(*check)
    assert (answer.code, "pane@12x8: the scene has changed" in answer.out) == (1, True), answer


@needs_mitsuba
def test_a_stale_reference_is_adopted_if_its_picture_is_still_right(
    call: Call, folder: Path, tmp_path: Path
) -> None:
    arguments = ("reference", "--collection", folder, "-o", tmp_path / "failures", "pane")
    answer = call("reference", "pane", "--size", "12x8", "--collection", folder)
    assert answer.code == 0, answer
    path = folder / "scenes" / "pane.py"
    # What lies behind the camera changes the scene, but not its picture.
    path.write_text(SCENE.replace("(0.0, 0.0, 4.0)", "(0.0, 0.0, 4.0), far=50.0"))
    assert call(*arguments, "--check").code == 1
    answer = call(*arguments, "--check", "--adopt")
    assert (answer.code, "adopted  pane@12x8" in answer.out) == (0, True), answer
    answer = call(*arguments, "--check")
    assert (answer.code, "passed" in answer.out) == (0, True), answer
    path.write_text(SCENE.replace("(0.1, 0.2, 0.3)", "(0.9, 0.2, 0.3)"))
    answer = call(*arguments, "--check", "--adopt")
    assert (answer.code, "failed" in answer.out) == (1, True), answer
    answer = call(*arguments, "--check")
    assert (answer.code, "the scene has changed" in answer.out) == (1, True), answer


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("pain",), "'pain'; did you mean pane"),
        (("pane", "--size", "12"), "'12'"),
        (("pane", "--check", "--size", "3x3"), "pane"),
        (("pane", "--adopt"), "--adopt needs --check"),
    ],
)
def test_wrong_input_is_refused(
    call: Call, folder: Path, arguments: tuple[str, ...], message: str
) -> None:
    call("reference", "--collection", folder, *arguments).assert_refused(message)
