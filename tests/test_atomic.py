"""Writing files: locks of several processes, and temporary files."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from oitbench.atomic import locked, remove_partial_files, replacing
from oitbench.errors import StorageError, UsageError

COUNT = """
import sys
from pathlib import Path
from oitbench.atomic import locked, replacing
folder = Path(sys.argv[1])
for _ in range(50):
    with locked(folder / ".lock", wait=True):
        value = int((folder / "value").read_text())
        with replacing(folder / "value") as partial:
            partial.write_text(str(value + 1))
"""


def test_processes_that_wait_for_a_lock_lose_no_change(tmp_path: Path) -> None:
    (tmp_path / "value").write_text("0")
    command = [sys.executable, "-c", COUNT, str(tmp_path)]
    processes = [subprocess.Popen(command) for _ in range(3)]
    assert [process.wait(timeout=60) for process in processes] == [0, 0, 0]
    assert (tmp_path / "value").read_text() == "150"
    assert [path.name for path in tmp_path.iterdir()] == ["value"]


def test_a_lock_is_free_after_an_error(tmp_path: Path) -> None:
    def fail() -> None:
        with locked(tmp_path / "lock"):
            raise KeyError

    with pytest.raises(KeyError):
        fail()
    with locked(tmp_path / "lock"), pytest.raises(UsageError, match="is in use by process"):
        fail()


def test_a_lock_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    with pytest.raises(StorageError, match="cannot be written"), locked(tmp_path / "no" / "lock"):
        pass


def test_only_temporary_files_are_removed(tmp_path: Path) -> None:
    names = [".a.12.partial.exr", ".b.7.partial", ".hidden", "a.partial.exr", "b.exr"]
    for name in names:
        (tmp_path / name).touch()
    remove_partial_files(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == names[2:]


def test_a_later_writer_removes_what_a_killed_one_left(tmp_path: Path) -> None:
    code = """
import os, signal, sys
from pathlib import Path
from oitbench.atomic import replacing
with replacing(Path(sys.argv[1])) as partial:
    partial.write_text("half")
    os.kill(os.getpid(), signal.SIGKILL)
"""
    target = tmp_path / "base [1].json"
    killed = subprocess.run([sys.executable, "-c", code, str(target)])
    assert killed.returncode == -signal.SIGKILL
    (left,) = tmp_path.iterdir()
    # Files of another target, and of processes that live, belong to somebody else.
    others = [left.name.replace("base", "other"), f".base [1].{os.getppid()}.partial.json"]
    for name in others:
        (tmp_path / name).touch()
    with replacing(target) as partial:
        partial.write_text("whole")
    assert {path.name for path in tmp_path.iterdir()} == {target.name, *others}
    assert target.read_text() == "whole"
