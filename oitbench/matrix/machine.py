"""The facts about the machine and the command of a run, so that numbers can be traced to them."""

from __future__ import annotations

import platform
import re
import subprocess
from collections.abc import Sequence
from datetime import datetime, timezone
from pathlib import Path

from oitbench.errors import printable
from oitbench.fingerprints.code import PACKAGES, package_version
from oitbench.results.schema import Commit, Renderer, RunFacts
from oitbench.results.times import Processor
from oitbench.workers.cores import usable_cores

_GOVERNOR = Path("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor")


def collect(
    gl: Renderer | None,
    *,
    argv: Sequence[str],
    seed: int,
    methods: Sequence[str] = (),
    llvm: str | None = None,
) -> RunFacts:
    """Return the facts of a run; no heavy package is imported.

    Parameters
    ----------
    gl : Renderer, optional
        None without an OpenGL context.
    argv : sequence of str
        The command line.
    seed : int
        The seed of the run.
    methods : sequence of str
        Names of all known methods, so that each keeps its color in every report.
    llvm : str, optional
        Version or path of the LLVM library that the path tracer uses.
    """
    return RunFacts(
        gl=gl,
        mesa=mesa_version(gl.version) if gl else None,
        cpu=processor(),
        os=platform.platform(),
        python=platform.python_version(),
        packages={name: package_version(name) for name in PACKAGES},
        llvm=llvm,
        git=git_state(Path(__file__).parent),
        argv=[printable(argument) for argument in argv],
        seed=seed,
        methods=sorted(methods),
        date=datetime.now(timezone.utc).isoformat(timespec="seconds"),
    )


def mesa_version(gl_version: str) -> str | None:
    """Return "22.3.6" for "4.5 (Core Profile) Mesa 22.3.6", or None without Mesa."""
    match = re.search(r"Mesa (\S+)", gl_version)
    return match[1] if match else None


def processor() -> Processor:
    """Return the facts of the processor; those that the system does not tell are None."""
    return Processor(cpu_model(), len(usable_cores()), governor())


def governor() -> str | None:
    """Return the rule by which Linux chooses the clock frequency, or None."""
    try:
        return _GOVERNOR.read_text(encoding="utf-8").strip() or None
    except OSError:
        return None


def cpu_model() -> str:
    """Return the name of the processor that Linux, or else the Python platform, reports."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace")
    except OSError:
        text = ""
    match = re.search(r"^model name\s*:\s*(.+)$", text, re.MULTILINE)
    return match[1].strip() if match else platform.processor() or platform.machine()


def git_state(folder: Path) -> Commit | None:
    """Return the commit of the checkout that tracks `folder`, or None."""
    commit = _git(folder, "rev-parse", "HEAD")
    tracked = _git(folder, "ls-files", "--", ".")
    if not commit or not tracked:
        return None
    return Commit(commit, modified=bool(_git(folder, "status", "--porcelain", "-uno")))


def _git(folder: Path, *arguments: str) -> str | None:
    try:
        answer = subprocess.run(
            ["git", "-C", str(folder), *arguments], capture_output=True, text=True, timeout=10
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    return answer.stdout.strip() if answer.returncode == 0 else None
