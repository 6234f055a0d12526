"""Times of frames for scripts, with a warning if other processes disturbed them."""

from __future__ import annotations

from collections.abc import Mapping

from oitbench.gl.device import Device
from oitbench.gl.frame import Frame
from oitbench.matrix import machine
from oitbench.measure import timing
from oitbench.measure.clock import clock_of
from oitbench.measure.rounds import Schedule
from oitbench.results.times import Interval, Time


def time_frames(device: Device, frames: Mapping[str, Frame], schedule: Schedule) -> dict[str, Time]:
    """Return the times of rendered frames of one scene; print why others have none."""
    with clock_of(device) as clock:
        found = timing.measure(frames, schedule, clock, machine.processor())
    for name, error in found.errors.items():
        print(f"not timed: {name}: {error}")
    for time in list(found.times.values())[:1]:
        if time.block.disturbed:
            print(f"disturbed: other processes took {time.block.foreign:.0%} of the CPU time")
    return found.times


def write_ends(interval: Interval, decimals: int = 2) -> str:
    """Return the interval as "[low, high]"; empty if there are too few samples."""
    ends = interval.ends
    return f"[{ends[0]:.{decimals}f}, {ends[1]:.{decimals}f}]" if ends else ""
