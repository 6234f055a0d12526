"""The near end of a worker process: starts it, asks it, kills it."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Sequence
from pathlib import Path
from queue import Empty, Queue
from typing import IO, TypeVar

import msgspec

from oitbench.errors import CapabilityError, OitbenchError, StorageError
from oitbench.matrix.worker import Hello, Refusal, Reply, Request, Settings

_START_SECONDS = 120.0
Expected = TypeVar("Expected")


class WorkerError(OitbenchError):
    """The worker ended, or took longer than allowed if `timeout` is set."""

    def __init__(self, reason: str, timeout: bool) -> None:
        super().__init__(reason)
        self.timeout = timeout


class WorkerProcess:
    """A worker process; it starts with the first request.

    Parameters
    ----------
    collections : sequence of Path
        Further collection folders.
    methods : sequence of Path
        Further method folders.
    folder : Path
        The results folder.
    """

    def __init__(self, collections: Sequence[Path], methods: Sequence[Path], folder: Path) -> None:
        self._settings = Settings(list(map(str, collections)), list(map(str, methods)), str(folder))
        self._process: subprocess.Popen[bytes] | None = None
        self._replies: Queue[bytes | None] = Queue()
        self._decoder = msgspec.json.Decoder(Reply)

    def ask(self, request: Request, kind: type[Expected], timeout: float | None = None) -> Expected:
        """Send a request and wait for a reply of type `kind`.

        Raises
        ------
        WorkerError
            There is no reply within `timeout` seconds, or the process ended.
        OitbenchError
            The worker could not begin, for a reason that the user can fix.
        """
        if self._process is None:
            self._start()
            # The time that a process takes to start must not count for its first cell.
            self._exchange(Hello(), _START_SECONDS)
        reply = self._exchange(request, timeout)
        assert isinstance(reply, kind)
        return reply

    def _exchange(self, request: Request, timeout: float | None) -> Reply:
        assert self._process is not None
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(msgspec.json.encode(request) + b"\n")
            self._process.stdin.flush()
            line = self._replies.get(timeout=timeout)
        except Empty:
            self.stop()
            raise WorkerError(f"took longer than {timeout:g} s", timeout=True) from None
        except BrokenPipeError:
            line = None
        if line is None:
            code = self._process.wait()
            self._process = None
            raise WorkerError(f"the worker process ended with code {code}", timeout=False)
        reply: Reply = self._decoder.decode(line)
        if isinstance(reply, Refusal):
            kinds = {kind.__name__: kind for kind in (CapabilityError, StorageError)}
            raise kinds.get(reply.kind, OitbenchError)(reply.message)
        return reply

    def _start(self) -> None:
        self._replies = Queue()
        settings = msgspec.json.encode(self._settings).decode()
        self._process = subprocess.Popen(
            [sys.executable, "-m", "oitbench.matrix.worker", settings],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )
        assert self._process.stdout is not None
        threading.Thread(
            target=_pump, args=(self._process.stdout, self._replies), daemon=True
        ).start()

    def stop(self) -> None:
        """End the process if it runs."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None


def _pump(lines: IO[bytes], replies: Queue[bytes | None]) -> None:
    for line in lines:
        replies.put(line)
    replies.put(None)
