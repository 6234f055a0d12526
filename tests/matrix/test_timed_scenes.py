"""Which scenes are timed, and the records of cells that fail while they are."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from oitbench.errors import CapabilityError
from oitbench.matrix import timed_scenes
from oitbench.matrix.cell import Cell
from oitbench.matrix.timed_cells import ScoredCell, Timing
from oitbench.matrix.timed_scenes import Pair, due_scenes, time_scene
from oitbench.measure.rounds import Schedule
from oitbench.results.schema import Record
from oitbench.results.times import Processor
from oitbench.workers.process import WorkerError
from tests.made_up import failed, record, timed

NEW = timed(5.0)
NINE = Schedule(9, 4.0)
"""The schedule of all made-up times."""
CPU = Processor("abacus")
"""The processor of all made-up times."""


def pair(method: str, scene: str = "glass", **fields: Any) -> Pair:
    made = record(method, scene, **fields)
    return Cell(scene, method, made.size), made


def ask(*dying: str, groups: list[str] | None = None) -> Callable[[list[ScoredCell]], list[Timing]]:
    """Return a worker that does not survive some methods, and notes what it is asked."""

    def answer(cells: list[ScoredCell]) -> list[Timing]:
        names = "".join(scored.cell.method for scored in cells)
        if groups is not None:
            groups.append(names)
        if any(name in names for name in dying):
            raise WorkerError("the worker process ended with code 7", "ended")
        return [Timing(NEW) for _ in cells]

    return answer


def timed_by(found: list[Record]) -> dict[str, bool]:
    return {item.method: item.time == NEW for item in found}


def test_all_cells_of_a_scene_are_timed_together() -> None:
    groups: list[str] = []
    found = time_scene([pair("a"), pair("b"), pair("c")], ask(groups=groups))
    assert timed_by(found) == {"a": True, "b": True, "c": True}
    assert groups == ["abc"]


def test_a_worker_that_dies_costs_the_times_of_one_cell() -> None:
    groups: list[str] = []
    pairs = [pair(name, time=None) for name in "abcde"]
    found = time_scene(pairs, ask("d", groups=groups))
    assert [item.method for item in found] == list("abcde")
    assert timed_by(found) == {"a": True, "b": True, "c": True, "d": False, "e": True}
    assert found[3].time is None
    assert found[3].status == "ok"
    assert found[3].reason == "not timed: the worker process ended with code 7"
    assert groups == ["abcde", "ab", "cde", "c", "de", "d", "e"]


def test_an_earlier_time_stays_if_there_is_no_new_one() -> None:
    before = pair("a")
    (found,) = time_scene([before], ask("a"))
    assert found.time == before[1].time
    assert found.reason.startswith("not timed: ")


def test_a_new_time_removes_the_reason_why_there_was_none() -> None:
    before = pair("a", status="unstable", reason="pixels: 3 nan; not timed: no memory")
    (found,) = time_scene([before], ask())
    assert (found.time, found.reason) == (NEW, "pixels: 3 nan")
    (again,) = time_scene([before], ask("a"))
    assert again.reason == "pixels: 3 nan; not timed: the worker process ended with code 7"


def test_a_suspect_cell_has_no_time() -> None:
    answer = [Timing(reason="it cheats", suspect=True), Timing(NEW)]
    found = time_scene([pair("a"), pair("b")], lambda _: answer)
    assert (found[0].status, found[0].time, found[0].reason) == ("suspect", None, "it cheats")
    assert found[0].finished
    assert found[1].time == NEW


def test_an_error_of_the_scene_is_the_reason_of_all_its_cells() -> None:
    def refuse(cells: list[ScoredCell]) -> list[Timing]:
        raise CapabilityError("no OpenGL")

    found = time_scene([pair("a", time=None), pair("b", time=None)], refuse)
    assert [item.reason for item in found] == ["not timed: no OpenGL"] * 2


@pytest.mark.parametrize(
    ("changed", "due"),
    [
        ({}, False),
        ({"time": None}, True),
        ({"status": "failed", "outcome": None, "time": None}, False),
    ],
)
def test_a_scene_is_due_if_a_finished_cell_has_no_time(changed: dict[str, Any], due: bool) -> None:
    pairs = [pair("a"), pair("b", **changed), pair("c", "steel")]
    found = due_scenes(pairs, [], CPU, NINE)
    assert found == ([pairs[:2]] if due else [])


def test_fresh_cells_and_other_processors_make_a_scene_due() -> None:
    pairs = [pair("a"), pair("b"), pair("c", "steel")]
    assert due_scenes(pairs, [pairs[1][0]], CPU, NINE) == [pairs[:2]]
    assert due_scenes(pairs, [], Processor("quantum"), NINE) == [pairs[:2], pairs[2:]]
    assert due_scenes(pairs, [], None, NINE) == []
    # More rounds, or a larger budget, need new times.
    for other in (Schedule(15, 4.0), Schedule(9, 60.0)):
        assert due_scenes(pairs, [], CPU, other) == [pairs[:2], pairs[2:]]
    assert due_scenes([(pairs[0][0], failed("a"))], [pairs[0][0]], CPU, NINE) == []


def test_other_sources_of_timing_make_a_scene_due(monkeypatch: pytest.MonkeyPatch) -> None:
    pairs = [pair("a"), pair("b")]
    monkeypatch.setattr(timed_scenes, "timing_fingerprint", lambda: "of tomorrow")
    assert due_scenes(pairs, [], CPU, NINE) == [pairs]
