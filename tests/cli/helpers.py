"""Calls of the command line and their answers."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass

SMALL = ("--size", "8x8", "--ssaa", "1")
NO_EGL = {"__EGL_VENDOR_LIBRARY_FILENAMES": "/dev/null"}
"""Environment in which no OpenGL driver is found."""


@dataclass(frozen=True)
class Answer:
    """Exit code and printed text of a call."""

    code: int
    out: str
    err: str

    def assert_refused(self, part: str) -> None:
        """Assert that the call printed only one line, an error with that part, and exit code 2."""
        assert self.code == 2, self
        assert self.out == ""
        assert self.err.count("\n") == 1
        assert part in self.err

    def assert_no_driver(self) -> None:
        """Assert that the call ended with an error that names the missing package."""
        assert self.code == 2, self
        assert "no OpenGL 4.5 context through EGL" in self.err
        assert "libegl1" in self.err
        assert "Traceback" not in self.err


Call = Callable[..., Answer]


def spawn(*arguments: str, **environment: str) -> Answer:
    """Call the command line in a process of its own."""
    done = subprocess.run(
        [sys.executable, "-m", "oitbench", *arguments],
        env={**os.environ, **environment},
        capture_output=True,
        encoding="utf-8",
        # The environment may ask for another encoding.
        errors="backslashreplace",
        timeout=600,
    )
    return Answer(done.returncode, done.stdout, done.stderr)
