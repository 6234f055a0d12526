"""`oitbench motion` from the command line to its files."""

from __future__ import annotations

from pathlib import Path

import pytest

from oitbench.errors import SceneError, UsageError
from oitbench.image import stored
from oitbench.motion import record
from oitbench.motion.record import JSON
from oitbench.motion.run import film
from tests.cli.conftest import call
from tests.cli.helpers import Call
from tests.helpers import write_method

__all__ = ["call"]

SMALL = ("--frames", "3", "--size", "16x16", "--ssaa", "1", "--turns", "0.01")


def test_methods_are_filmed_and_those_that_fail_are_named(
    call: Call, tmp_path: Path, plugins: Path
) -> None:
    methods = ("--method", "weighted_blended", "--method", "stochastic", "--method", "broken")
    answer = call(
        "motion", "layer_stack[count=2]", *methods, "--method", "demanding", *SMALL,
        "--collection", plugins, "--out", tmp_path / "out",
    )  # fmt: skip
    assert answer.code == 1
    assert "failed broken:" in answer.err
    assert "failed demanding:" in answer.err
    found = record.read(tmp_path / "out" / JSON)
    assert [track.label for track in found.tracks] == [
        "weighted_blended",
        "stochastic, seeds fixed",
        "stochastic, seeds per frame",
    ]
    assert found.scene == "layer_stack[count=2]"
    assert len(found.path) == len(found.exact) == 3
    for image in (*found.exact, *found.tracks[2].frames):
        stored.verify(tmp_path / "out", image)
    assert sorted(found.failed) == ["broken", "demanding"]
    lines = answer.out.splitlines()
    assert [line.split(" | ")[0] for line in lines[2:5]] == ["| weighted_blended"] + [
        "| stochastic"
    ] * 2
    for line in lines[5:]:
        assert Path(line).is_file()
    assert len(lines) == 5 + 2 + 3


def test_a_method_that_ends_the_process_costs_only_itself(tmp_path: Path) -> None:
    write_method(tmp_path / "methods" / "leaving", "__import__('os')._exit(3)")
    found = film(
        "layer_stack[count=1]", ["leaving", "alpha_blend"], tmp_path / "out", frames=2, size=(8, 8),
        ssaa=1, collections=[tmp_path],
    )  # fmt: skip
    assert [track.method for track in found.tracks] == ["alpha_blend"]
    assert "ended with code 3" in found.failed["leaving"]


def test_pixels_that_are_not_finite_have_no_flip_and_count_as_black(
    tmp_path: Path, plugins: Path
) -> None:
    found = film(
        "layer_stack[count=1]", ["unstable"], tmp_path, frames=2, size=(8, 8), ssaa=1,
        collections=[plugins],
    )  # fmt: skip
    assert found.tracks[0].flip == [None, None]
    assert found.tracks[0].largest[0] < 1


def test_fragment_lists_cannot_be_filmed(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="no camera that could move"):
        film("fragment_lists", ["alpha_blend"], tmp_path, frames=2, size=(8, 8))


def test_one_scene_is_filmed(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="selects 2 scenes"):
        film("layer_stack[count=1,2]", ["alpha_blend"], tmp_path)
