"""`oitbench doctor`: missing parts of an installation."""

from __future__ import annotations

from pathlib import Path

from tests.cli.helpers import NO_EGL, spawn


def test_missing_libraries_are_reported(tmp_path: Path) -> None:
    answer = spawn("doctor", DRJIT_LIBLLVM_PATH=str(tmp_path / "libLLVM-15.so"), **NO_EGL)
    assert answer.code == 1
    assert "FAIL  OpenGL: no OpenGL 4.5 context" in answer.out
    for command in ("apt install libegl1", "dnf install libglvnd-egl", "pacman -S", "apk add mesa"):
        assert f"FAIL  packages: {command}" in answer.out
    assert "libLLVM-15.so is no file" in answer.out
