"""A full disk turns Mesa's cache of shaders off, which would end the process otherwise."""

from __future__ import annotations

import errno
import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest

from oitbench.gl.shader_cache import avoid_full_disk

DISABLED = {"MESA_SHADER_CACHE_DISABLE": "true", "MESA_GLSL_CACHE_DISABLE": "true"}


def found(folder: Path) -> dict[str, str]:
    environment = {"MESA_SHADER_CACHE_DIR": str(folder)}
    avoid_full_disk(environment)
    return {name: value for name, value in environment.items() if "DISABLE" in name}


def test_the_cache_stays_on_where_there_is_room(tmp_path: Path) -> None:
    assert found(tmp_path) == found(tmp_path / "new" / "cache") == {}
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("number", "expected"),
    [(errno.ENOSPC, DISABLED), (errno.EDQUOT, DISABLED), (errno.EOPNOTSUPP, {})],
)
def test_a_full_disk_turns_it_off(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int, expected: dict[str, str]
) -> None:
    def fail(*arguments: object) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, "posix_fallocate", fail)
    assert found(tmp_path) == expected


def test_a_device_turns_it_off_before_the_driver_starts(tmp_path: Path) -> None:
    limit = 2**20
    script = (
        "import os; from oitbench.gl.device import Device; Device();"
        "print(os.environ.get('MESA_SHADER_CACHE_DISABLE'))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script],
        env={**os.environ, "MESA_SHADER_CACHE_DIR": str(tmp_path)},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)),
        capture_output=True,
        text=True,
    )
    assert done.stdout.strip() == "true", done.stderr
    assert list(tmp_path.iterdir()) == []
