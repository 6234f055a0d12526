"""`reproduce.sh` keeps its environment, unless another version of Python is asked for."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from oitbench.places import own_folder

# Answers what the script asks of an interpreter, and writes down its arguments.
FAKE = """#!/bin/sh
case "$*" in
*platform.python_version*) echo {version} ;;
*"-m venv"*) echo made >>"{log}" ;;
*"pip install"*) echo installed >>"{log}" ;;
esac
"""


def write_python(path: Path, version: str, log: Path) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(FAKE.format(version=version, log=log))
    path.chmod(0o755)
    return path


@pytest.mark.parametrize(
    ("wanted", "done"),
    [
        ("3.13.1", ["made", "installed"]),
        ("3.11.2", ["installed"]),
        (None, ["installed"]),
    ],
)
def test_an_environment_of_another_python_is_made_anew(
    tmp_path: Path, wanted: str | None, done: list[str]
) -> None:
    for name in ("reproduce.sh", "pyproject.toml"):
        shutil.copy(own_folder() / name, tmp_path)
    log = tmp_path / "log"
    write_python(tmp_path / ".venv" / "bin" / "python", "3.11.2", log)
    environment = {name: value for name, value in os.environ.items() if name != "PYTHON"}
    if wanted is not None:
        environment["PYTHON"] = str(write_python(tmp_path / "other", wanted, log))
    command = [str(tmp_path / "reproduce.sh"), "--setup-only"]
    subprocess.run(command, env=environment, check=True, capture_output=True, text=True)
    assert log.read_text().split() == done
