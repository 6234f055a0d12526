"""Frame times that can be compared: interleaved, shuffled rounds, medians, bootstrap intervals."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from oitbench.gl.draws.records import PassRecord
from oitbench.gl.frame import Frame, FrameMeasurement
from oitbench.results.schema import Interval, PassTime, Time

_RESAMPLES = 1000


@dataclass
class Samples:
    """Times of one frame in milliseconds, one entry per round."""

    frame_ms: list[float] = field(default_factory=list)
    sort_ms: list[float] = field(default_factory=list)


def interval(samples: Sequence[float], seed: int = 1) -> Interval:
    """Return the median, its bootstrap 95 % interval, and the samples.

    Parameters
    ----------
    samples : sequence of float
        At least one.
    seed : int
        Seed of the resampling.
    """
    values = np.asarray(samples, dtype=np.float64)
    generator = np.random.default_rng(seed)
    chosen = generator.integers(len(values), size=(_RESAMPLES, len(values)))
    medians = np.median(values[chosen], axis=1)
    low, high = np.percentile(medians, [2.5, 97.5])
    return Interval(
        float(np.median(values)), float(low), float(high), [float(value) for value in values]
    )


def measure(
    frames: Mapping[str, Frame], rounds: int, budget: float, seed: int = 1, warm_up: int = 2
) -> dict[str, Samples]:
    """Time every frame in shuffled rounds, so that a drifting machine affects all alike.

    Parameters
    ----------
    frames : mapping of str to Frame
        Frames of one scene, each rendered before.
    rounds : int
        Largest number of rounds.
    budget : float
        Seconds after which no further round begins, once three are complete.
    seed : int
        Seed of the order within rounds.
    warm_up : int
        Rounds that are not counted.
    """
    samples = {name: Samples() for name in frames}
    generator = np.random.default_rng(seed)
    names = list(frames)
    start = time.perf_counter()
    for number in range(rounds + warm_up):
        for name in generator.permutation(names):
            frame_ms, sort_ms = _time(frames[str(name)])
            if number >= warm_up:
                samples[str(name)].frame_ms.append(frame_ms)
                samples[str(name)].sort_ms.append(sort_ms)
        if number >= warm_up + 2 and time.perf_counter() - start > budget:
            break
    return samples


def times(samples: Samples, measured: FrameMeasurement) -> Time:
    """Return the times of a frame as a record holds them.

    Parameters
    ----------
    samples : Samples
    measured : FrameMeasurement
        One more frame, of which each pass was measured by waiting for it.
    """
    return Time(
        interval(samples.frame_ms),
        float(np.median(samples.sort_ms)),
        [_pass_time(record) for record in measured.shading],
        [_pass_time(record) for record in measured.passes],
    )


def _pass_time(record: PassRecord) -> PassTime:
    return PassTime(record.name, record.milliseconds, record.fragments)


def _time(frame: Frame) -> tuple[float, float]:
    """Return the time of one frame and of its sorting, in milliseconds."""
    device = frame.device
    sort = frame.sort(None)
    device.finish()
    if device.software:
        # A time query of a software renderer ends before its rasterization does.
        start = time.perf_counter()
        frame.issue()
        device.finish()
        return 1e3 * (time.perf_counter() - start), sort
    query = device.time_query
    with query:
        frame.issue()
    device.finish()
    return query.elapsed / 1e6, sort
