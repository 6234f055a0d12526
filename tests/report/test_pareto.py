"""The Pareto front of frame time and error."""

from __future__ import annotations

from oitbench.plugins import Collection
from tests.report.made_up import timed

PARETO = Collection.load().reports["pareto"]


def test_the_front_holds_the_points_that_none_beats() -> None:
    points = [
        PARETO.Point(method, timed(ms).frame_ms, error)
        for method, ms, error in (
            ("slow", 9.0, 0.0), ("fast", 1.0, 0.5), ("beaten", 2.0, 0.6), ("same", 9.5, 0.0)
        )
    ]  # fmt: skip
    assert [point.method for point in PARETO.front(points)] == ["fast", "slow"]
