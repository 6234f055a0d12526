"""The process of the command, for debuggers: a crash, or work without an end, ends the command."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from importlib import import_module
from typing import Any

from msgspec import Struct

from oitbench.executors.executor import (
    Executor,
    Expected,
    Far,
    OnLine,
    Result,
    Unit,
    Units,
    Worker,
)
from oitbench.workers.messages import Step
from oitbench.workers.process import OnStep, ignore_step


class OwnWorker:
    """The process of the command. No time or memory is limited, and bugs raise where they are."""

    name = "this process"

    def __init__(self, far: Far) -> None:
        self._far = far
        self._answer: Callable[[Any], Struct] | None = None
        self._on_step: OnStep = ignore_step

    def ask(
        self,
        request: Struct,
        kind: type[Expected],
        timeout: float | None = None,
        step: Step | None = None,
        retry: bool = False,
        on_step: OnStep = ignore_step,
    ) -> Expected:
        """Answer a request."""
        if self._answer is None:
            begin = import_module(self._far.module).begin
            self._answer = begin(self._far.settings, lambda step: self._on_step(step))
        self._on_step = on_step
        reply = self._answer(request)
        assert isinstance(reply, kind), reply
        return reply

    def rest(self) -> None:
        """Do nothing."""

    def stop(self) -> None:
        """Drop everything that was loaded."""
        self._answer = None


class InProcess(Executor):
    """The process of the command, in its main thread.

    Parameters
    ----------
    far : Far
    on_line : callable
        See `Executor`.
    """

    def __init__(self, far: Far, on_line: OnLine) -> None:
        self._worker = OwnWorker(far)
        super().__init__([self._worker], on_line)

    def collect(
        self, units: Units[Unit], work: Callable[[Worker, Unit], Iterator[Result]]
    ) -> Iterator[Result]:
        """Do one unit after another."""
        while units:
            yield from work(self._worker, units.popleft())
