"""The memory of processes: how much there is, and how much one of them uses."""

from __future__ import annotations

import math
import time
from contextlib import suppress
from pathlib import Path

import psutil

from oitbench.errors import UsageError

SHARE = 0.75
"""Share of the machine's memory that all workers together may use."""
GIB = 2**30
LEAST_GIB = 0.25
"""Smallest limit: what a process needs before it begins to work."""

_CGROUP_LIMITS = ("memory.max", "memory/memory.limit_in_bytes")
_POLL_SECONDS = 0.25
# Finding child processes reads the whole process table, which takes milliseconds.
_CHILDREN_SECONDS = 2.0


def available(root: Path = Path("/sys/fs/cgroup")) -> int:
    """Return the bytes of memory of this machine, or of this container if it may use less."""
    limits = [psutil.virtual_memory().total]
    for name in _CGROUP_LIMITS:
        # Version 2 writes "max" if there is no limit, version 1 a huge number.
        with suppress(OSError, ValueError):
            limits.append(int((root / name).read_text(encoding="ascii")))
    return min(limits)


def share(workers: int) -> int:
    """Return the bytes that each of some workers may use by default."""
    return int(SHARE * available() / workers)


def limit(gib: float | None, workers: int) -> int:
    """Return the bytes that each of some workers may use: `gib` in GiB, or the default share.

    Raises
    ------
    UsageError
        `gib` is less than a process needs to start, or not finite.
    """
    if gib is None:
        return share(workers)
    if not LEAST_GIB <= gib < math.inf:
        raise UsageError(f"memory is {gib:g} GiB; give at least {LEAST_GIB:g}")
    return int(gib * GIB)


def peak() -> int:
    """Return the largest resident memory that this process has had, in bytes."""
    with suppress(OSError):
        for line in Path("/proc/self/status").read_text(encoding="ascii").splitlines():
            if line.startswith("VmHWM:"):
                return 1024 * int(line.split()[1])
    return resident()


def resident() -> int:
    """Return the resident memory of this process, in bytes."""
    return int(psutil.Process().memory_info().rss)


class Watch:
    """Looks at the resident memory of a process and its children, a few times per second.

    `RLIMIT_AS` cannot do this: drivers of GPUs reserve far more address space than they use.
    """

    interval = _POLL_SECONDS

    def __init__(self, pid: int, limit: int) -> None:
        self.limit = limit
        self._next_search = 0.0
        self._processes: list[psutil.Process] = []
        with suppress(psutil.Error):
            self._processes.append(psutil.Process(pid))

    def exceeded(self) -> bool:
        """Return whether the process and its children use more than the limit."""
        now = time.monotonic()
        if self._processes and now >= self._next_search:
            self._next_search = now + _CHILDREN_SECONDS
            with suppress(psutil.Error):
                self._processes[1:] = self._processes[0].children(recursive=True)
        return sum(map(_resident, self._processes)) > self.limit


def _resident(process: psutil.Process) -> int:
    try:
        return int(process.memory_info().rss)
    except psutil.Error:
        return 0
