"""Options from a file, and the file that repeats a run."""

from __future__ import annotations

from pathlib import Path

import pytest

from oitbench.results.store import read_cells
from tests.cli.helpers import SMALL, Call


def test_a_run_can_be_repeated_from_its_folder(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    given = ("--scene", "glass_bars[reflection=0.1]", "--method", "alpha_blend")
    limits = ("--timeout", "none", "--preset", "guard", "--view", "left", "--seed", "7")
    first = call("run", *given, *limits, *SMALL, "--out", "first", "--scene", "glass_bars")
    text = (tmp_path / "first" / "run.toml").read_text()
    assert 'size = "8x8"' in text
    assert 'timeout = "none"' in text
    assert "collection" not in text
    again = call("run", "--config", "first/run.toml", "--out", "again", "--seed", "8")
    assert again.code == first.code == 0
    assert (tmp_path / "again" / "run.toml").read_text() == text.replace(
        'out = "first"', 'out = "again"'
    ).replace("seed = 7", "seed = 8")
    keys = [list(read_cells(tmp_path / name / "cells.jsonl")) for name in ("first", "again")]
    assert keys[0] == keys[1]
    assert len(keys[0]) == 2


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("methods = 'x'", "unknown option 'methods'; did you mean method"),
        ("size = ['8x8']", "size takes one value, not a list"),
        ("method = [{a = 1}]", "method takes text or numbers"),
        ("method = ", "is no TOML file"),
        ("preset = 'big'", "preset"),
        ("force = true", "unknown option 'force'"),
    ],
)
def test_files_that_are_no_options(call: Call, tmp_path: Path, text: str, problem: str) -> None:
    path = tmp_path / "some.toml"
    path.write_text(text)
    answer = call("run", "--config", path, "--out", tmp_path / "out")
    assert answer.code == 2
    assert problem in answer.err
    assert not (tmp_path / "out").exists()


def test_a_missing_file(call: Call, tmp_path: Path) -> None:
    answer = call("run", "--config", tmp_path / "none.toml")
    assert answer.code == 2
    assert "none.toml cannot be read" in answer.err
