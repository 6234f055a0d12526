"""Shuffled rounds of tasks, with a clock that tasks advance."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import pytest

from oitbench.errors import CapabilityError
from oitbench.measure import rounds
from oitbench.measure.rounds import WARM_UP, Counted, Schedule


class Tasks:
    """Tasks that take a known time and note their name."""

    def __init__(self, seconds: Mapping[str, float]) -> None:
        self.time, self.log = 0.0, ""
        self.tasks = {name: self._task(name, taken) for name, taken in seconds.items()}

    def _task(self, name: str, seconds: float) -> Callable[[], float]:
        def run() -> float:
            self.time += seconds
            self.log += name
            return seconds

        return run

    def run(self, schedule: Schedule) -> Counted[str]:
        return rounds.run(self.tasks, schedule, now=lambda: self.time)


def counts(seconds: Mapping[str, float], schedule: Schedule) -> dict[str, int]:
    found = Tasks(seconds).run(schedule)
    return {name: len(samples) for name, samples in found.samples.items()}


def order(seed: int) -> list[str]:
    tasks = Tasks(dict.fromkeys("abcd", 0.0625))
    tasks.run(Schedule(6, 60.0, seed))
    return [tasks.log[start : start + 4] for start in range(0, len(tasks.log), 4)]


def test_every_task_runs_once_per_round_in_random_order() -> None:
    found = order(1)
    assert len(found) == WARM_UP + 6
    assert all(sorted(one) == list("abcd") for one in found)
    assert len(set(found)) > 1
    assert found == order(1) != order(2)


def test_samples_are_in_order_of_the_rounds_and_without_the_warm_up() -> None:
    numbers = iter(range(100))
    found = rounds.run({"a": lambda: next(numbers)}, Schedule(4, 60.0))
    assert found.samples == {"a": [WARM_UP, WARM_UP + 1, WARM_UP + 2, WARM_UP + 3]}


@pytest.mark.parametrize("budget", [0.0, 3.5])
def test_nine_rounds_count_and_six_of_slow_tasks_whatever_they_take(budget: float) -> None:
    found = counts({"fast": 0.0625, "slow": 0.5}, Schedule(31, budget))
    assert found == {"fast": 9, "slow": 6}


def test_all_rounds_count_within_the_budget() -> None:
    assert counts({"fast": 0.0625, "slow": 0.5}, Schedule(31, 600.0)) == {"fast": 31, "slow": 31}


def test_one_round_warms_up_a_slow_task() -> None:
    tasks = Tasks({"f": 0.0625, "s": 0.5})
    tasks.run(Schedule(9, budget=0.0))
    assert (tasks.log.count("f"), tasks.log.count("s")) == (WARM_UP + 9, 1 + 6)


def test_a_short_schedule_ends_early() -> None:
    assert counts({"a": 0.1}, Schedule(2, 60.0)) == {"a": 2}


def test_a_task_that_fails_does_not_affect_the_others() -> None:
    tasks = Tasks({"well": 0.1})
    calls = iter([1.0] * (WARM_UP + 2))

    def dying() -> float:
        for sample in calls:
            return sample
        raise CapabilityError("no more memory")

    tasks.tasks["ill"] = dying
    found = tasks.run(Schedule(9, 60.0))
    assert len(found.samples["well"]) == 9
    assert {key: str(error) for key, error in found.errors.items()} == {"ill": "no more memory"}
