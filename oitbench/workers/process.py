"""The near end of a worker process: starts it, asks it, watches it, kills it."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from queue import Empty, Queue
from typing import Any, Literal, TypeVar

import msgspec
from msgspec import Struct

from oitbench import errors
from oitbench.errors import OitbenchError
from oitbench.workers import memory
from oitbench.workers.messages import Fault, Ready, Refusal, Step, decoder, encode

Expected = TypeVar("Expected", bound=Struct)
OnStep = Callable[[Step], None]
_START_SECONDS = 120.0
_END_SECONDS = 5.0
# `python -m` would look for modules in the working directory first.
_START = (
    "import sys; sys.path[:] = sys.argv[2:];"
    "from importlib import import_module; import_module(sys.argv[1]).main()"
)
_STARTING = Step("starting")
_FROM_OUTSIDE = (-signal.SIGKILL, -signal.SIGTERM)
"""Exit codes of processes that did not end by themselves."""
_HINTS: dict[int, str] = {
    signal.SIGKILL: ", perhaps by the system for lack of memory",
    signal.SIGBUS: ", perhaps because a disk is full",
}


def ignore_step(step: Step) -> None:
    """Do nothing."""


class WorkerError(OitbenchError):
    """The process did not answer.

    Parameters
    ----------
    reason : str
    cause : str
        "timeout", "memory", "fault" (an exception), "killed" (from outside), "ended", or "lost"
        (with its machine).
    step : Step, optional
        The part of the work during which it happened.
    """

    def __init__(
        self,
        reason: str,
        cause: Literal["timeout", "memory", "fault", "killed", "ended", "lost"],
        step: Step | None = None,
    ) -> None:
        super().__init__(f"{reason} while {step.name}" if step else reason)
        self.reason, self.cause, self.step = reason, cause, step

    def __reduce__(self) -> tuple[Any, ...]:
        """Let another machine send the error."""
        return type(self), (self.reason, self.cause, self.step)

    @property
    def timeout(self) -> bool:
        """Whether the process took longer than allowed."""
        return self.cause == "timeout"

    @property
    def shared(self) -> bool:
        """Whether other requests that need the same part of the work would fail in the same way."""
        return self.step is not None and self.step.shared


class Process:
    """A worker process; it starts with the first request, and again after it has ended.

    Parameters
    ----------
    module : str
        Its `main` calls `serve`.
    settings : Struct
    replies : type
        Union of all replies.
    memory_limit : int
        Bytes that the process and its children may use.
    greeting : Struct, optional
        A request that belongs to the start: its time does not count for the first real request.
    threads : int, optional
        Threads that libraries with OpenMP may start. Default: one for each core.
    """

    def __init__(
        self,
        module: str,
        settings: Struct,
        replies: Any,
        memory_limit: int,
        greeting: Struct | None = None,
        threads: int | None = None,
    ) -> None:
        self._module, self._settings, self._greeting = module, settings, greeting
        self._memory_limit = memory_limit
        self._variables = {} if threads is None else {"OMP_NUM_THREADS": str(threads)}
        self._decoder = decoder(replies | Ready | Refusal | Fault | Step)
        self._running: _Running | None = None
        self._lock, self._stopped = threading.Lock(), False

    def __enter__(self) -> Process:
        return self

    def __exit__(self, *error: object) -> None:
        self.stop()

    def ask(
        self,
        request: Struct,
        kind: type[Expected],
        timeout: float | None = None,
        step: Step | None = None,
        retry: bool = False,
        on_step: OnStep = ignore_step,
    ) -> Expected:
        """Send a request and wait for a reply of type `kind`.

        Parameters
        ----------
        request : Struct
        kind : type
        timeout : float, optional
            Seconds for each step of the work. Default: no limit.
        step : Step, optional
            The step with which the work begins.
        retry : bool
            Ask once more if the process ends by itself, too. One that was killed from outside costs
            only time in any case.
        on_step : callable
            Called with every step of the work as it begins.

        Raises
        ------
        WorkerError
            There is no reply in time, too much memory was used, or the process ended.
        OitbenchError
            The far end refused the work for a reason that the user can fix.
        """
        try:
            reply = self._exchange(self.start(), request, timeout, step, on_step)
        except WorkerError as error:
            if error.cause != "killed" and not (retry and error.cause == "ended"):
                raise
            reply = self._exchange(self.start(), request, timeout, step, on_step)
        assert isinstance(reply, kind), reply
        return reply

    def start(self) -> _Running:
        """Start the process if it does not run, and return before it is ready."""
        with self._lock:
            if self._stopped:
                raise WorkerError("the worker process was stopped", "ended")
            if self._running is None or not self._running.alive:
                if self._running is not None:
                    self._running.kill()
                self._running = _Running(
                    self._module, self._settings, self._memory_limit, self._variables
                )
            return self._running

    def rest(self) -> None:
        """Kill the process, which must be idle; the next request starts it again."""
        with self._lock:
            if self._running is not None:
                self._running.kill()

    def stop(self) -> None:
        """Kill the process and its children, for good; any thread may call this."""
        with self._lock:
            self._stopped = True
            if self._running is not None:
                self._running.kill()

    def _exchange(
        self,
        running: _Running,
        request: Struct,
        timeout: float | None,
        step: Step | None,
        on_step: OnStep,
    ) -> Struct:
        try:
            if not running.ready:
                self._receive(running, _START_SECONDS, _STARTING)
                running.ready = True
                if self._greeting is not None:
                    running.send(self._greeting)
                    self._receive(running, _START_SECONDS, _STARTING)
            running.send(request)
            return self._receive(running, timeout, step, on_step)
        except WorkerError:
            running.kill()
            raise

    def _receive(
        self,
        running: _Running,
        timeout: float | None,
        step: Step | None,
        on_step: OnStep = ignore_step,
    ) -> Struct:
        while True:
            line = running.receive(timeout, step)
            try:
                reply: Struct = self._decoder.decode(line)
            except msgspec.DecodeError:
                raise WorkerError("the worker process sent no message", "fault", step) from None
            if isinstance(reply, Fault):
                raise WorkerError(reply.message, "fault", step)
            if isinstance(reply, Refusal):
                raise getattr(errors, reply.kind, OitbenchError)(reply.message)
            if not isinstance(reply, Step):
                return reply
            step = reply
            on_step(step)


class _Running:
    """A started process and the lines that it wrote."""

    def __init__(
        self, module: str, settings: Struct, memory_limit: int, variables: Mapping[str, str]
    ) -> None:
        self._lines: Queue[bytes | None] = Queue()
        started: Queue[subprocess.Popen[bytes] | OSError] = Queue()
        # Linux kills a worker when the thread that started it ends. The thread that reads from the
        # worker lives exactly as long as it is needed.
        arguments = module, variables, started, self._lines
        host = threading.Thread(target=_host, args=arguments, daemon=True)
        host.start()
        process = started.get()
        if isinstance(process, OSError):
            raise OitbenchError(f"no worker process can be started: {process.strerror}")
        self.ready = False
        self._process, self._killing = process, threading.Lock()
        self._watch = memory.Watch(process.pid, memory_limit)
        self.send(settings)

    @property
    def alive(self) -> bool:
        return not self._has_ended()

    def send(self, message: Struct) -> None:
        """Write a line. If nobody reads it, `receive` reports that the process has ended."""
        assert self._process.stdin is not None
        with suppress(BrokenPipeError, ValueError):
            self._process.stdin.write(encode(message))
            self._process.stdin.flush()

    def receive(self, timeout: float | None, step: Step | None) -> bytes:
        """Return the next line; raise `WorkerError` if it cannot come."""
        deadline = math.inf if timeout is None else time.monotonic() + timeout
        while True:
            left = deadline - time.monotonic()
            try:
                line = self._lines.get(timeout=max(0.0, min(left, self._watch.interval)))
            except Empty:
                if self._watch.exceeded():
                    limit = f"{self._watch.limit / memory.GIB:.3g} GiB"
                    reason = f"needs more than {limit} of memory"
                    raise WorkerError(reason, "memory", step) from None
                if time.monotonic() >= deadline:
                    raise WorkerError(f"took longer than {timeout:g} s", "timeout", step) from None
                continue
            if line is None:
                code = self._wait()
                cause: Literal["killed", "ended"] = "killed" if code in _FROM_OUTSIDE else "ended"
                raise WorkerError(_describe_end(code), cause, step)
            return line

    def kill(self) -> int:
        """Kill the process and all that it started; return its exit code."""
        with self._killing:
            if self._process.returncode is None:
                # The process leads a group of its own, which includes what plugins started.
                with suppress(ProcessLookupError):
                    os.killpg(self._process.pid, signal.SIGKILL)
            code = self._process.wait()
        assert self._process.stdin is not None
        with suppress(BrokenPipeError):
            self._process.stdin.close()
        return code

    def _wait(self) -> int:
        """Wait for a process that is about to end; return its exit code."""
        deadline = time.monotonic() + _END_SECONDS
        while not self._has_ended() and time.monotonic() < deadline:
            time.sleep(0.01)
        return self.kill()

    def _has_ended(self) -> bool:
        """Return whether the process has ended; its number stays reserved until `kill`."""
        try:
            flags = os.WEXITED | os.WNOHANG | os.WNOWAIT
            return os.waitid(os.P_PID, self._process.pid, flags) is not None
        except ChildProcessError:
            return True


def _host(
    module: str,
    variables: Mapping[str, str],
    started: Queue[subprocess.Popen[bytes] | OSError],
    lines: Queue[bytes | None],
) -> None:
    """Start a process, and queue its lines until it closes its output."""
    try:
        process = subprocess.Popen(
            [sys.executable, "-c", _START, module, *sys.path],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,
            env={**os.environ, **variables},
        )
    except OSError as error:
        started.put(error)
        return
    started.put(process)
    assert process.stdout is not None
    with process.stdout:
        for line in process.stdout:
            lines.put(line)
    lines.put(None)


def _describe_end(code: int) -> str:
    if code >= 0:
        return f"the worker process ended with code {code}"
    try:
        name = signal.Signals(-code).name
    except ValueError:
        name = "unknown"
    hint = _HINTS.get(-code, "")
    return f"the worker process was ended by signal {-code} ({name}){hint}"
