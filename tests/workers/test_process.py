"""A worker that crashes, hangs, prints or takes too much memory costs one request."""

from __future__ import annotations

import math
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from oitbench.errors import UsageError
from oitbench.workers import memory
from oitbench.workers.memory import available
from oitbench.workers.messages import Step
from oitbench.workers.process import Process, WorkerError
from tests.workers.far import Act, Done, Word

LIMIT = 200 * 2**20


@pytest.fixture
def worker() -> Iterator[Process]:
    with Process("tests.workers.far", Word("!"), Done, LIMIT) as worker:
        yield worker


def answer(worker: Process, action: str, timeout: float | None = 60.0) -> str:
    return worker.ask(Act(action), Done, timeout).text.removesuffix("!")


def wait_until_gone(pid: int) -> None:
    """Wait until a process has ended; fail if it has not after a generous time."""
    deadline = time.monotonic() + 30
    while psutil.pid_exists(pid) and psutil.Process(pid).status() != psutil.STATUS_ZOMBIE:
        assert time.monotonic() < deadline, f"process {pid} still runs"
        time.sleep(0.02)


@pytest.mark.parametrize(
    ("action", "cause", "reason"),
    [
        ("exit", "ended", "the worker process ended with code 7"),
        ("crash", "ended", "the worker process was ended by signal 11 (SIGSEGV)"),
        ("hang", "timeout", "took longer than 0.3 s"),
        ("hang without a break", "timeout", "took longer than 0.3 s"),
        ("hang in a shared step", "timeout", "took longer than 0.3 s while digging"),
        ("fail", "fault", "ZeroDivisionError: by nought"),
        ("quit", "fault", "SystemExit: enough"),
    ],
)
def test_a_lost_request_has_a_reason_and_the_next_one_is_answered(
    worker: Process, action: str, cause: str, reason: str
) -> None:
    with pytest.raises(WorkerError) as caught:
        answer(worker, action, 0.3 if cause == "timeout" else 60)
    assert (str(caught.value), caught.value.cause) == (reason, cause)
    assert caught.value.shared == ("shared" in action)
    assert answer(worker, "work") == "fine"


def test_a_request_that_may_be_repeated_survives_one_end_of_the_process(
    worker: Process, tmp_path: Path
) -> None:
    request = Act(f"exit at first, by {tmp_path / 'mark'}")
    assert worker.ask(request, Done, 60.0, retry=True).text == "second!"
    with pytest.raises(WorkerError, match="ended with code 7"):
        worker.ask(Act("exit"), Done, 60.0, retry=True)
    (tmp_path / "mark").unlink()
    with pytest.raises(WorkerError, match="ended with code 7"):
        worker.ask(request, Done, 60.0)


def test_a_user_error_is_one_line_and_does_not_end_the_process(worker: Process) -> None:
    before = answer(worker, "number")
    with pytest.raises(UsageError, match=r"^three is too many$"):
        answer(worker, "refuse")
    assert answer(worker, "number") == before


def test_each_step_has_the_whole_time(worker: Process) -> None:
    assert answer(worker, "four steps of 0.7 s", timeout=2.4) == "fine"


def test_output_of_plugins_is_no_message(
    worker: Process, capfd: pytest.CaptureFixture[str]
) -> None:
    assert answer(worker, "print") == "fine"
    printed = capfd.readouterr()
    assert printed.out == ""
    assert "from Python" in printed.err
    assert "wrong" in printed.err


def test_standard_input_is_empty_and_no_message_is_lost(worker: Process) -> None:
    assert answer(worker, "read") == "''"
    assert answer(worker, "work") == "fine"


@pytest.mark.parametrize("action", ["allocate", "allocate in a child"])
def test_a_process_with_too_much_memory_is_killed(worker: Process, action: str) -> None:
    with pytest.raises(WorkerError, match=r"^needs more than 0\.195 GiB of memory$") as caught:
        answer(worker, action)
    assert caught.value.cause == "memory"
    assert answer(worker, "work") == "fine"


@pytest.mark.parametrize("action", ["exit", "hang"])
def test_processes_that_a_worker_started_end_with_it(worker: Process, action: str) -> None:
    child = int(answer(worker, "start a child"))
    with pytest.raises(WorkerError):
        answer(worker, action, timeout=0.3)
    wait_until_gone(child)


