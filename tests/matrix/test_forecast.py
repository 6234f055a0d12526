"""The time that a run has left."""

from __future__ import annotations

import pytest

from oitbench.matrix.cell import Cell
from oitbench.matrix.forecast import Forecast, duration
from oitbench.measure.rounds import Schedule

UNTIMED, TIMED = Schedule(0, 0.0), Schedule(9, 4.0)


def cells(scenes: str, methods: str = "ab") -> list[Cell]:
    return [Cell(scene, method, (8, 8)) for scene in scenes for method in methods]


def test_nothing_is_known_before_the_first_cell_is_finished() -> None:
    forecast = Forecast(cells("xy"), UNTIMED, workers=1)
    assert forecast.left() is None
    forecast.finish(cells("x")[0], None)
    assert forecast.left() is None
    assert (forecast.done, forecast.total) == (1, 4)


def test_cells_of_costly_methods_weigh_more() -> None:
    forecast = Forecast(cells("xyz"), UNTIMED, workers=1)
    for cell in cells("xy"):
        forecast.finish(cell, {"a": 1.0, "b": 9.0}[cell.method])
    assert forecast.left() == pytest.approx(10.0, rel=0.05)
    forecast.finish(cells("z")[1], 9.0)
    assert forecast.left() == pytest.approx(1.0, rel=0.2)


def test_workers_share_the_cells_and_not_the_timing() -> None:
    one, two = (Forecast(cells("xy", "a"), TIMED, workers) for workers in (1, 2))
    for forecast in (one, two):
        forecast.finish(cells("x")[0], 2.0)
    assert one.left() == pytest.approx(2.0 + 8.0)
    assert two.left() == pytest.approx(1.0 + 8.0)


def test_timing_is_expected_to_take_what_it_took() -> None:
    forecast = Forecast(cells("xyz", "a"), TIMED, workers=1)
    for cell in cells("xyz", "a"):
        forecast.finish(cell, 1.0)
    assert forecast.left() == pytest.approx(12.0)
    forecast.finish_timing(cells("x", "a"), 1.0)
    assert forecast.left() == pytest.approx(2.0)


def test_scenes_whose_cells_are_kept_are_not_timed() -> None:
    forecast = Forecast(cells("xy", "a"), TIMED, workers=1)
    forecast.finish(cells("x", "a")[0], None)
    forecast.finish(cells("y", "a")[0], 1.0)
    assert forecast.left() == pytest.approx(4.0)


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.4, "0 s"), (89.0, "89 s"), (91.0, "2 min"), (5390.0, "90 min"), (5500.0, "1.5 h")],
)
def test_durations_in_words(seconds: float, text: str) -> None:
    assert duration(seconds) == text
