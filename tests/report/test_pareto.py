"""The Pareto front of method time and error."""

from __future__ import annotations

from oitbench.plugins import Collection
from tests.made_up import timed

PARETO = Collection.load().reports["pareto"]


def test_the_front_holds_the_points_that_none_beats() -> None:
    points = [
        PARETO.Point(method, timed(ms), error)
        for method, ms, error in (
            ("slow", 9.0, 0.0), ("fast", 1.0, 0.5), ("beaten", 2.0, 0.6), ("same", 9.5, 0.0)
        )
    ]  # fmt: skip
    assert [point.method for point in PARETO.front(points)] == ["fast", "slow"]


def test_the_axis_is_method_time_and_shading_does_not_count() -> None:
    point = PARETO.Point("one", timed(4.0), 0.5)
    assert point.times.frame_ms.median == 5.0
    assert point.place == (4.0, 0.5)
