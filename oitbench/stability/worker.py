"""The far end of a process that checks and measures methods."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from msgspec import Struct

from oitbench.gl.device import Device
from oitbench.places import Places
from oitbench.plugins import Collection
from oitbench.results.schema import Renderer
from oitbench.stability import overview, suite
from oitbench.stability.overview import Overview
from oitbench.stability.result import CheckResult
from oitbench.workers.serve import OnStep, serve


class Settings(Struct, frozen=True):
    """All collection folders, and the file of each method that is used, by its name."""

    collections: list[bytes]
    methods: dict[str, bytes]


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


def _begin(settings: Settings, on_step: OnStep) -> Callable[[Request], Reply]:
    places = Places(map(_path, settings.collections))
    for name, path in settings.methods.items():
        places.methods.add(name, _path(path))
    collection, device = Collection(places), Device()
    examiner = suite.Examiner(device, collection)
    checks = {check.name: check for check in suite.checks()}

    def answer(request: Request) -> Reply:
        if isinstance(request, Hello):
            gl = Renderer(device.renderer, version=device.version, software=device.software)
            return Greeting(gl)
        (method,) = collection.expand_methods([request.method])
        if isinstance(request, Measure):
            return Measured(overview.measure(device, [method]))
        return Examined(examiner.examine(checks[request.check], method))

    return answer


def _path(encoded: bytes) -> Path:
    return Path(os.fsdecode(encoded))


def main() -> None:
    """Serve the process that started this one."""
    serve(Settings, Request, _begin)
