"""Odd but legal surroundings: names that are not UTF-8, no home folder, damaged JSON."""

from __future__ import annotations

import os
import re
import shutil
from pathlib import Path
from urllib.parse import unquote

import pytest

from oitbench.places import own_folder
from tests.cli.helpers import SMALL, Answer, Call, spawn

STACK = ("--scene", "layer_stack", "--method", "alpha_blend", *SMALL)
DEEP = b'{"a":' * 100_000


@pytest.fixture(scope="module")
def latin(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder whose name is not UTF-8."""
    folder = tmp_path_factory.mktemp("folder")
    path = Path(os.fsdecode(os.fsencode(folder) + b"/caf\xe9"))
    path.mkdir()
    return path


@pytest.fixture(scope="module")
def results(latin: Path) -> tuple[Answer, Path]:
    """Results in that folder, of a scene in that folder."""
    (latin / "scenes").mkdir()
    shutil.copy(own_folder() / "scenes" / "layer_stack.py", latin / "scenes" / "pile.py")
    out = latin / "results"
    place = ("--collection", str(latin), "--out", str(out), "--preset", "guard")
    return spawn("run", "--scene", "pile", *STACK, *place), out


def test_a_run_in_a_folder_whose_name_is_not_utf8(results: tuple[Answer, Path]) -> None:
    answer, out = results
    assert answer.code == 0, answer.err
    assert r"caf\udce9/results: 2 ok" in answer.out
    assert r"caf\\udce9" in (out / "run.json").read_text(encoding="utf-8")


def test_a_report_in_such_a_folder(results: tuple[Answer, Path]) -> None:
    _, out = results
    answer = spawn("report", str(out))
    assert (answer.code, answer.err) == (0, "")
    page = (out / "report" / "index.html").read_text(encoding="utf-8")
    for link in re.findall(r'src="(?!data:)([^"]+)"', page):
        assert (out / "report" / unquote(link)).is_file()


@pytest.mark.parametrize("name", ["x.exr", "x.png"])
def test_a_picture_in_such_a_folder(latin: Path, name: str) -> None:
    answer = spawn("render", "layer_stack", "alpha_blend", "-o", str(latin / name), *SMALL)
    assert answer.code == 0, answer.err
    assert (latin / name).stat().st_size > 0


def test_without_a_home_folder_references_are_not_cached(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def homeless() -> Path:
        raise RuntimeError("Could not determine home directory.")

    from oitbench.path_traced.references import lookup
    from oitbench.path_traced.references.wanted import Wanted
    from oitbench.plugins import Collection

    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", homeless)
    scene = Collection.load().build_scene("glass_bars")
    _, message = lookup.find_or_render(Wanted(scene, "glass_bars", (4, 4), 1), [])
    assert message == "not cached: there is no home folder; set XDG_CACHE_HOME"


@pytest.mark.parametrize(
    "text", [DEEP, b"[" * 100_000, b'{"format": NaN}', b'{"format": 1e999}', b"\xff", b""]
)
def test_a_damaged_baseline_is_one_line(
    call: Call, results: tuple[Answer, Path], tmp_path: Path, text: bytes
) -> None:
    file = tmp_path / "baseline.json"
    file.write_bytes(text)
    answer = call("baseline", "check", results[1], file)
    answer.assert_refused("baseline.json is no baseline")


def test_deep_json_in_results_is_one_line(results: tuple[Answer, Path], tmp_path: Path) -> None:
    shutil.copytree(results[1], tmp_path / "copy")
    (tmp_path / "copy" / "run.json").write_bytes(DEEP)
    answer = spawn("report", str(tmp_path / "copy"), "--markdown")
    assert answer.code == 0
    assert "layer_stack" in answer.out
    (line,) = answer.err.splitlines()
    assert "run.json is damaged and ignored" in line


@pytest.mark.parametrize("exposure", [1e3, 1024, 1e308, -1e4])
def test_an_extreme_exposure_is_refused(call: Call, tmp_path: Path, exposure: float) -> None:
    (tmp_path / "scenes").mkdir()
    source = (own_folder() / "scenes" / "glass_bars.py").read_text(encoding="utf-8")
    changed = source.replace("return Scene(", f"return Scene(exposure={exposure}, ", 1)
    assert changed != source
    (tmp_path / "scenes" / "bright.py").write_text(changed, encoding="utf-8")
    out = ("-o", tmp_path / "x.png", "--collection", tmp_path)
    answer = call("render", "bright", "alpha_blend", *SMALL, *out)
    answer.assert_refused(f"exposure is {exposure:g} stops; keep it within ±120")
