"""The far end of a worker process: answers requests until its parent is gone."""

from __future__ import annotations

import ctypes
import io
import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from queue import Queue
from typing import IO, Any, TypeVar

from msgspec import Struct

from oitbench.errors import OitbenchError, printable
from oitbench.workers.messages import Fault, Ready, Refusal, Step, decoder, encode

Settings = TypeVar("Settings", bound=Struct)
Answer = Callable[[Any], Struct]
OnStep = Callable[[Step], None]

_PR_SET_PDEATHSIG = 1
_FIRST_VICTIM = "1000"


def serve(
    settings_type: type[Settings],
    requests: Any,
    begin: Callable[[Settings, OnStep], Answer],
) -> None:
    """Answer requests until the parent closes the pipe or ends.

    Parameters
    ----------
    settings_type : type
        Of the first line, which is not answered.
    requests : type
        Union of all requests.
    begin : callable
        Called with the settings before the first request; returns the function that answers. It
        also receives a function that reports the steps of the work.
    """
    incoming, outgoing = _claim_streams()
    _end_with_parent()

    def send(message: Struct) -> None:
        line = encode(message)
        try:
            outgoing.write(line)
            outgoing.flush()
        except BrokenPipeError:
            os._exit(1)  # The parent is gone, and with it everybody who would read a traceback.

    lines = _read_lines(incoming)
    settings = decoder(settings_type).decode(lines.get())
    read_request = decoder(requests).decode
    send(Ready())
    answer: Answer | None = None
    while True:
        request = read_request(lines.get())
        try:
            answer = answer or begin(settings, send)
            send(answer(request))
        except OitbenchError as error:
            send(Refusal(str(error), type(error).__name__))
        except BaseException as error:
            traceback.print_exc()
            send(Fault(printable(f"{type(error).__name__}: {error}")))
            raise SystemExit(1) from error


def _claim_streams() -> tuple[IO[bytes], IO[bytes]]:
    """Return the pipes from and to the parent, and hide them from the plugins.

    What a plugin or a library prints goes to standard error, and its standard input is empty.
    """
    incoming, outgoing = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    os.dup2(2, 1)
    if isinstance(sys.stdout, io.TextIOWrapper):
        # The process may be killed at any time, and nothing that was printed must be lost.
        sys.stdout.reconfigure(line_buffering=True)
    return incoming, outgoing


def _end_with_parent() -> None:
    """Let the kernel kill this process when the parent ends, and first when memory runs out."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, int(signal.SIGKILL), 0, 0, 0)
        with suppress(OSError):
            Path("/proc/self/oom_score_adj").write_text(_FIRST_VICTIM, encoding="ascii")


def _read_lines(incoming: IO[bytes]) -> Queue[bytes]:
    """Return a queue of the lines of a pipe; the process ends at its end, busy or not."""
    lines: Queue[bytes] = Queue()

    def read() -> None:
        for line in incoming:
            lines.put(line)
        os._exit(1)

    threading.Thread(target=read, daemon=True).start()
    return lines
