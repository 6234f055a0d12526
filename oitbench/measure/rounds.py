"""Rounds of timing: every task runs once per round, in an order that is shuffled each time."""

from __future__ import annotations

import time
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

import numpy as np

from oitbench.errors import OitbenchError
from oitbench.measure.intervals import LEAST_SAMPLES

WARM_UP = 2
"""Rounds that are not counted: drivers compile, caches fill and clock frequencies rise. A slow task
needs only one."""
LEAST, LEAST_OF_SLOW = 9, LEAST_SAMPLES
"""Rounds that every task takes part in, whatever they take, and those of a slow task."""
SLOW = 0.1
"""Seconds of a task that is slow."""
Key = TypeVar("Key", bound=Hashable)


@dataclass(frozen=True)
class Schedule:
    """The number of rounds.

    Parameters
    ----------
    rounds : int
        Largest number of counted rounds.
    budget : float
        Seconds after which tasks stop that have run in `LEAST` rounds, or `LEAST_OF_SLOW` if they
        are slow.
    seed : int
        Seed of the order within rounds.
    """

    rounds: int
    budget: float
    seed: int = 1


@dataclass
class Counted(Generic[Key]):
    """The samples of every task, one per round, and the errors of tasks that failed.

    A task that failed runs no more, and its samples are incomplete.
    """

    samples: dict[Key, list[Any]] = field(default_factory=dict)
    errors: dict[Key, OitbenchError] = field(default_factory=dict)


def run(
    tasks: Mapping[Key, Callable[[], Any]],
    schedule: Schedule,
    now: Callable[[], float] = time.perf_counter,
) -> Counted[Key]:
    """Run all tasks in shuffled rounds, so that a drifting machine affects all alike.

    Parameters
    ----------
    tasks : mapping to callable
        Each returns one sample.
    schedule : Schedule
    now : callable
        Returns the time in seconds.
    """
    found: Counted[Key] = Counted({key: [] for key in tasks})
    generator = np.random.default_rng(schedule.seed)
    keys, start = list(tasks), now()
    least: dict[Key, int] = {}
    for number in range(WARM_UP + schedule.rounds):
        late = now() - start > schedule.budget
        keys = [
            key for key in keys if not (late and len(found.samples[key]) >= least.get(key, LEAST))
        ]
        if not keys:
            break
        for place in generator.permutation(len(keys)):
            key = keys[place]
            if number < WARM_UP and least.get(key) == LEAST_OF_SLOW:
                continue
            began = now()
            try:
                sample = tasks[key]()
            except OitbenchError as error:
                found.errors[key] = error
                continue
            if number >= WARM_UP:
                found.samples[key].append(sample)
            else:
                least[key] = LEAST_OF_SLOW if now() - began > SLOW else LEAST
        keys = [key for key in keys if key not in found.errors]
    return found
