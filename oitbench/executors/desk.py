"""The far end of a worker of a cluster: a desk beside its process, on the worker's machine.

A desk is the result of a task, and every request to it is a short task on the same machine. So it
vanishes with its client, its process too, and a client notices at once when a machine is lost.
"""

from __future__ import annotations

import tempfile
import threading
import time
import weakref
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from queue import Empty, Queue
from typing import Any, NoReturn

import msgspec
from msgspec import Struct

from oitbench.errors import OitbenchError
from oitbench.executors.executor import Far
from oitbench.executors.inventory import relocated
from oitbench.workers import memory
from oitbench.workers.messages import Step
from oitbench.workers.process import Process, WorkerError

LEASE_SECONDS = 60.0
"""A request ends when nobody has looked for its answer for so long: its client is gone."""


@dataclass(frozen=True)
class Question:
    """A request; the fields are the arguments of `Process.ask`, and a number of its own."""

    number: int
    request: Struct
    kind: type[Struct]
    timeout: float | None
    step: Step | None
    retry: bool


@dataclass(frozen=True)
class Answer:
    """A reply or an error, and the files that the process has written, by their paths."""

    reply: Struct | None
    error: OitbenchError | None
    files: dict[str, bytes] = field(default_factory=dict)


class Desk:
    """A process with a folder of its own.

    Parameters
    ----------
    far : Far
        The process, as the client would start it.
    home : Path
        Folder of the suite's own collection on the client's machine.
    memory_gib : float, optional
        Memory that the process may use, in GiB. Default: 75 % of the machine's, divided by the
        number of workers there.
    neighbors : int
        Workers on this machine, with this one.
    """

    def __init__(self, far: Far, home: Path, memory_gib: float | None, neighbors: int) -> None:
        self._place = tempfile.TemporaryDirectory(prefix="oitbench-")
        self._folder = Path(self._place.name)
        settings: Any = msgspec.structs.replace(
            far.settings, plugins=relocated(far.settings.plugins, home), folder=self._folder
        )
        limit = memory.limit(memory_gib, neighbors)
        self._process = Process(far.module, settings, far.replies, limit, far.greeting)
        weakref.finalize(self, self._process.stop)
        self._process.start()
        self._number = 0
        self._answers: Queue[Answer] = Queue()
        self._seen = time.monotonic()

    def __reduce__(self) -> NoReturn:
        raise TypeError("a desk stays on its machine")

    def begin(self, question: Question) -> None:
        """Start work on a question."""
        self._number, self._seen = question.number, time.monotonic()
        self._answers = Queue()
        worker = threading.Thread(target=self._work, args=(question, self._answers), daemon=True)
        worker.start()
        threading.Thread(target=self._watch, args=(worker,), daemon=True).start()

    def poll(self, number: int, seconds: float) -> Answer | None:
        """Wait for the answer of a question for some seconds.

        Raises
        ------
        WorkerError
            It was asked of an earlier desk, which is lost.
        """
        self._seen = time.monotonic()
        if number != self._number:
            raise WorkerError("the worker was started again", "lost")
        with suppress(Empty):
            return self._answers.get(timeout=seconds)
        return None

    def rest(self) -> None:
        """End the process, which must be idle; the next request starts it again."""
        self._process.rest()

    def close(self) -> None:
        """End the process for good."""
        self._process.stop()

    def _work(self, question: Question, answers: Queue[Answer]) -> None:
        reply: Struct | None = None
        error: OitbenchError | None = None
        try:
            reply = self._process.ask(
                question.request, question.kind, question.timeout, question.step, question.retry
            )
        except OitbenchError as caught:
            error = caught
        answers.put(Answer(reply, error, self._take_files()))

    def _take_files(self) -> dict[str, bytes]:
        """Return the files that are complete, and remove them."""
        found: dict[str, bytes] = {}
        for path in self._folder.rglob("*"):
            if path.is_file() and not path.name.startswith("."):
                found[path.relative_to(self._folder).as_posix()] = path.read_bytes()
                path.unlink()
        return found

    def _watch(self, worker: threading.Thread) -> None:
        while worker.is_alive():
            worker.join(1.0)
            if time.monotonic() - self._seen > LEASE_SECONDS:
                self._number = 0
                self._process.stop()
                return
