"""The option --view, and views in lists."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from oitbench.image.files import read_exr
from tests.cli.helpers import SMALL, Call


def test_several_views_are_several_files(call: Call, tmp_path: Path) -> None:
    out = tmp_path / "bars.exr"
    answer = call("render", "glass_bars", "a_buffer", "--view", "plan,main", "-o", out, *SMALL)
    assert answer.code == 0, answer
    # The main view of several has no name of its own.
    assert {path.name for path in tmp_path.iterdir()} == {"bars.exr", "bars@plan.exr"}
    one = tmp_path / "one.exr"
    assert call("render", "glass_bars", "a_buffer", "--view", "plan", "-o", one, *SMALL).code == 0
    np.testing.assert_array_equal(read_exr(one), read_exr(tmp_path / "bars@plan.exr"))
    assert np.abs(read_exr(one) - read_exr(out)).max() > 0.01


def test_wrong_views_are_refused(call: Call, tmp_path: Path) -> None:
    render = ("render", "glass_bars", "a_buffer", "-o", tmp_path / "x.exr", *SMALL)
    call(*render, "--view", "plam").assert_refused("did you mean plan?")
    call(*render, "--view", "A").assert_refused("cannot read view 'A'")


def test_scenes_are_listed_with_their_views(call: Call) -> None:
    listed = {entry["name"]: entry for entry in json.loads(call("list", "scenes", "--json").out)}
    assert listed["glass_bars"]["views"] == ["main", "plan", "left", "right"]
    assert listed["fragment_lists"]["views"] == ["main"]


def test_references_of_a_view_are_rendered_and_checked(call: Call, tmp_path: Path) -> None:
    (tmp_path / "scenes").mkdir()
    source = Path(__file__).parents[2] / "scenes" / "glass_bars.py"
    (tmp_path / "scenes" / "bars.py").write_text(source.read_text())
    collection = ("--collection", tmp_path, "--size", "8x8", "--ssaa", "1")
    view = ("--truth", "matched", "--view", "plan")
    answer = call("reference", "bars", *view, *collection)
    assert answer.code == 0, answer
    assert "bars@plan@8x8.matched" in answer.out
    again = call("reference", "bars", "--check", *collection)
    assert again.code == 0, again
    assert "passed   bars@plan@8x8.matched" in again.out
