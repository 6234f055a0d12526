"""A process that renders cells: names come in, records go out, one JSON line each.

A crash, a hang or a leak in a driver then costs one cell and not the run. The other end is
`WorkerProcess`; both speak over standard input and output, so that a worker could as well sit at
the end of a network connection.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from queue import Empty, Queue
from typing import IO, Any

from oitbench.errors import CapabilityError, OitbenchError
from oitbench.matrix.cell import Bench, Cell
from oitbench.plugins import Collection
from oitbench.results.store import sanitize

Message = dict[str, Any]
_START_SECONDS = 120.0


class WorkerError(OitbenchError):
    """The worker died or took too long; `timeout` tells which."""

    def __init__(self, reason: str, timeout: bool) -> None:
        super().__init__(reason)
        self.timeout = timeout


class WorkerProcess:
    """The near end of a worker: starts it, asks it, kills it.

    Parameters
    ----------
    collections : sequence of Path
        Extra collection folders.
    methods : sequence of Path
        Extra method folders.
    folder : Path
        The results folder.
    """

    def __init__(self, collections: Sequence[Path], methods: Sequence[Path], folder: Path) -> None:
        self._settings = {
            "collections": [str(path) for path in collections],
            "methods": [str(path) for path in methods],
            "folder": str(folder),
        }
        self._process: subprocess.Popen[str] | None = None
        self._replies: Queue[str | None] = Queue()

    def ask(self, message: Message, timeout: float | None) -> Message:
        """Send one message and wait for its reply.

        Raises
        ------
        WorkerError
            No reply within `timeout` seconds, or the process ended.
        OitbenchError
            The worker could not start work, for a reason that the user can mend.
        """
        if self._process is None:
            self._start()
            # A process that starts late must not eat up the time of its first cell.
            self._exchange({"verb": "hello"}, _START_SECONDS)
        return self._exchange(message, timeout)

    def _exchange(self, message: Message, timeout: float | None) -> Message:
        assert self._process is not None
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(json.dumps(message) + "\n")
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
        reply: Message = json.loads(line)
        if "error" in reply:
            kind = CapabilityError if reply["kind"] == "CapabilityError" else OitbenchError
            raise kind(reply["error"])
        return reply

    def _start(self) -> None:
        self._replies = Queue()
        self._process = subprocess.Popen(
            [sys.executable, "-m", "oitbench.matrix.worker", json.dumps(self._settings)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            encoding="utf-8",
        )
        assert self._process.stdout is not None
        threading.Thread(
            target=_pump, args=(self._process.stdout, self._replies), daemon=True
        ).start()

    def stop(self) -> None:
        """End the process, if there is one."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None


def _pump(lines: IO[str], replies: Queue[str | None]) -> None:
    for line in lines:
        replies.put(line)
    replies.put(None)


def to_message(cell: Cell) -> Message:
    """Return the cell in JSON's own types."""
    return {**asdict(cell), "size": list(cell.size)}


def _from_message(facts: Message) -> Cell:
    return Cell(**{**facts, "size": tuple(facts["size"])})


def _answer(bench: Bench, message: Message) -> Message:
    if message["verb"] == "hello":
        device = bench.device
        info = device.context.info
        return {
            "gl": {
                "vendor": info["GL_VENDOR"],
                "renderer": device.renderer,
                "version": device.version,
                "software": device.software,
            }
        }
    if message["verb"] == "run":
        record = bench.run(_from_message(message["cell"]), message["path_traced"])
        return {"record": record, "spent": bench.watch.take()}
    cells = [_from_message(facts) for facts in message["cells"]]
    times = bench.time(cells, message["rounds"], message["budget"])
    return {"times": times, "spent": bench.watch.take()}


def main() -> None:
    """Serve until standard input ends."""
    # Whatever a library prints must not end up between the replies.
    replies = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    settings = json.loads(sys.argv[1])
    bench: Bench | None = None
    for line in sys.stdin:
        try:
            if bench is None:
                collection = Collection.load(map(Path, settings["collections"]))
                for folder in settings["methods"]:
                    collection.add_method(Path(folder))
                bench = Bench(collection, Path(settings["folder"]))
            reply = _answer(bench, json.loads(line))
        except OitbenchError as error:
            reply = {"error": str(error), "kind": type(error).__name__}
        replies.write(json.dumps(sanitize(reply), allow_nan=False) + "\n")
        replies.flush()


if __name__ == "__main__":
    main()
