"""The interface of all executors: workers that answer requests, and units of work for them."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from queue import Empty, Queue
from typing import Any, Generic, Protocol, TypeVar

from msgspec import Struct

from oitbench.places import PluginFiles
from oitbench.workers.messages import Step
from oitbench.workers.process import OnStep, WorkerError, ignore_step

Expected = TypeVar("Expected", bound=Struct)
Unit = TypeVar("Unit")
Offered = TypeVar("Offered", covariant=True)
Result = TypeVar("Result")
OnLine = Callable[[str], None]
_WAKE_SECONDS = 1.0
_RECRUIT_SECONDS = 300.0
"""Time in which a new worker must come after the last one is lost."""


class Settings(Struct, frozen=True):
    """The files of plugins, and the folder for files that belong to answers."""

    plugins: PluginFiles
    folder: Path


@dataclass(frozen=True)
class Far:
    """The far end of a worker: a module with `begin` and `main`, as `oitbench.workers.serve` wants.

    Parameters
    ----------
    module : str
    settings : Settings
    replies : type
        Union of all replies.
    greeting : Struct, optional
        A request that belongs to the start: its time does not count for the first real request.
    """

    module: str
    settings: Settings
    replies: Any
    greeting: Struct | None = None


class Worker(Protocol):
    """Answers one request at a time. Files of an answer lie in the folder when it has come."""

    @property
    def name(self) -> str:
        """The name for users."""

    def ask(
        self,
        request: Struct,
        kind: type[Expected],
        timeout: float | None = None,
        step: Step | None = None,
        retry: bool = False,
        on_step: OnStep = ignore_step,
    ) -> Expected:
        """Return the reply to a request; see `oitbench.workers.process.Process.ask`.

        Raises
        ------
        WorkerError
            Its cause is "lost" if another worker should be asked.
        """

    def rest(self) -> None:
        """End its process, which must be idle; the next request starts it again."""

    def stop(self) -> None:
        """End its process for good; any thread may call this."""


class Units(Protocol[Offered]):
    """Units of work, which workers take from the left. A deque is one."""

    def __len__(self) -> int:
        """Return how many could be taken now."""

    def popleft(self) -> Offered:
        """Return the next one."""


class Executor:
    """Workers that do units of work; a context manager, at whose end they stop.

    Parameters
    ----------
    workers : sequence of Worker
    on_line : callable
        Called with a line about each worker that is left out or lost.
    """

    def __init__(self, workers: Sequence[Worker], on_line: OnLine = lambda line: None) -> None:
        self._workers, self._busy = list(workers), list[Worker]()
        self._on_line, self._notes = on_line, deque[str]()
        self._condition, self._recruiting = threading.Condition(), threading.Lock()
        self._stopped = threading.Event()

    def __enter__(self) -> Executor:
        return self

    def __exit__(self, *error: object) -> None:
        self.stop()

    def stop(self) -> None:
        """Stop all workers."""
        self._stopped.set()
        for worker in list(self._workers):
            worker.stop()

    def admit(self, check: Callable[[Worker], None]) -> None:
        """Leave out workers for which `check` raises an error, now and when others join later.

        Workers of one machine are alike, so only the first one is checked.

        Raises
        ------
        OitbenchError
            The last error, if no worker is left.
        """
        check(self._workers[0])

    def ask(
        self,
        request: Struct,
        kind: type[Expected],
        timeout: float | None = None,
        on_step: OnStep = ignore_step,
    ) -> Expected:
        """Ask the first worker, while no other one works; see `Worker.ask`."""
        with self._seated() as seat:
            reply = seat.ask(request, kind, timeout, on_step=on_step)
        self._tell()
        return reply

    def rest(self) -> None:
        """End the processes of all workers but the first one, until they are asked again."""
        for worker in self._workers[1:]:
            worker.rest()

    def collect(
        self, units: Units[Unit], work: Callable[[Worker, Unit], Iterator[Result]]
    ) -> Iterator[Result]:
        """Yield the results of all units as they come.

        Parameters
        ----------
        units : Units
            There may be more of them with each result.
        work : callable
            Asks a worker for the results of a unit; it runs in a thread. If the worker is lost,
            another one answers in its place.

        Raises
        ------
        WorkerError
            All workers are lost.
        """
        finished: Queue[_Item[Result]] = Queue()

        def do(unit: Unit) -> None:
            try:
                with self._seated() as seat:
                    for result in work(seat, unit):
                        if self._stopped.is_set():
                            return
                        finished.put(_Result(result))
                finished.put(None)
            except BaseException as error:
                finished.put(error)

        size, running = len(self._workers), 0
        with ThreadPoolExecutor(size) as threads:
            try:
                while units or running:
                    while units and running < size:
                        threads.submit(do, units.popleft())
                        running += 1
                    item = self._next(finished)
                    if isinstance(item, BaseException):
                        raise item
                    if item is None:
                        running -= 1
                    else:
                        yield item.value
            except BaseException:
                # An interrupt or a bug must not wait for results that nobody wants.
                self.stop()
                raise
        self._tell()

    def _next(self, finished: Queue[_Item[Result]]) -> _Item[Result]:
        """Wait for the next item of a queue.

        Signals that a stopped process receives may reach any of its threads when it goes on. The
        main thread, which handles them, only notices them when it wakes up.
        """
        while True:
            self._tell()
            with suppress(Empty):
                return finished.get(timeout=_WAKE_SECONDS)

    @contextmanager
    def _seated(self) -> Iterator[_Seat]:
        seat = _Seat(self, self._take())
        try:
            yield seat
        finally:
            self._leave(seat.worker)

    def _take(self) -> Worker:
        """Return the first free worker; wait for one, or for a new one if all are lost."""
        deadline = time.monotonic() + _RECRUIT_SECONDS
        while True:
            with self._condition:
                if self._stopped.is_set():
                    raise WorkerError("the workers were stopped", "ended")
                for worker in self._workers:
                    if worker not in self._busy:
                        self._busy.append(worker)
                        return worker
                known = bool(self._workers)
            if not known and time.monotonic() > deadline:
                raise WorkerError("all workers are lost; start new ones and run again", "ended")
            with self._recruiting:
                found = self._recruit()
            with self._condition:
                self._workers += found
                if found:
                    self._condition.notify_all()
                else:
                    self._condition.wait(_WAKE_SECONDS)

    def _leave(self, worker: Worker) -> None:
        with self._condition:
            self._busy.remove(worker)
            self._condition.notify_all()

    def _replace(self, worker: Worker) -> Worker:
        """Return another worker for one that is lost."""
        self._note(f"lost: {worker.name}; another worker takes over")
        with self._condition:
            self._workers.remove(worker)
        worker.stop()
        found = self._take()
        self._leave(worker)
        return found

    def _recruit(self) -> list[Worker]:
        """Return workers that have joined since."""
        return []

    def _note(self, line: str) -> None:
        self._notes.append(line)

    def _tell(self) -> None:
        """Pass lines on, which come from any thread."""
        while self._notes:
            self._on_line(self._notes.popleft())


@dataclass
class _Seat:
    """A worker that is replaced when it is lost, and then asked again."""

    executor: Executor
    worker: Worker

    @property
    def name(self) -> str:
        return self.worker.name

    def ask(
        self,
        request: Struct,
        kind: type[Expected],
        timeout: float | None = None,
        step: Step | None = None,
        retry: bool = False,
        on_step: OnStep = ignore_step,
    ) -> Expected:
        while True:
            try:
                return self.worker.ask(request, kind, timeout, step, retry, on_step)
            except WorkerError as error:
                if error.cause != "lost":
                    raise
            self.worker = self.executor._replace(self.worker)

    def rest(self) -> None:
        self.worker.rest()

    def stop(self) -> None:
        self.worker.stop()


@dataclass(frozen=True)
class _Result(Generic[Result]):
    value: Result


_Item = _Result[Result] | BaseException | None
"""A result; an error; the end of a unit."""
