"""The far end of a process that checks and measures methods."""

from __future__ import annotations

from collections.abc import Callable

from msgspec import Struct

from oitbench.gl.device import Device
from oitbench.places import PluginFiles
from oitbench.plugins import Collection
from oitbench.results.schema import Renderer
from oitbench.stability import overview, suite
from oitbench.stability.overview import Overview
from oitbench.stability.result import CheckResult
from oitbench.workers.serve import OnStep, serve


class Hello(Struct, frozen=True, tag=True):
    """Asks for a greeting."""


class Examine(Struct, frozen=True, tag=True):
    """Asks for the result of one check of one method; `method` is a label."""

    check: str
    method: str


class Measure(Struct, frozen=True, tag=True):
    """Asks for the overview of one method; `method` is a label."""

    method: str


class Greeting(Struct, frozen=True, tag=True):
    """The renderer of the worker."""

    gl: Renderer


class Examined(Struct, frozen=True, tag=True):
    """The result of a check."""

    result: CheckResult


class Measured(Struct, frozen=True, tag=True):
    """The overview of a method; empty if the driver cannot render it."""

    rows: list[Overview]


Request = Hello | Examine | Measure
Reply = Greeting | Examined | Measured


def _begin(files: PluginFiles, on_step: OnStep) -> Callable[[Request], Reply]:
    collection, device = Collection(files.places()), Device()
    examiner = suite.Examiner(device, collection)
    checks = {check.name: check for check in suite.checks()}

    def answer(request: Request) -> Reply:
        if isinstance(request, Hello):
            return Greeting(Renderer.of(device))
        (method,) = collection.expand_methods([request.method])
        if isinstance(request, Measure):
            return Measured(overview.measure(device, [method]))
        return Examined(examiner.examine(checks[request.check], method))

    return answer


def main() -> None:
    """Serve the process that started this one."""
    serve(PluginFiles, Request, _begin)
