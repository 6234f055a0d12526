"""`oitbench choose`: answers from stored results alone."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.choosing.made_up import cell, demanding
from tests.cli.helpers import Call
from tests.made_up import timed, write


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    cells = []
    for scene, error in (("panes", 0.1), ("smoke", 0.4)):
        lists = demanding(atomics=True, tile_bits=64)
        cells.append(cell("lists", 0.0, scene, demands=lists, time=timed(9.0)))
        cells.append(cell("mean", error, scene, demands=demanding(tile_bits=80)))
        cells.append(cell("peel", 0.2, scene, demands=demanding(tile_bits=160)))
    return write(tmp_path, cells)


def test_it_prints_what_fits_and_why_others_do_not(call: Call, folder: Path) -> None:
    answer = call("choose", folder, "--bits", 128, "--no-atomics")
    assert answer.code == 0
    lines = [" ".join(line.split()) for line in answer.out.splitlines()]
    assert lines[0] == "softly: at most 128 bits of tile memory, no buffers with atomics"
    assert "panes exact mean * 0.1000 0.1000 0.1000 2 ms" in lines
    assert "mean * 0.2500 0.2500 0.4000" in lines
    assert "lists needs buffers with atomics" in lines
    assert "peel needs 160 bits of tile memory" in lines
    assert lines[-1] == "best: mean"


def test_json_has_the_whole_answer(call: Call, folder: Path) -> None:
    answer = call("choose", folder, "--class", "targets", "--time", "1.95 ms", "--json")
    found = json.loads(answer.out)
    assert found["best"] == ["peel"]
    assert found["constraints"]["milliseconds"] == 1.95
    lists, mean = found["scenes"][0]["methods"][:2]
    assert lists["reasons"] == ["needs atomics and unbounded buffers", "takes 9 ms"]
    assert (lists["demands"]["class"], lists["fits"]) == ("atomics", False)
    assert (mean["flip"]["exact"], mean["loss"], mean["time_ties_with_limit"]) == (0.1, 0.1, True)


def test_times_have_signs_that_are_explained(call: Call, tmp_path: Path) -> None:
    cells = [cell("mean", time=timed(2.0, foreign=0.2)), cell("peel", time=timed(2.0))]
    folder = write(tmp_path, cells)
    out = call("choose", folder).out
    assert "2 ms †" in out
    assert "\n† disturbed by other processes\n" in out
    assert "≈" not in out
    out = call("choose", folder, "--time", "2ms").out
    assert "2 ms ≈" in out
    assert "\n≈ does not clearly differ from the limit of time\n" in out


def test_if_nothing_fits_it_says_why_and_exits_with_1(call: Call, folder: Path) -> None:
    answer = call("choose", folder, "--bits", 32)
    assert answer.code == 1
    assert answer.out.splitlines()[-1].startswith("nothing fits")
    assert "needs 64 bits of tile memory" in answer.out


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        (("--time", "5"), "cannot read time '5'; write it as 5ms"),
        (("--time", "0ms"), "cannot read time '0ms'"),
        (("--class", "target"), "unknown class 'target'; did you mean targets?"),
        (("--scene", "pane"), "unknown scene 'pane'; did you mean panes?"),
        (("--renderer", "hard"), "unknown renderer 'hard'"),
        (("--bits", "0"), "--bits"),
    ],
)
def test_wrong_arguments_are_one_line(
    call: Call, folder: Path, arguments: tuple[str, str], part: str
) -> None:
    call("choose", folder, *arguments).assert_refused(part)


@pytest.mark.parametrize(
    ("text", "milliseconds"), [("5ms", 5.0), (".5 s", 500.0), ("250us", 0.25), ("2.5µs", 0.0025)]
)
def test_times_have_units(text: str, milliseconds: float) -> None:
    from oitbench.cli.choose import parse_time

    assert parse_time(text) == pytest.approx(milliseconds)


def test_it_loads_no_opengl_no_plugin_and_no_large_package(folder: Path) -> None:
    names = (
        "moderngl",
        "mitsuba",
        "pandas",
        "matplotlib",
        "oitbench.plugins",
        "oitbench.gl.device",
    )
    code = (
        "import sys\nfrom oitbench.cli import group\n"
        f"group.main(['choose', {str(folder)!r}], standalone_mode=False)\n"
    )
    loaded = f"print('loaded:', *[name for name in {names} if name in sys.modules])\n"
    # The command ends the process.
    code = f"import atexit, sys\natexit.register(lambda: {loaded.strip()})\n{code}"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60
    )
    assert done.stdout.splitlines()[-1] == "loaded:"
