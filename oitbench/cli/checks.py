"""The far end of `oitbench doctor`: a driver or a library that crashes ends only this process."""

from __future__ import annotations

import sys
from collections.abc import Callable

from msgspec import Struct

from oitbench.errors import OitbenchError
from oitbench.workers.serve import OnStep, serve


class Nothing(Struct, frozen=True):
    """There are no settings."""


class CheckOpenGL(Struct, frozen=True, tag=True):
    """Asks for the facts of the OpenGL driver."""


class CheckPathTracer(Struct, frozen=True, tag=True):
    """Asks for the facts of the path tracer."""


class Finding(Struct, frozen=True):
    """One line of the output."""

    name: str
    value: str
    well: bool = True


class Checked(Struct, frozen=True, tag=True):
    """What was found."""

    findings: list[Finding]


Request = CheckOpenGL | CheckPathTracer


def _open_gl() -> list[Finding]:
    from oitbench.gl.capabilities import CAPABILITIES
    from oitbench.gl.context import PACKAGES
    from oitbench.gl.device import Device

    try:
        device = Device()
    except OitbenchError as error:
        missing = Finding("OpenGL", str(error), well=False)
        commands = [Finding("packages", text, well=False) for text in PACKAGES.values()]
        return [missing, *(commands if sys.platform.startswith("linux") else [])]
    kind = "software: timed by wall clock" if device.software else "hardware: timed by timestamps"
    found = [
        Finding("OpenGL", f"{device.renderer}, {device.version}"),
        Finding("renderer", kind),
        Finding("largest storage block", f"{device.max_block_bytes / 2**20:g} MiB"),
    ]
    for capability in CAPABILITIES:
        answer = "yes" if device.has(capability) else "no"
        found.append(Finding(f"capability {capability}", answer))
    device.release()
    return found


def _path_tracer() -> list[Finding]:
    from oitbench.path_traced import llvm

    facts = llvm.describe()
    text = ", ".join(f"{key} {value}" for key, value in facts.items() if value)
    return [Finding("path tracer", text, facts.get("variant") is not None)]


def _begin(settings: Nothing, on_step: OnStep) -> Callable[[Request], Checked]:
    def answer(request: Request) -> Checked:
        return Checked(_open_gl() if isinstance(request, CheckOpenGL) else _path_tracer())

    return answer


def main() -> None:
    """Serve the command that started this process."""
    serve(Nothing, Request, _begin)
