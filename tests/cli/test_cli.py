"""The command line: what a user can mend is told in one line, with exit code 2."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from oitbench.cli import main
from oitbench.image.files import read_exr
from tests.plugins import misbehaving

SMALL = ("--size", "8x8", "--ssaa", "1")


@pytest.fixture(scope="module")
def plugins(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return misbehaving(tmp_path_factory.mktemp("plugins"))


def call(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> int:
    """Call the command line in this process; return its exit code."""
    monkeypatch.setattr(sys, "argv", ["oitbench", *arguments])
    try:
        main()
    except SystemExit as stop:
        return stop.code if isinstance(stop.code, int) else 1
    return 0


def spawn(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Call the command line in a process of its own."""
    return subprocess.run(
        [sys.executable, "-m", "oitbench", *arguments],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=120,
    )


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("rnu",), "unknown command 'rnu'; did you mean run"),
        (("run", "--scene", "layer_stak"), "unknown scene 'layer_stak'; did you mean layer_stack"),
        (("run", "--method", "a_bufer"), "unknown method 'a_bufer'; did you mean a_buffer"),
        (("run", "--method", "a_buffer[nod=precise]"), "parameter of a_buffer 'nod'; did you mean"),
        (("run", "--method", "a_buffer[node=tiny]"), "node cannot be tiny; choose from precise"),
        (("run", "--method", "a_buffer[node"), "cannot read 'a_buffer[node'"),
        (("run", "--method", "no/such/folder"), "is no method; it has no method.py"),
        (("run", "--scene", "layer_stack[alpha=nan]"), "alpha is nan"),
        (("run", "--scene", "layer_stack[count=0]"), "count is 0; it must be at least 1"),
        (("run", "--size", "0x5"), "0x5"),
        (("run", "--size", "big"), "'big'"),
        (("run", "--preset", "huge"), "huge"),
        (("run", "--effects", "-fog"), "unknown effect 'fog'"),
        (("run", "--timeout", "-1"), "timeout is -1 s"),
        (("run", "--workers", "0"), "0"),
        (("run", "--collection", "no/such/folder"), "is no collection"),
        (("render", "layer_stack", "a_buffer", "-o", "x.jpg"), ".jpg"),
        (("render", "layer_stack", "a_buffer"), "--out"),
        (("report", "no/such/folder"), "no/such/folder"),
    ],
)
def test_bad_input_gets_one_line_and_code_2(
    arguments: tuple[str, ...],
    told: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert call(monkeypatch, *arguments) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.count("\n") == 1
    assert told in printed.err
    assert list(tmp_path.iterdir()) == []


def test_a_scene_with_nan_gets_one_line_and_code_2(
    plugins: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    out, where = str(tmp_path / "x.exr"), ("--collection", str(plugins))
    for scene, told in (
        ("poisoned", "background holds NaN or infinity"),
        ("raiser", "raiser.py:14: ValueError: the scene is unwell"),
    ):
        assert call(monkeypatch, "render", scene, "alpha_blend", "-o", out, *SMALL, *where) == 2
        printed = capsys.readouterr().err
        assert told in printed
        assert printed.count("\n") == 1


def test_help_and_version_exit_with_0(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for arguments in (("--help",), ("--version",), ("run", "--help"), ("render", "-h")):
        assert call(monkeypatch, *arguments) == 0
        assert capsys.readouterr().out


def test_list_names_methods_scenes_and_their_parameters(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert call(monkeypatch, "list", "methods", "--json") == 0
    methods = {entry["name"]: entry for entry in json.loads(capsys.readouterr().out)}
    assert methods["a_buffer"]["parameters"]["node"]["choices"] == ["precise", "compact"]
    assert methods["a_buffer"]["title"].startswith("A-buffer")
    assert call(monkeypatch, "list") == 0
    told = capsys.readouterr().out
    assert "layer_stack" in told
    assert "colored_transmission" in told


def test_list_survives_a_broken_plugin(
    plugins: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (plugins / "methods" / "unreadable").mkdir(exist_ok=True)
    (plugins / "methods" / "unreadable" / "method.py").write_text("this is no Python\n")
    assert call(monkeypatch, "list", "methods", "--collection", str(plugins)) == 0
    told = capsys.readouterr().out
    assert "cannot be loaded" in told
    assert "a_buffer" in told


def test_render_writes_a_picture_of_the_size_asked_for(tmp_path: Path) -> None:
    out = tmp_path / "picture.exr"
    answer = spawn("render", "layer_stack", "a_buffer", "-o", str(out), "--size", "24x16")
    assert answer.returncode == 0, answer.stderr
    image = read_exr(out)
    assert image.shape == (16, 24, 3)
    assert image.max() > 0.1


def test_a_broken_shader_is_told_with_file_and_line(plugins: Path, tmp_path: Path) -> None:
    folder = plugins / "methods" / "broken"
    answer = spawn("render", "layer_stack", str(folder), "-o", str(tmp_path / "x.exr"), *SMALL)
    assert answer.returncode == 2
    assert answer.stderr.startswith(f"oitbench: {folder}/draw.glsl:2: error")
    assert answer.stderr.count("\n") == 1


def test_a_frame_beyond_the_driver_is_refused(tmp_path: Path) -> None:
    out = str(tmp_path / "x.exr")
    answer = spawn("render", "layer_stack", "a_buffer", "-o", out, "--size", "999999x1")
    assert answer.returncode == 2
    assert "the driver's limit" in answer.stderr


@pytest.mark.parametrize("verb", ["render", "run"])
def test_without_egl_the_mend_is_told(verb: str, tmp_path: Path) -> None:
    arguments = {
        "render": ("render", "layer_stack", "a_buffer", "-o", str(tmp_path / "x.exr")),
        "run": ("run", "--scene", "layer_stack", "--out", str(tmp_path / "out"), *SMALL),
    }[verb]
    answer = spawn(*arguments, __EGL_VENDOR_LIBRARY_FILENAMES="/dev/null")
    assert answer.returncode == 2
    assert "no OpenGL 4.5 context through EGL" in answer.stderr
    assert "libegl1" in answer.stderr
    assert "Traceback" not in answer.stderr


def test_doctor_tells_what_is_missing(tmp_path: Path) -> None:
    answer = spawn(
        "doctor",
        __EGL_VENDOR_LIBRARY_FILENAMES="/dev/null",
        DRJIT_LIBLLVM_PATH=str(tmp_path / "libLLVM-15.so"),
    )
    assert answer.returncode == 1
    assert "FAIL  OpenGL: no OpenGL 4.5 context" in answer.stdout
    assert "libLLVM-15.so is no file" in answer.stdout


def test_an_unwritable_folder_is_told() -> None:
    answer = spawn("run", "--scene", "layer_stack", "--out", "/proc/results", *SMALL)
    assert answer.returncode == 2
    assert "/proc/results cannot be written to" in answer.stderr
    answer = spawn("render", "layer_stack", "alpha_blend", "-o", "/proc/x.exr", *SMALL)
    assert answer.returncode == 2
    assert "/proc/x.exr" in answer.stderr
    assert "Traceback" not in answer.stderr
