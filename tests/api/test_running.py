"""Runs and pictures of scenes that were built in Python."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import oitbench
from oitbench.errors import SceneError, StorageError, UsageError
from oitbench.gl.device import Device
from oitbench.modeling.mesh import quad
from oitbench.results.store import SCENES
from oitbench.scene import Camera, Material, Object, Scene
from oitbench.truths import MATCHED
from tests import helpers
from tests.cli.conftest import call as call
from tests.cli.helpers import Call

SIZE = (16, 16)


def panes(name: str = "my panes", alpha: float = 0.5) -> Scene:
    """Return three panes that overlap."""
    objects = [
        Object(
            f"pane {number}",
            quad((0.2 * number, 0, -2 - number), (0.9, 0, 0), (0, 0.9, 0)),
            Material(coverage=alpha, emission=(0.5, 0.3, 0.2 * number)),
        )
        for number in range(3)
    ]
    return Scene(name, Camera((0, 0, 0), (0, 0, -1)), tuple(objects), background=(0.8, 0.8, 0.8))


def test_a_scene_is_rendered_as_in_this_process(device: Device) -> None:
    image, exposure = oitbench.render(replace(panes(), exposure=1.5), "a_buffer", SIZE, ssaa=1)
    assert exposure == 1.5
    expected = helpers.render(device, panes(), "a_buffer", size=SIZE)
    np.testing.assert_array_equal(image, expected)


def test_a_scene_is_run_and_the_folder_repeats_it(call: Call, tmp_path: Path) -> None:
    out = tmp_path / "out"
    scenes = [panes(), "layer_stack[count=4]"]
    options = {"size": SIZE, "ssaa": 1, "truths": [MATCHED], "preset": "guard", "out": out}
    outcome = oitbench.run(scenes, ["alpha_blend"], **options)  # type: ignore[arg-type]
    assert outcome.exit_code == 0
    assert "2 ok" in str(outcome)
    assert outcome.scenes == ("my panes", "layer_stack[count=4]")
    image, _ = oitbench.render(panes(), "alpha_blend", SIZE, ssaa=1)
    np.testing.assert_array_equal(outcome.image("my panes", "alpha_blend"), image)
    assert outcome.truth("my panes", MATCHED).shape == (16, 16, 3)
    # The same scene is kept, and another one of that name is run again.
    again = oitbench.run(scenes, ["alpha_blend"], **options)  # type: ignore[arg-type]
    assert again.summary is not None
    assert again.summary.kept == 2
    answer = call("run", "--config", out / "run.toml")
    assert answer.code == 0, answer
    assert "nothing to do; 2 kept" in answer.out
    other = oitbench.run([panes(alpha=0.6)], ["alpha_blend"], **options)  # type: ignore[arg-type]
    assert other.summary is not None
    assert (other.summary.kept, len(other.records)) == (0, 1)
    assert len(oitbench.open(out).records) == 2
    assert len(list((out / SCENES).iterdir())) == 2


def test_a_failure_of_this_run_is_not_hidden_by_an_earlier_result(tmp_path: Path) -> None:
    method = helpers.write_method(tmp_path / "mine", "()", '{"color": Target("rgba32f")}')
    options = {"size": SIZE, "ssaa": 1, "preset": "guard", "out": tmp_path / "out"}
    assert oitbench.run(["layer_stack"], [str(method)], **options).exit_code == 0  # type: ignore[arg-type]
    (method / "method.py").write_text("this is no Python\n")
    outcome = oitbench.run(["layer_stack"], [str(method)], **options)  # type: ignore[arg-type]
    assert [cell.status for cell in outcome.records] == ["failed"]
    assert (outcome.exit_code, outcome.troubled) == (1, outcome.records)
    assert "SyntaxError" in outcome.table().reason[0]


@pytest.mark.parametrize("name", ["", "a[b]", "a/b", "a,b", "a=b", "a@b", " a", "a\nb"])
def test_names_that_no_scene_can_have_are_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="a scene from Python cannot have the name"):
        oitbench.run([panes(name)], ["alpha_blend"], out=tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_the_name_of_another_scene_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"two scenes are named 'layer_stack': .*; rename one"):
        oitbench.render(panes("layer_stack"), "alpha_blend", SIZE)


def test_a_folder_of_something_else_stays_as_it_is(tmp_path: Path) -> None:
    (tmp_path / "letter.txt").write_text("dear")
    with pytest.raises(UsageError, match=r"holds something else \(letter.txt\)"):
        oitbench.run([panes()], ["alpha_blend"], out=tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["letter.txt"]
    with pytest.raises((StorageError, UsageError), match=r"letter\.txt"):
        oitbench.run([panes()], ["alpha_blend"], out=tmp_path / "letter.txt")


def test_a_scene_that_no_file_can_hold_is_refused(tmp_path: Path) -> None:
    scene = panes()
    object.__setattr__(scene, "background", {1, 2})
    with pytest.raises(SceneError, match="it holds a set, which no file can hold"):
        oitbench.run([scene], ["alpha_blend"], out=tmp_path)
