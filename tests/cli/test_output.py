"""Outputs that are full, closed, or of an encoding with few characters."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from tests.cli.helpers import Call, spawn


def spawn_into(output: int, *arguments: str) -> tuple[int, str]:
    """Call the command line with a standard output; return exit code and standard error."""
    command = [sys.executable, "-m", "oitbench", *arguments]
    done = subprocess.run(command, stdout=output, stderr=subprocess.PIPE, text=True, timeout=120)
    return done.returncode, done.stderr


@pytest.mark.parametrize("arguments", [("list",), ("--help",)])
def test_a_closed_pipe_is_no_error_message(arguments: tuple[str, ...]) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    assert spawn_into(writer, *arguments) == (141, "")
    os.close(writer)


@pytest.mark.parametrize("arguments", [("list",), ("--version",)])
def test_a_full_disk_is_one_line(arguments: tuple[str, ...]) -> None:
    full = os.open("/dev/full", os.O_WRONLY)
    code, printed = spawn_into(full, *arguments)
    os.close(full)
    assert code == 2
    assert printed.count("\n") == 1
    assert "the output cannot be written (No space left on device)" in printed


def test_characters_that_an_encoding_lacks_become_escapes() -> None:
    answer = spawn("list", PYTHONIOENCODING="latin-1")
    assert (answer.code, answer.err) == (0, "")
    assert r"\u2080" in answer.out


def test_without_a_command_the_help_is_printed(call: Call) -> None:
    answer = call()
    assert answer.code == 0
    assert "Usage: oitbench" in answer.out
    assert "doctor" in answer.out
