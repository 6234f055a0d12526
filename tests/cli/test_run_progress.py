"""What `oitbench run` prints while it goes on, and when it has ended."""

from __future__ import annotations

import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.helpers import SMALL, Call

GUARD = ("--preset", "guard", *SMALL)
CALM = ("--scene", "layer_stack[count=3]", "--method", "weighted_sum", "--method", "alpha_blend")


def test_a_file_gets_one_line_for_each_finished_cell(call: Call, tmp_path: Path) -> None:
    answer = call("run", *GUARD, "--out", tmp_path, *CALM)
    assert answer.code == 0, answer
    lines = answer.err.splitlines()
    assert [line.partition(";")[0].rpartition(":")[0] for line in lines] == [
        "ok: layer_stack[count=3] weighted_sum",
        "ok: layer_stack[count=3] alpha_blend",
    ]
    assert "1 of 2, " in lines[0]
    assert lines[0].endswith(" left")
    assert lines[1].endswith("2 of 2")
    assert not {*"\r\x1b"} & {*answer.err}
    # Kept cells are not finished once more.
    answer = call("run", *GUARD, "--out", tmp_path, *CALM)
    assert answer.err == ""
    assert "where the time went" not in answer.out


def test_the_end_tells_where_the_time_went(call: Call, tmp_path: Path) -> None:
    answer = call("run", "--preset", "quick", *SMALL, "--truth", "exact", "--out", tmp_path, *CALM)
    assert answer.code == 0, answer
    found = {}
    for line in answer.out.splitlines():
        words = line.split()
        if words and words[-1].endswith("%"):
            found[" ".join(words[:-2])] = float(words[-2])
    assert [*found][-1] == "rest"
    assert found.keys() >= {"building scenes", "rendering", "permutations", "metrics", "timing"}
    summary = next(line for line in answer.out.splitlines() if "kept from before" in line)
    assert sum(found.values()) == pytest.approx(float(summary.split()[-2]), abs=0.5)
    assert "slowest scenes: layer_stack[count=3] " in answer.out
    assert "timed: layer_stack[count=3]: 2 cells" in answer.err


def test_a_quiet_run_prints_what_went_wrong_and_the_last_line(
    call: Call, plugins: Path, tmp_path: Path
) -> None:
    chosen = ("--collection", plugins, "--scene", "calm", "--method", "weighted_sum")
    answer = call("run", "--quiet", *GUARD, "--out", tmp_path, *chosen, "--method", "unstable")
    assert answer.code == 1
    (line,) = answer.err.splitlines()
    assert line.startswith("unstable: calm unstable: pixels:")
    (line,) = answer.out.splitlines()
    assert line.startswith(f"{tmp_path}: 1 ok, 1 unstable; 0 kept")


def test_a_terminal_shows_scene_method_and_stage_in_one_line(tmp_path: Path) -> None:
    ours, theirs = pty.openpty()
    command = [sys.executable, "-m", "oitbench", "run", *GUARD, "--out", str(tmp_path), *CALM]
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": "100"}
    process = subprocess.Popen(
        command, stderr=theirs, stdout=subprocess.DEVNULL, env=environment, close_fds=True
    )
    os.close(theirs)
    printed = b""
    # The end of the process closes the terminal, which is an error to the reader.
    while True:
        try:
            part = os.read(ours, 4096)
        except OSError:
            break
        if not part:
            break
        printed += part
    os.close(ours)
    assert process.wait(timeout=60) == 0
    text = printed.decode()
    assert "layer_stack[count=3] alpha_blend: drawing and scoring the picture" in text
    assert "1/2" in text
    assert " left" in text
    assert "ok: layer_stack" not in text
