"""The workers of an existing Dask cluster. Files of answers come back with them, as bytes.

Each machine has the same version of the suite and of the packages that matter, and its own copy of
the suite's collection; further plugins lie at the same paths. A worker that has others is left out.
"""

from __future__ import annotations

import itertools
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any
from urllib.parse import urlparse

from distributed import CancelledError, Client, Future, TimeoutError
from msgspec import Struct

from oitbench.atomic import partial_file
from oitbench.errors import OitbenchError, UsageError
from oitbench.executors import inventory
from oitbench.executors.desk import Answer, Desk, Question
from oitbench.executors.executor import Executor, Expected, Far, OnLine, Worker
from oitbench.places import own_folder
from oitbench.workers.messages import Step
from oitbench.workers.process import OnStep, WorkerError, ignore_step

_CONNECT_SECONDS = 15.0
_CLOSE_SECONDS = 3.0
_POLL_SECONDS = 1.0
_LOOK_SECONDS = 2.0
"""How often a client asks whether the worker that it waits for still exists."""
_GATHER_SECONDS = 30.0
"""Time in which a result must come to the client; it is asked for again if its worker exists."""


class DaskWorker:
    """A worker of the cluster.

    Parameters
    ----------
    client : Client
    address : str
    desk : Future
        Of a `Desk`.
    save : callable
        Writes files by their paths below the folder.
    """

    def __init__(
        self,
        client: Client,
        address: str,
        desk: Future[Desk],
        save: Callable[[dict[str, bytes]], None],
    ) -> None:
        self.name, self._client, self._desk, self._save = address, client, desk, save
        self._numbers = itertools.count(1)
        self._stopped, self.closed = threading.Event(), threading.Event()

    def ask(
        self,
        request: Struct,
        kind: type[Expected],
        timeout: float | None = None,
        step: Step | None = None,
        retry: bool = False,
        on_step: OnStep = ignore_step,
    ) -> Expected:
        """Return the reply to a request; the cause of a `WorkerError` may be "lost".

        Steps are not passed on: they would need a connection of their own.
        """
        number = next(self._numbers)
        self._call(Desk.begin, Question(number, request, kind, timeout, step, retry))
        answer: Answer | None = None
        while answer is None:
            answer = self._call(Desk.poll, number, _POLL_SECONDS)
        self._save(answer.files)
        if answer.error is not None:
            raise answer.error
        assert isinstance(answer.reply, kind), answer.reply
        return answer.reply

    def rest(self) -> None:
        """End its process, which must be idle; the next request starts it again."""
        self._call(Desk.rest)

    def stop(self) -> None:
        """End its process for good, with no wait for it."""
        if not self._stopped.is_set():
            self._stopped.set()
            # The desk goes when its future does; this ends a request that still runs.
            self._closing = self._submit(Desk.close)
            self._closing.add_done_callback(lambda _: self.closed.set())

    def _submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        return submit(self._client, self.name, function, self._desk, *arguments)

    def _call(self, function: Callable[..., Any], *arguments: Any) -> Any:
        if self._stopped.is_set():
            raise WorkerError("the worker was stopped", "ended")
        return result(self._client, self.name, self._submit(function, *arguments))


