"""A run that is stopped, in whatever way, leaves no process behind and keeps what is finished."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import psutil
import pytest

from oitbench.results.store import CELLS, read_cells

SECONDS = 60
"""Generous limit of everything that a test waits for."""


def wait_for(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + SECONDS
    while not condition():
        assert time.monotonic() < deadline, "nothing happened"
        time.sleep(0.05)


def accept_signals() -> None:
    """Undo a shell's `nohup` or `&`, which let programs ignore signals."""
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)


def ignore_hangups() -> None:
    accept_signals()
    signal.signal(signal.SIGHUP, signal.SIG_IGN)


def start(plugins: Path, out: Path, prepare: Callable[[], None]) -> subprocess.Popen[str]:
    """Start a run, and return it when one cell is finished and another one hangs."""
    command = [sys.executable, "-m", "oitbench", "run", "--size", "16x16", "--ssaa", "1"]
    command += ["--scene", "calm", "--scene", "sleeper[count=1,2,3]", "--method", "alpha_blend"]
    command += ["--collection", str(plugins), "--out", str(out)]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, preexec_fn=prepare)
    wait_for(lambda: (out / CELLS).is_file())
    return process


def workers_of(process: subprocess.Popen[str]) -> list[psutil.Process]:
    found = psutil.Process(process.pid).children(recursive=True)
    assert found
    return found


def assert_gone(workers: list[psutil.Process]) -> None:
    _, alive = psutil.wait_procs(workers, timeout=SECONDS)
    assert not alive


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_stopped_run_ends_at_once_and_keeps_finished_cells(
    plugins: Path, tmp_path: Path, number: signal.Signals
) -> None:
    process = start(plugins, tmp_path, accept_signals)
    try:
        workers = workers_of(process)
        process.send_signal(number)
        _, printed = process.communicate(timeout=SECONDS)
    finally:
        process.kill()
    assert process.returncode == 128 + number
    assert "run was stopped; finished cells are kept, run again to resume" in printed
    assert "Traceback" not in printed
    assert_gone(workers)
    assert [record.scene for record in read_cells(tmp_path / CELLS).values()] == ["calm"]


def test_a_stopped_estimate_says_that_nothing_is_kept(plugins: Path, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "oitbench", "run", "--dry-run", "--size", "16x16"]
    command += ["--scene", "sleeper", "--method", "alpha_blend"]
    command += ["--collection", str(plugins), "--out", str(tmp_path / "out")]
    process = subprocess.Popen(
        command, stderr=subprocess.PIPE, text=True, preexec_fn=accept_signals
    )
    try:
        wait_for(lambda: len(psutil.Process(process.pid).children(recursive=True)) > 0)
        process.send_signal(signal.SIGINT)
        _, printed = process.communicate(timeout=SECONDS)
    finally:
        process.kill()
    assert process.returncode == 128 + signal.SIGINT
    assert "the estimate was stopped; nothing is kept of it" in printed
    assert not (tmp_path / "out").exists()


def test_several_signals_at_once_are_one_end(plugins: Path, tmp_path: Path) -> None:
    process = start(plugins, tmp_path, accept_signals)
    try:
        workers = workers_of(process)
        process.send_signal(signal.SIGSTOP)
        for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGCONT):
            process.send_signal(number)
        _, printed = process.communicate(timeout=SECONDS)
    finally:
        process.kill()
    assert process.returncode in (128 + signal.SIGTERM, 128 + signal.SIGHUP)
    assert "Traceback" not in printed
    assert_gone(workers)


def test_no_worker_outlives_a_killed_run(plugins: Path, tmp_path: Path) -> None:
    process = start(plugins, tmp_path, accept_signals)
    workers = workers_of(process)
    process.kill()
    process.communicate(timeout=SECONDS)
    assert_gone(workers)


def test_a_run_under_nohup_survives_the_end_of_the_terminal(plugins: Path, tmp_path: Path) -> None:
    process = start(plugins, tmp_path, ignore_hangups)
    try:
        process.send_signal(signal.SIGHUP)
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=SECONDS)
    finally:
        process.kill()
    assert process.returncode == 128 + signal.SIGTERM
