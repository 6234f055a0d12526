"""Damaged files give a scene or one clear line: never a crash, a hang or much memory.

`python -m tests.benchmarks.imports` tries more of them.
"""

from __future__ import annotations

import random
import resource
import signal
import warnings
from pathlib import Path
from types import FrameType

import pytest

from oitbench.errors import OitbenchError
from oitbench.importing import read_scene
from tests.importing.mutations import mutated, seeds, write_all

SECONDS = 10
MEMORY = 2 << 30
EACH = 300


def attempt(path: Path) -> str:
    """Import a file; return the one line that refuses it, or "" if there is a scene.

    Any other exception, ten seconds without a result, and a warning of numpy fail.
    """

    def stop(number: int, frame: FrameType | None) -> None:
        raise AssertionError(f"{path} takes more than {SECONDS} s")

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(SECONDS)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            read_scene(path)
    except OitbenchError as error:
        line = str(error)
        assert line
        assert "\n" not in line
        assert len(line) < 1000
        return line
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
    return ""


@pytest.mark.parametrize("kind", seeds())
def test_the_files_that_are_damaged_can_be_imported(kind: str, tmp_path: Path) -> None:
    files = seeds()[kind]
    assert sum(map(len, files.values())) <= 10_000
    assert attempt(write_all(tmp_path, files)) == ""


@pytest.mark.parametrize("kind", seeds())
def test_damaged_files_give_a_scene_or_one_clear_line(kind: str, tmp_path: Path) -> None:
    random_ = random.Random(kind)
    files = seeds()[kind]
    limits = resource.getrlimit(resource.RLIMIT_DATA)
    resource.setrlimit(resource.RLIMIT_DATA, (_data() + MEMORY, limits[1]))
    try:
        lines = {attempt(write_all(tmp_path, mutated(kind, files, random_))) for _ in range(EACH)}
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, limits)
    # Some survive, and the others fail in many ways.
    assert "" in lines
    assert len(lines) > 15


def _data() -> int:
    """Return the bytes of this process that count against the limit."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmData:"):
            return int(line.split()[1]) << 10
    raise AssertionError("no VmData")