class Cluster(Executor):
    """All workers of a Dask scheduler, and those that join when others are lost.

    Parameters
    ----------
    far : Far
    address : str
        Of the scheduler.
    memory_gib : float, optional
        See `Desk`.
    on_line : callable
        See `Executor`.

    Raises
    ------
    UsageError
        The scheduler does not answer, or has no worker of the same code and plugins.
    """

    def __init__(self, far: Far, address: str, memory_gib: float | None, on_line: OnLine) -> None:
        super().__init__([], on_line)
        self._far, self._memory_gib, self._home = far, memory_gib, own_folder()
        self._saving = threading.Lock()
        self._inventory = inventory.take(far.settings.plugins, self._home)
        self._known: set[str] = set()
        self._check: Callable[[Worker], None] = lambda worker: None
        try:
            self._client = Client(address, timeout=_CONNECT_SECONDS, set_as_default=False)
        except (OSError, ValueError) as error:
            raise UsageError(
                f"no Dask scheduler answers at {address}; start one by: dask scheduler"
            ) from error
        try:
            self._workers += self._recruit()
            if not self._workers:
                reason = "; ".join(self._notes) or f"{address} has none; run: dask worker {address}"
                raise UsageError(f"no worker of the cluster can be used: {reason}")
        except BaseException:
            self._client.close()
            raise
        self._tell()

    def admit(self, check: Callable[[Worker], None]) -> None:
        """Leave out workers for which `check` raises an error, now and when others join later."""
        self._check = check
        errors = {worker: self._passes(worker) for worker in self._workers}
        self._workers = [worker for worker, error in errors.items() if error is None]
        self._tell()
        if not self._workers:
            raise next(error for error in errors.values() if error is not None)

    def stop(self) -> None:
        """Stop all workers, and leave the cluster as it was."""
        super().stop()
        for worker in self._workers:
            if isinstance(worker, DaskWorker):
                worker.closed.wait(_CLOSE_SECONDS)
        self._client.close()

    def _recruit(self) -> list[Worker]:
        """Return workers that are new and have the same code and plugins."""
        try:
            addresses = sorted(self._client.nthreads())
        except OSError as error:
            raise WorkerError("the Dask scheduler is lost; run again", "ended") from error
        neighbors = Counter(map(_host, addresses))
        fresh = [address for address in addresses if address not in self._known]
        self._known |= {*fresh}
        plugins = self._far.settings.plugins
        taken = {
            address: submit(self._client, address, inventory.take, plugins, self._home)
            for address in fresh
        }
        found: dict[str, Future[Desk]] = {}
        for address, future in taken.items():
            reason = self._why_not(address, future)
            if reason:
                self._note(f"left out: {address}: {reason}")
                continue
            count = neighbors[_host(address)]
            found[address] = submit(
                self._client, address, Desk, self._far, self._home, self._memory_gib, count
            )
        workers = [DaskWorker(self._client, *item, self._save) for item in found.items()]
        return [worker for worker in workers if self._passes(worker) is None]

    def _passes(self, worker: Worker) -> OitbenchError | None:
        """Return the error for which a worker is left out, or None."""
        try:
            self._check(worker)
        except OitbenchError as error:
            worker.stop()
            self._note(f"left out: {worker.name}: {error}")
            return error
        return None

    def _why_not(self, address: str, future: Future[inventory.Inventory]) -> str:
        """Return why a worker cannot be used, or ""."""
        try:
            found = result(self._client, address, future)
        except OitbenchError as error:
            return str(error)
        except Exception as error:
            return f"{type(error).__name__}: {error}; install oitbench there"
        return inventory.difference(self._inventory, found)

    def _save(self, files: dict[str, bytes]) -> None:
        """Write files of an answer; several workers may send the same file."""
        folder = self._far.settings.folder
        with self._saving:
            for name, content in files.items():
                with partial_file(folder / name) as partial:
                    partial.write_bytes(content)
                    partial.replace(folder / name)


def submit(
    client: Client, address: str, function: Callable[..., Any], *arguments: Any
) -> Future[Any]:
    """Return the future of a task that only this worker may do, and that is done anew."""
    return client.submit(
        function, *arguments, workers=[address], allow_other_workers=False, pure=False
    )


def result(client: Client, address: str, future: Future[Any]) -> Any:
    """Wait for the result of a task.

    Raises
    ------
    WorkerError
        The worker is gone.
    Exception
        That of the task.
    """
    ended = threading.Event()
    future.add_done_callback(lambda _: ended.set())
    while True:
        done = ended.wait(_LOOK_SECONDS)
        try:
            if done and future.status in ("finished", "error"):
                # Its worker may be lost with the result, which then never comes.
                return future.result(timeout=_GATHER_SECONDS)
        except TimeoutError:
            pass
        except CancelledError as error:
            raise WorkerError("the worker is gone", "lost") from error
        if address not in _addresses(client) or future.status in ("cancelled", "lost"):
            future.release()
            raise WorkerError("the worker is gone", "lost")
        if done:
            time.sleep(_LOOK_SECONDS)


def _addresses(client: Client) -> Iterable[str]:
    try:
        found: Iterable[str] = client.nthreads()
    except OSError:
        return ()
    return found


def _host(address: str) -> str:
    return urlparse(address).hostname or Path(address).name
