"""`oitbench reference`: rendering and checking a reference."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from oitbench.path_traced.references import storage
from oitbench.path_traced.references.wanted import PART_SSAA, REFRACTED_SSAA
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
    film = Object("film", mesh, Material(coverage, (1.0, 0.5, 0.25), emission=(1.0, 0.5, 0.25)))
    return Scene(name, Camera((0.0, 0.0, 4.0)), (film,), background=(0.1, 0.2, 0.3))
'''
FULL = ("--truth", "full")
KEY = "pane@12x8.full"


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
    answer = call("reference", "pane", *FULL, "--size", "12x8", "--collection", folder)
    assert answer.code == 0, answer
    references = folder / storage.FOLDER
    assert storage.read_manifest(references).keys() == {KEY}
    answer = call(*check)
    assert (answer.code, "passed" in answer.out) == (0, True), answer
    reference = storage.read(references, KEY)
    assert reference is not None
    changed = dataclasses.replace(reference, parts=(reference.mean * np.float32(1.1),))
    storage.save(references, changed)
    assert len(list(references.glob(f"{KEY}.mean-*.exr"))) == 1
    answer = call(*check)
    assert (answer.code, "failed" in answer.out) == (1, True), answer
    scene = folder / "scenes" / "pane.py"
    scene.write_text(SCENE.replace("(0.1, 0.2, 0.3)", "(0.9, 0.2, 0.3)"))
    answer = call(*check)
    assert (answer.code, f"{KEY}: the scene has changed" in answer.out) == (1, True), answer


@needs_mitsuba
def test_a_stale_reference_is_adopted_if_its_picture_is_still_right(
    call: Call, folder: Path, tmp_path: Path
) -> None:
    arguments = ("reference", "--collection", folder, "-o", tmp_path / "failures", "pane")
    answer = call("reference", "pane", *FULL, "--size", "12x8", "--collection", folder)
    assert answer.code == 0, answer
    path = folder / "scenes" / "pane.py"
    # What lies behind the camera changes the scene, but not its picture.
    path.write_text(SCENE.replace("(0.0, 0.0, 4.0)", "(0.0, 0.0, 4.0), far=50.0"))
    assert call(*arguments, "--check").code == 1
    answer = call(*arguments, "--check", "--adopt")
    assert (answer.code, f"adopted  {KEY}" in answer.out) == (0, True), answer
    answer = call(*arguments, "--check")
    assert (answer.code, "passed" in answer.out) == (0, True), answer
    path.write_text(SCENE.replace("(0.1, 0.2, 0.3)", "(0.9, 0.2, 0.3)"))
    answer = call(*arguments, "--check", "--adopt")
    assert (answer.code, "failed" in answer.out) == (1, True), answer
    answer = call(*arguments, "--check")
    assert (answer.code, "the scene has changed" in answer.out) == (1, True), answer


@needs_mitsuba
def test_matched_references_are_rendered_without_effects_and_checked(
    call: Call, folder: Path, tmp_path: Path
) -> None:
    place = ("--collection", folder)
    answer = call("reference", "pane", "--size", "12x8", *place)
    assert answer.code == 0, answer
    answer = call(
        "reference", "pane", "--truth", "matched", "--effects=-colored_transmission",
        "--size", "6x4", *place,
    )  # fmt: skip
    assert answer.code == 0, answer
    infos = storage.read_manifest(folder / storage.FOLDER)
    assert infos.keys() == {KEY, "pane@12x8.matched", "pane@6x4.matched-colored_transmission"}
    last = infos["pane@6x4.matched-colored_transmission"].rendering
    assert (last.effects, last.left_out, last.parts) == (["COVERAGE"], ["COLORED_TRANSMISSION"], 1)
    answer = call("reference", "--check", "pane", "-o", tmp_path / "failures", *place)
    assert (answer.code, answer.out.count("passed")) == (0, 3), answer
    # The sub-pixel grid and the effects are those that are stored.
    assert call("reference", "pane", *place).code == 0
    assert storage.read_manifest(folder / storage.FOLDER).keys() == infos.keys()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("pain",), "'pain'; did you mean pane"),
        (("pane", "--size", "12"), "'12'"),
        (("pane", "--check", *FULL, "--size", "3x3"), "pane"),
        (
            ("pane", "--check", "--dask", "tcp://a:1"),
            "--check uses files of this machine; leave out",
        ),
        (("pane", "--adopt"), "--adopt needs --check"),
        (("pane", "--effects=-refraction"), "--effects needs --truth matched"),
        (("pane", "--truth", "matched", "--effects=-fog"), "unknown effect 'fog'"),
        (("pane", "--truth", "exact"), "exact"),
    ],
)
def test_wrong_input_is_refused(
    call: Call, folder: Path, arguments: tuple[str, ...], message: str
) -> None:
    call("reference", "--collection", folder, *arguments).assert_refused(message)


def test_help_states_the_defaults(call: Call) -> None:
    text = " ".join(call("reference", "--help").out.split())
    assert f"takes at least {REFRACTED_SSAA}, or {PART_SSAA} for each part of a random" in text
    assert "Repeatable. [default: as stored, else main]" in text
