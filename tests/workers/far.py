"""A worker that does what a test asks for."""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable

from msgspec import Struct

from oitbench.errors import UsageError
from oitbench.workers.messages import Step
from oitbench.workers.serve import OnStep, serve

_NEW = os.O_CREAT | os.O_EXCL


class Word(Struct, frozen=True):
    """The settings: a word that the worker repeats."""

    text: str


class Act(Struct, frozen=True, tag=True):
    """Asks for an action by its name."""

    action: str


class Done(Struct, frozen=True, tag=True):
    """The answer of the action."""

    text: str


def _act(action: str, on_step: OnStep) -> str:
    match action:
        case "exit":
            os._exit(7)
        case "crash":
            os.kill(os.getpid(), signal.SIGSEGV)
        case "hang":
            time.sleep(600)
        case "hang without a break":
            # Holds Python's lock, so no other thread of the process runs.
            ctypes.PyDLL(None).sleep(600)
        case "hang in a shared step":
            on_step(Step("digging", shared=True))
            time.sleep(600)
        case "four steps of 0.7 s":
            for number in range(4):
                on_step(Step(f"step {number}"))
                time.sleep(0.7)
        case "print":
            print("from Python", flush=True)
            os.write(1, b'{"type":"Done","text":"wrong"}\n')
        case "read":
            return repr(sys.stdin.read())
        case "allocate":
            kept = []
            while True:
                kept.append(bytearray(os.urandom(2**20)) * 16)
        case "allocate in a child":
            code = "import time; x = bytearray(2**20) * 400; time.sleep(600)"
            subprocess.run([sys.executable, "-c", code], check=False)
        case "start a child":
            sleeper = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
            return str(sleeper.pid)
        case "refuse":
            raise UsageError("three is\ntoo many")
        case "fail":
            raise ZeroDivisionError("by nought")
        case "quit":
            sys.exit("enough")
        case "be killed":
            os.kill(os.getpid(), signal.SIGKILL)
        case text if text.startswith("be killed at first, by "):
            try:
                os.close(os.open(text.removeprefix("be killed at first, by "), _NEW))
            except FileExistsError:
                return "second"
            os.kill(os.getpid(), signal.SIGKILL)
        case text if text.startswith("exit at first, by "):
            try:
                os.close(os.open(text.removeprefix("exit at first, by "), _NEW))
            except FileExistsError:
                return "second"
            os._exit(7)
        case "number":
            return str(os.getpid())
    return "fine"


def _begin(settings: Word, on_step: OnStep) -> Callable[[Act], Done]:
    return lambda request: Done(_act(request.action, on_step) + settings.text)


def main() -> None:
    serve(Word, Act, _begin)
