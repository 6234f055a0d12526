"""The CPU time that other processes take while something is timed."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

from oitbench.workers.cores import usable_cores

_WORKING = ("user", "nice", "system", "irq", "softirq", "steal")
"""Fields of the system's accounts that are not idle; another virtual machine steals time too."""
_TICK = 0.01
"""Resolution of the system's accounts in seconds."""


@dataclass(frozen=True)
class Usage:
    """CPU time so far, in seconds, from any origin.

    Parameters
    ----------
    all : float
        Of everything that ran on the cores that this process may use.
    own : float
        Of this process with all its threads.
    wall : float
        Time of a clock on the wall.
    cores : int
    """

    all: float
    own: float
    wall: float
    cores: int


Meter = Callable[[], Usage | None]


def usage() -> Usage | None:
    """Return the CPU time so far; None if the system does not account for it."""
    import psutil

    try:
        accounts = psutil.cpu_times(percpu=True)
    except (OSError, NotImplementedError, RuntimeError):
        return None
    usable = [number for number in usable_cores() if number < len(accounts)]
    working = sum(getattr(accounts[core], kind, 0.0) for core in usable for kind in _WORKING)
    return Usage(working, time.process_time(), time.monotonic(), len(usable))


def foreign_share(before: Usage | None, after: Usage | None) -> float | None:
    """Return the share of the CPU time that other processes took between two moments.

    It is relative to all time of all usable cores: 0 on an idle machine, and 0.5 if one of two
    cores was busy with something else. None if it is unknown. One tick per core is not counted:
    the accounts of the system may be wrong by that much, which matters in short blocks.
    """
    if before is None or after is None:
        return None
    offered = (after.wall - before.wall) * after.cores
    if offered <= 0:
        return None
    foreign = (after.all - before.all) - (after.own - before.own) - _TICK * after.cores
    return min(1.0, max(0.0, foreign / offered))
