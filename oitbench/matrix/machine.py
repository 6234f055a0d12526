"""The facts of a run: on what it ran, so that a number can be told from another machine's."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import re
import subprocess
from collections.abc import Mapping, Sequence
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

_PACKAGES = (
    "oitbench",
    "mitsuba",
    "drjit",
    "moderngl",
    "numpy",
    "scikit-image",
    "flip-evaluator",
    "OpenEXR",
)
_SOFTWARE_RENDERERS = ("llvmpipe", "softpipe", "swrast", "swiftshader", "lavapipe")


def collect(
    gl: Mapping[str, Any] | None,
    *,
    argv: Sequence[str],
    seed: int,
    methods: Sequence[str] = (),
    llvm: str | None = None,
) -> dict[str, Any]:
    """Return the facts for `run.json`, without importing any heavy package.

    Parameters
    ----------
    gl : mapping, optional
        `vendor`, `renderer` and `version` as the GL context tells them; None without a context.
    argv : sequence of str
        The command line.
    seed : int
        The run's seed.
    methods : sequence of str
        Names of all known methods, so that each keeps its color in every report.
    llvm : str, optional
        Version or path of the LLVM library that the path tracer uses.
    """
    return {
        "gl": _gl_facts(gl),
        "mesa": mesa_version(str(gl.get("version", ""))) if gl else None,
        "cpu": {"model": cpu_model(), "cores": os.cpu_count()},
        "os": platform.platform(),
        "python": platform.python_version(),
        "packages": {name: package_version(name) for name in _PACKAGES},
        "llvm": llvm,
        "git": git_state(Path(__file__).parent),
        "argv": list(argv),
        "seed": seed,
        "methods": sorted(methods),
        "date": datetime.now(timezone.utc).isoformat(timespec="seconds"),
    }


def is_software(renderer: str) -> bool:
    """Tell whether a GL renderer string names one that draws on the CPU."""
    return any(name in renderer.lower() for name in _SOFTWARE_RENDERERS)


def mesa_version(gl_version: str) -> str | None:
    """Return "22.3.6" from "4.5 (Core Profile) Mesa 22.3.6", or None without Mesa."""
    match = re.search(r"Mesa (\S+)", gl_version)
    return match[1] if match else None


def cpu_model() -> str:
    """Return the processor's name, as Linux or else the Python platform tells it."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace")
    except OSError:
        text = ""
    match = re.search(r"^model name\s*:\s*(.+)$", text, re.MULTILINE)
    return match[1].strip() if match else platform.processor() or platform.machine()


def package_version(name: str) -> str | None:
    """Return the version of an installed package, or None."""
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return None


def git_state(folder: Path) -> dict[str, Any] | None:
    """Return commit and dirtiness of the checkout that tracks `folder`, or None."""
    commit = _git(folder, "rev-parse", "HEAD")
    tracked = _git(folder, "ls-files", "--", ".")
    if not commit or not tracked:
        return None
    return {"commit": commit, "modified": bool(_git(folder, "status", "--porcelain", "-uno"))}


def _git(folder: Path, *arguments: str) -> str | None:
    try:
        answer = subprocess.run(
            ["git", "-C", str(folder), *arguments], capture_output=True, text=True, timeout=10
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    return answer.stdout.strip() if answer.returncode == 0 else None


def _gl_facts(gl: Mapping[str, Any] | None) -> dict[str, Any] | None:
    if gl is None:
        return None
    renderer = str(gl.get("renderer", ""))
    return {
        "vendor": gl.get("vendor"),
        "renderer": renderer,
        "version": gl.get("version"),
        "software": bool(gl.get("software", is_software(renderer))),
    }
