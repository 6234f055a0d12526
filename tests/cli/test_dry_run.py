"""`oitbench run --dry-run`: what it lists and prints."""

from __future__ import annotations

import shlex
from pathlib import Path

from tests.cli.helpers import SMALL, Call

CHOSEN = ("--scene", "layer_stack[count=3]", "--method", "weighted_sum", "--method", "alpha_blend")


def test_cells_are_counted_by_scene_and_nothing_is_written(call: Call, tmp_path: Path) -> None:
    out = tmp_path / "out"
    arguments = ("run", "--preset", "guard", *SMALL, "--out", str(out), *CHOSEN)
    answer = call(*arguments, "--dry-run")
    assert (answer.code, answer.err) == (0, ""), answer
    assert not out.exists()
    lines = answer.out.splitlines()
    (row,) = (line.split() for line in lines if line.split()[:1] == ["layer_stack[count=3]"])
    assert row[1:5] == ["2", "2", "0", "2"]
    assert "cells: 2, 0 done, 2 to do" in lines
    for beginning in ("time: about ", "memory: about ", "disk: about "):
        assert any(line.startswith(beginning) for line in lines), beginning
    assert lines[-1] == f"next: {shlex.join(['oitbench', *arguments])}"
    # Only --verbose names cells.
    assert "weighted_sum, 8x8" not in answer.out


def test_each_cell_is_named_if_asked_for(call: Call, tmp_path: Path) -> None:
    arguments = ("run", "--preset", "guard", *SMALL, "--out", str(tmp_path), *CHOSEN)
    assert call(*arguments[:-2]).code == 0
    effects = ("--effects", "requested", "--effects", "none")
    answer = call(*arguments, *effects, "--dry-run", "--verbose")
    lines = [line for line in answer.out.splitlines() if line.startswith(("done: ", "to do: "))]
    assert lines == [
        "done: layer_stack[count=3] weighted_sum, 8x8, ssaa 1",
        "to do: layer_stack[count=3] weighted_sum, 8x8, ssaa 1, effects none",
        "to do: layer_stack[count=3] alpha_blend, 8x8, ssaa 1",
        "to do: layer_stack[count=3] alpha_blend, 8x8, ssaa 1, effects none",
    ]
    assert "cells: 4, 1 done, 3 to do" in answer.out


def test_verbose_belongs_to_a_dry_run(call: Call) -> None:
    call("run", "--verbose").assert_refused("--verbose needs --dry-run")