def test_a_process_that_ended_between_two_requests_is_replaced(worker: Process) -> None:
    pid = int(answer(worker, "number"))
    os.kill(pid, signal.SIGKILL)
    os.waitid(os.P_PID, pid, os.WEXITED | os.WNOWAIT)
    assert answer(worker, "work") == "fine"


def test_a_stopped_worker_ends_what_other_threads_wait_for_and_never_starts_again(
    worker: Process,
) -> None:
    pid = int(answer(worker, "number"))
    errors: list[str] = []

    def ask() -> None:
        try:
            answer(worker, "hang", None)
        except WorkerError as error:
            errors.append(error.cause)

    thread = threading.Thread(target=ask)
    thread.start()
    time.sleep(0.1)
    worker.stop()
    thread.join(timeout=30)
    assert errors == ["ended"]
    wait_until_gone(pid)
    with pytest.raises(WorkerError, match="was stopped"):
        answer(worker, "work")


@pytest.mark.parametrize("action", ["work", "hang", "hang without a break"])
def test_no_worker_outlives_a_killed_parent(action: str, tmp_path: Path) -> None:
    script = f"""
from tests.workers.far import Act, Done, Word
from oitbench.workers.process import Process
worker = Process("tests.workers.far", Word(""), Done, 2**30)
print(worker.ask(Act("number"), Done).text, flush=True)
worker.ask(Act({action!r}), Done)
import time
time.sleep(600)
"""
    with subprocess.Popen(
        [sys.executable, "-c", script], stdout=subprocess.PIPE, text=True
    ) as parent:
        assert parent.stdout is not None
        worker = int(parent.stdout.readline())
        time.sleep(0.2)
        parent.kill()
    wait_until_gone(worker)


def test_a_worker_outlives_the_thread_that_first_asked_it(worker: Process) -> None:
    pids: list[str] = []
    thread = threading.Thread(target=lambda: pids.append(answer(worker, "number")))
    thread.start()
    thread.join()
    time.sleep(0.2)
    assert answer(worker, "number") == pids[0]


def test_files_of_the_working_directory_hide_no_module(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "msgspec.py").write_text("raise SystemExit('hidden')\n")
    monkeypatch.setattr(sys, "path", [path or os.getcwd() for path in sys.path])
    monkeypatch.chdir(tmp_path)
    with Process("tests.workers.far", Word("!"), Done, LIMIT) as worker:
        assert answer(worker, "work") == "fine"


def test_workers_share_three_quarters_of_the_memory() -> None:
    assert memory.limit(None, 1) == int(0.75 * available())
    assert memory.limit(None, 4) == pytest.approx(memory.limit(None, 1) / 4, abs=1)
    assert memory.limit(1.5, 4) == 3 * 2**29
    for wrong in (0.2, -1.0, math.inf, math.nan):
        with pytest.raises(UsageError, match="give at least"):
            memory.limit(wrong, 1)


def test_a_container_may_have_less_memory_than_the_machine(tmp_path: Path) -> None:
    whole = available(tmp_path)
    assert whole == psutil.virtual_memory().total
    (tmp_path / "memory.max").write_text("max\n")
    assert available(tmp_path) == whole
    (tmp_path / "memory.max").write_text("1048576\n")
    assert available(tmp_path) == 2**20


def test_a_process_that_is_killed_from_outside_is_asked_once_more(
    worker: Process, tmp_path: Path
) -> None:
    mark = tmp_path / "mark"
    assert worker.ask(Act(f"be killed at first, by {mark}"), Done, 60.0).text == "second!"
    with pytest.raises(WorkerError, match="signal 9") as caught:
        worker.ask(Act("be killed"), Done, 60.0)
    assert caught.value.cause == "killed"


def test_a_process_that_rests_is_started_again(worker: Process) -> None:
    before = int(answer(worker, "number"))
    worker.rest()
    wait_until_gone(before)
    assert int(answer(worker, "number")) != before


def test_errors_can_be_sent_between_machines() -> None:
    error = WorkerError("took longer than 3 s", "timeout", Step("digging", shared=True))
    copy = pickle.loads(pickle.dumps(error))
    assert str(copy) == str(error) == "took longer than 3 s while digging"
    assert (copy.cause, copy.shared) == ("timeout", True)
