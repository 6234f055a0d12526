"""Frame times that can be compared: interleaved, shuffled rounds, medians, bootstrap intervals."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from oitbench.gl.frame import Frame

_RESAMPLES = 1000


@dataclass
class Timing:
    """Times of one variant, in milliseconds, one entry a round."""

    frame_ms: list[float] = field(default_factory=list)
    sort_ms: list[float] = field(default_factory=list)

    def facts(self) -> dict[str, Any]:
        """Return what a record holds."""
        return {
            "frame_ms": interval(self.frame_ms),
            "sort_ms": float(np.median(self.sort_ms)),
        }


def interval(samples: Sequence[float], seed: int = 1) -> dict[str, Any]:
    """Return the median, its bootstrap 95 % interval, and the samples.

    Parameters
    ----------
    samples : sequence of float
        At least one.
    seed : int
        Of the resampling.
    """
    values = np.asarray(samples, dtype=np.float64)
    generator = np.random.default_rng(seed)
    chosen = generator.integers(len(values), size=(_RESAMPLES, len(values)))
    medians = np.median(values[chosen], axis=1)
    low, high = np.percentile(medians, [2.5, 97.5])
    return {
        "median": float(np.median(values)),
        "low": float(low),
        "high": float(high),
        "samples": [float(value) for value in values],
    }


def measure(
    frames: Mapping[str, Frame], rounds: int, budget: float, seed: int = 1, warm_up: int = 2
) -> dict[str, Timing]:
    """Time every frame in shuffled rounds, so that a drifting machine hurts all alike.

    Parameters
    ----------
    frames : mapping of str to Frame
        Variants of one scene, each rendered before.
    rounds : int
        Rounds at most.
    budget : float
        Seconds after which no further round begins, once three are complete.
    seed : int
        Of the order within rounds.
    warm_up : int
        Rounds that are not counted.
    """
    timings = {name: Timing() for name in frames}
    generator = np.random.default_rng(seed)
    names = list(frames)
    start = time.perf_counter()
    for number in range(rounds + warm_up):
        for name in generator.permutation(names):
            sample = _one(frames[str(name)])
            if number >= warm_up:
                timing = timings[str(name)]
                timing.frame_ms.append(sample[0])
                timing.sort_ms.append(sample[1])
        if number >= warm_up + 2 and time.perf_counter() - start > budget:
            break
    return timings


def _one(frame: Frame) -> tuple[float, float]:
    """Return frame and sort time of one frame, in milliseconds."""
    device = frame.device
    sort = frame.sort(None)
    device.finish()
    if device.software:
        # A software renderer's time query ends before its rasterization does.
        start = time.perf_counter()
        frame.issue(check=False)
        device.finish()
        return 1e3 * (time.perf_counter() - start), sort
    query = device.context.query(time=True)
    with query:
        frame.issue(check=False)
    device.finish()
    return query.elapsed / 1e6, sort
