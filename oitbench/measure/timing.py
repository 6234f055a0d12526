"""Times of frames that can be compared: of methods, of their passes, and of shared shading.

All frames of a scene are timed together. In each round every method is timed twice, as a whole and
by its passes. So are the shadow maps and the ambient occlusion, which all methods share, once for
each set of effects. The opaque picture is timed once for each number format and sample count.

A slow frame is timed by its passes alone if they take 10 ms or more on average: the waits between
them are nothing against that.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Literal

from oitbench.errors import OitbenchError
from oitbench.fingerprints.code import timing_fingerprint
from oitbench.gl.frame import Frame
from oitbench.measure import rounds
from oitbench.measure.clock import Clock, Drawn, Parts
from oitbench.measure.disturbance import Meter, foreign_share, usage
from oitbench.measure.intervals import interval
from oitbench.measure.rounds import Schedule
from oitbench.results.times import DISTURBED, Block, PassTime, Processor, Time

OPAQUE_PICTURE = "opaque picture"
"""Name of the part of shading that is timed by itself."""
_LONG_LAP = 10.0
"""Milliseconds of a pass beside which the wait at its end is nothing."""
_Kind = Literal["method", "passes", "opaque", "shading", "stages"]
_Task = tuple[_Kind, Hashable]


@dataclass(frozen=True)
class MethodSample:
    """Times of one frame in milliseconds; `sort` is None for a method that never sorts.

    `passes` are set if the frame was drawn pass by pass.
    """

    sort: float | None
    drawn: Drawn
    passes: Parts | None = None

    @property
    def ms(self) -> float:
        """Time of the method."""
        return (self.sort or 0.0) + self.drawn.ms


@dataclass
class Timings:
    """Times of frames by name, and the errors of those that failed."""

    times: dict[str, Time] = field(default_factory=dict)
    errors: dict[str, OitbenchError] = field(default_factory=dict)


@dataclass(frozen=True)
class _Attempt:
    """All rounds, with their wall-clock seconds and the CPU time that other processes took."""

    counted: rounds.Counted[_Task]
    seconds: float
    foreign: float | None

    @property
    def disturbed(self) -> bool:
        return self.foreign is not None and self.foreign > DISTURBED


def measure(
    frames: Mapping[str, Frame],
    schedule: Schedule,
    clock: Clock,
    cpu: Processor,
    meter: Meter = usage,
    now: Callable[[], float] = time.perf_counter,
) -> Timings:
    """Time the frames of one scene against each other.

    If other processes take more than `DISTURBED` of the CPU time, all rounds are repeated once, and
    the attempt that was disturbed less counts.

    Parameters
    ----------
    frames : mapping of str to Frame
        Each rendered before.
    schedule : Schedule
    clock : Clock
    cpu : Processor
        A fact for the record.
    meter : callable
        Returns the CPU time so far.
    now : callable
        Returns the time in seconds, by which the number of rounds is chosen.
    """
    tasks = _tasks(frames, clock)
    attempts = [_attempt(tasks, schedule, meter, now)]
    if attempts[0].disturbed:
        attempts.append(_attempt(tasks, schedule, meter, now))
    best = min(attempts, key=lambda attempt: attempt.foreign or 0.0)
    repeated, settings = len(attempts) > 1, (schedule.rounds, schedule.budget, timing_fingerprint())
    block = Block(clock.name, cpu, best.seconds, best.foreign, repeated, *settings)
    errors = {key: error for found in attempts for key, error in found.counted.errors.items()}
    found = Timings()
    for name, frame in frames.items():
        failed = [errors[key] for key in _tasks_of(name, frame).values() if key in errors]
        if failed:
            found.errors[name] = failed[0]
        else:
            found.times[name] = _time(name, frame, best.counted, block)
    return found


def _tasks_of(name: str, frame: Frame) -> dict[_Kind, _Task]:
    """Return the tasks that the times of a frame need, by kind."""
    keys: dict[_Kind, Hashable] = {"method": name, "passes": name, "opaque": frame.backdrop_key}
    if frame.shading:
        keys |= {"shading": frame.shading_key, "stages": frame.shading_key}
    return {kind: (kind, key) for kind, key in keys.items()}


def _tasks(frames: Mapping[str, Frame], clock: Clock) -> dict[_Task, Callable[[], object]]:
    """Return the tasks of all frames; frames with the same shading share its tasks."""
    found: dict[_Task, Callable[[], object]] = {}
    for name, frame in frames.items():
        method = _TimedMethod(frame, clock)
        run: dict[_Kind, Callable[[], object]] = {
            "method": method.whole,
            "passes": method.passes,
            "opaque": partial(_time_opaque, frame, clock),
            "shading": partial(_time_shading, frame, clock),
            "stages": partial(_time_stages, frame, clock),
        }
        found |= {task: run[kind] for kind, task in _tasks_of(name, frame).items()}
    return found


@dataclass
class _TimedMethod:
    """Times everything that a method does in a frame, on the opaque picture as it is.

    `long` says whether it is timed by its passes alone. The first frame, which does not count,
    shows it.
    """

    frame: Frame
    clock: Clock
    long: bool | None = None

    def whole(self) -> MethodSample:
        """Time the whole frame; a long one, and the first one, by its passes."""
        if self.long is False:
            return time_method(self.frame, self.clock)
        self.frame.restore()
        sort = _time_sort(self.frame, self.clock)
        passes = self._parts()
        gpu = passes.total if self.clock.name == "gpu" else None
        return MethodSample(sort, Drawn(passes.total, gpu), passes)

    def passes(self) -> Parts | None:
        """Time the passes, or return None if the whole frame is timed by them."""
        if self.long:
            return None
        self.frame.restore()
        self.frame.orders.sort()
        return self._parts()

    def _parts(self) -> Parts:
        parts = self.clock.parts(self.frame.composite)
        if self.long is None:
            slow = parts.total > 1000 * rounds.SLOW
            self.long = slow and parts.total >= _LONG_LAP * parts.laps
        return parts


def time_method(frame: Frame, clock: Clock) -> MethodSample:
    """Time everything that a method does in a frame, on the opaque picture as it is."""
    frame.restore()
    return MethodSample(_time_sort(frame, clock), clock.draw(frame.composite))


def _time_sort(frame: Frame, clock: Clock) -> float | None:
    return clock.run(frame.orders.sort) if frame.orders.sorts else None


def _time_opaque(frame: Frame, clock: Clock) -> float:
    return clock.draw(frame.draw_backdrop).ms


def _time_shading(frame: Frame, clock: Clock) -> float:
    return clock.draw(frame.shade).ms


def _time_stages(frame: Frame, clock: Clock) -> Parts:
    return clock.parts(frame.shade)


def _attempt(
    tasks: Mapping[_Task, Callable[[], object]],
    schedule: Schedule,
    meter: Meter,
    now: Callable[[], float],
) -> _Attempt:
    start, before = now(), meter()
    counted = rounds.run(tasks, schedule, now)
    return _Attempt(counted, now() - start, foreign_share(before, meter()))


def _time(name: str, frame: Frame, counted: rounds.Counted[_Task], block: Block) -> Time:
    found = {kind: counted.samples[task] for kind, task in _tasks_of(name, frame).items()}
    method: list[MethodSample] = found["method"]
    passes = [sample.passes for sample in method if sample.passes] or found["passes"]
    times = [sample.ms for sample in method]
    opaque = found["opaque"]
    shading = _sums(opaque, found["shading"]) if frame.shading else opaque
    stages = _parts(found["stages"], {}) if frame.shading else []
    sorts = [sample.sort for sample in method if sample.sort is not None]
    gpu = [sample.drawn.gpu for sample in method if sample.drawn.gpu is not None]
    return Time(
        method_ms=interval(times),
        sort_ms=interval(sorts) if sorts else None,
        gpu_ms=interval(gpu) if gpu else None,
        shading_ms=interval(shading),
        frame_ms=interval(_sums(times, shading)),
        passes=_parts(passes, frame.plan.parts),
        shading=[*stages, PassTime(OPAQUE_PICTURE, interval(opaque))],
        block=block,
        remark=remark(method, passes),
    )


def _sums(one: Sequence[float], other: Sequence[float]) -> list[float]:
    """Return the sums of each round. A slow task takes part in fewer rounds than others."""
    return [sum(pair) for pair in zip(one, other, strict=False)]


def _parts(rounds: Sequence[Parts], labels: Mapping[int, str]) -> list[PassTime]:
    return [
        PassTime(
            labels[key] if isinstance(key, int) else str(key),
            interval([one.ms[key] for one in rounds]),
        )
        for key in rounds[0].ms
    ]


def remark(method: Sequence[MethodSample], passes: Sequence[Parts]) -> str:
    """Return the reason why the passes do not add up to the time of the whole frame, or ""."""
    drawn = [sample.drawn for sample in method]
    together = interval([one.ms if one.gpu is None else one.gpu for one in drawn])
    apart = interval([one.total for one in passes])
    found = []
    if together.ends is None or apart.ends is None:
        found.append("There are too few samples to add up the passes.")
    elif apart.ends[0] > together.ends[1] or apart.ends[1] < together.ends[0]:
        change = apart.median - together.median
        text = f"One by one, the parts of the drawing take {apart.median:.3g} ms,"
        text += f" {abs(change):.2g} ms {'more' if change > 0 else 'less'} than together"
        waits = f": the renderer is waited for {passes[0].laps} times"
        found.append(text + (waits if drawn[0].gpu is None else "") + ".")
    submitted = interval([one.ms for one in drawn])
    if drawn[0].gpu is not None and submitted.median > together.median:
        found.append(
            f"The CPU takes {submitted.median:.3g} ms to submit the passes, which counts: the GPU"
            f" needs {together.median:.3g} ms to draw them."
        )
    return " ".join(found)
