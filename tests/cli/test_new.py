"""`oitbench new`: the plugins that it writes work as they are."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest

from oitbench.plugins import Collection
from oitbench.report import Table
from tests.cli.helpers import SMALL, Call
from tests.report.made_up import context, finished


def test_a_new_method_can_be_rendered_and_keeps_its_promises(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    answer = call("new", "method", "my_average")
    assert answer.code == 0
    written = answer.out.splitlines()
    assert written[:-1] == [
        f"methods/my_average/{name}" for name in ("resolve.glsl", "method.py", "gather.glsl")
    ]
    again = shlex.split(written[-1].removeprefix("next: oitbench "))
    assert call(*again, "--scene", "glass_bars", *SMALL, "--truth", "exact").code == 0
    checked = call("stability", "--method", "my_average[power=1]", "--collection", ".", "--json")
    assert checked.code == 0
    assert '"promised":true' in checked.out.replace(" ", "")


def test_a_new_scene_can_be_rendered(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    answer = call("new", "scene", "my_panes", "-o", "mine")
    again = shlex.split(answer.out.splitlines()[-1].removeprefix("next: oitbench "))
    assert call(*again, "--method", "alpha_blend", *SMALL, "--truth", "exact").code == 0
    assert (tmp_path / "results" / "cells.jsonl").is_file()


def test_a_new_report_lists_errors(call: Call, tmp_path: Path) -> None:
    assert call("new", "report", "my_errors", "-o", tmp_path / "mine").code == 0
    cells = [finished(tmp_path, "fog", "glow", 0.1)]
    report = Collection.load([tmp_path / "mine"]).reports["my_errors"]
    assert report.title == "My errors"
    (table,) = report.build(context(tmp_path, cells, tmp_path))
    assert isinstance(table, Table)
    assert table.csv.name == "my_errors.csv"


def test_names_that_cannot_be(call: Call, tmp_path: Path) -> None:
    for name in ("a-b", "class", "Big", "../x", ""):
        answer = call("new", "scene", name, "-o", tmp_path)
        assert answer.code == 2
        assert f"'{name}' is no name of a plugin" in answer.err
    assert not list(tmp_path.iterdir())


def test_nothing_is_overwritten(call: Call, tmp_path: Path) -> None:
    assert call("new", "scene", "mine", "-o", tmp_path).code == 0
    path = tmp_path / "scenes" / "mine.py"
    path.write_text("precious")
    answer = call("new", "scene", "mine", "-o", tmp_path)
    assert answer.code == 2
    assert "exists" in answer.err
    assert path.read_text() == "precious"


def test_the_kind_may_be_in_the_plural(call: Call, tmp_path: Path) -> None:
    answer = call("new", "scenes", "my_panes", "-o", tmp_path)
    assert answer.out.startswith(str(tmp_path / "scenes" / "my_panes.py"))
    call("new", "scine", "x", "-o", tmp_path).assert_refused("unknown kind 'scine'; did you mean")
