"""Scenes as units of work: when an idle worker joins another one."""

from __future__ import annotations

import pytest

from oitbench.matrix.agenda import Agenda, SceneWork
from oitbench.matrix.cell import Cell
from oitbench.workers.process import WorkerError


def cells(scene: str, count: int) -> list[Cell]:
    return [Cell(scene, f"m{number}", (8, 8)) for number in range(count)]


def begun(scene: SceneWork, first: float, second: float) -> None:
    """Let one worker draw two cells."""
    assert scene.join()
    scene.begin(scene.cells)
    taken = scene.take()
    next(taken)
    scene.count(first, first=True)
    next(taken)
    scene.count(second, first=False)


def test_each_worker_takes_a_scene_of_its_own_first() -> None:
    agenda = Agenda(cells("a", 3) + cells("b", 2))
    one, other = agenda.popleft(), agenda.popleft()
    assert (one.cells, other.cells) == (cells("a", 3), cells("b", 2))
    assert not agenda
    with pytest.raises(IndexError, match="no scene is left"):
        agenda.popleft()


def test_an_idle_worker_joins_the_scene_that_it_ends_most_earlier() -> None:
    agenda = Agenda(cells("short", 12) + cells("long", 12))
    short, long = agenda.popleft(), agenda.popleft()
    begun(short, 4.0, 1.0)
    begun(long, 4.0, 2.0)
    # 10 cells of 2 s are left: 20 s alone; 12 s for two, of which one prepares the scene first.
    assert long.gain == pytest.approx(8.0)
    assert short.gain == pytest.approx(3.0)
    assert agenda
    assert agenda.popleft() is long
    assert not long.join()
    # A third one would save less than the second one, and less than in the other scene.
    assert long.gain == pytest.approx(20 / 2 - 24 / 3)
    assert agenda.popleft() is short


def test_no_worker_joins_if_preparing_takes_longer_than_the_rest() -> None:
    agenda = Agenda(cells("a", 6))
    begun(agenda.popleft(), 4.0, 1.0)
    assert not agenda


def test_no_worker_joins_before_the_costs_are_known_or_after_the_scene_failed() -> None:
    agenda = Agenda(cells("a", 90))
    scene = agenda.popleft()
    assert not agenda
    begun(scene, 1.0, 1.0)
    assert agenda
    scene.lost = WorkerError("gone", "fault")
    assert not agenda


def test_workers_of_one_scene_share_its_cells() -> None:
    (scene,) = [Agenda(cells("a", 4)).popleft()]
    scene.begin(scene.cells)
    one, other = scene.take(), scene.take()
    assert [next(one), next(other), next(one), next(other)] == cells("a", 4)
    assert next(one, None) is None
