"""The Pareto front of method time and error."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from oitbench.image.ties import PARTS, Errors
from oitbench.plugins import Collection
from oitbench.report import fronts
from oitbench.report.error_axis import FLOOR
from oitbench.report.multiples import Point
from tests.made_up import timed
from tests.report.made_up import context, finished

PARETO = Collection.load().reports["pareto"]


def names(*points: tuple[str, float, Errors]) -> list[str]:
    made = [Point(method, "lists", cost, errors) for method, cost, errors in points]
    return [point.method for point in fronts.front(made)]


def test_the_front_holds_the_points_that_none_beats() -> None:
    assert names(
        ("slow", 9.0, Errors(0.0)), ("fast", 1.0, Errors(0.5)), ("beaten", 2.0, Errors(0.6)),
        ("same", 9.5, Errors(0.0)),
    ) == ["fast", "slow"]  # fmt: skip


def test_errors_that_share_the_last_place_of_the_axis_are_equal() -> None:
    assert names(
        ("a", 1.0, Errors(0.5)), ("b", 2.0, Errors(FLOOR / 2)), ("c", 3.0, Errors(0.0))
    ) == ["a", "b"]


def test_a_point_that_ties_with_a_cheaper_one_is_not_on_the_front() -> None:
    noise = [0.02 * (-1) ** k for k in range(PARTS)]
    cheap = Errors(0.3, [0.3] * PARTS)
    tied = Errors(0.29, [0.29 + swing for swing in noise])
    clear = Errors(0.1, [0.1 + swing for swing in noise])
    assert names(("cheap", 1.0, cheap), ("tied", 2.0, tied), ("clear", 3.0, clear)) == [
        "cheap", "clear",
    ]  # fmt: skip


def test_the_axis_is_method_time_and_shading_does_not_count() -> None:
    point = PARETO.Point("one", timed(4.0), Errors(0.5))
    assert point.times.frame_ms.median == 5.0
    assert point.place == (4.0, 0.5)


def test_names_keep_away_from_the_intervals_of_marks_without_names(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    errors = np.linspace(0.05, 0.9, 14)
    cells = [
        finished(tmp_path, "panes", f"m{n}", e, traced=False, time=timed(2.0 + n, swing=1.5))
        for n, e in enumerate(errors)
    ]
    avoided: list[tuple[Sequence[float], Sequence[float]]] = []
    monkeypatch.setattr(PARETO.labels, "place", lambda *args, lines: avoided.extend(lines))
    PARETO.build(context(tmp_path, cells, tmp_path))
    widths = [xs[-1] - xs[0] for xs, ys in avoided if ys[0] == ys[-1]]
    assert len(widths) == len(cells) - 1
    assert min(widths) > 0.5
