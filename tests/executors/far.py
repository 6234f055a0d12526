"""The far end of a worker that does what a test asks for."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable
from pathlib import Path

from msgspec import Struct

from oitbench.errors import UsageError
from oitbench.executors.executor import Far, Settings
from oitbench.places import PluginFiles
from oitbench.workers.messages import Step
from oitbench.workers.serve import OnStep, serve


class Act(Struct, frozen=True, tag=True):
    """Asks for an action by its name; it fails to happen again if the file `mark` exists."""

    action: str
    mark: str = ""


class Done(Struct, frozen=True, tag=True):
    """The answer, the process that gave it, and the threads that its libraries may start."""

    text: str
    pid: int
    threads: str = ""


def far_end(folder: Path) -> Far:
    return Far(__name__, Settings(PluginFiles([]), folder), Done, Act("greet"))


def _act(request: Act, folder: Path) -> None:
    if request.mark:
        try:
            os.close(os.open(request.mark, os.O_CREAT | os.O_EXCL))
        except FileExistsError:
            return
    match request.action:
        case "write":
            (folder / "images").mkdir(exist_ok=True)
            (folder / "images" / "one.bin").write_bytes(bytes(range(256)))
        case "be killed":
            os.kill(os.getpid(), signal.SIGKILL)
        case "kill the worker":
            os.kill(os.getppid(), signal.SIGKILL)
            time.sleep(60)
        case "exit":
            os._exit(7)
        case "hang":
            time.sleep(60)
        case "refuse":
            raise UsageError("no")


def begin(settings: Settings, on_step: OnStep) -> Callable[[Act], Done]:
    def answer(request: Act) -> Done:
        on_step(Step("acting", shared=True))
        _act(request, settings.folder)
        return Done(request.action, os.getpid(), os.environ.get("OMP_NUM_THREADS", ""))

    return answer


def main() -> None:
    serve(Settings, Act, begin)
