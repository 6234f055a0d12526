"""Cost and gain of effects that were left out one at a time."""

from __future__ import annotations

from dataclasses import replace as changed
from pathlib import Path

import msgspec
import pytest

from oitbench.image import metrics
from oitbench.report.effect_costs import effect_costs, saved_time
from oitbench.results.records import Results
from tests.made_up import timed
from tests.report.made_up import FACTS, unfinished, with_effects


def test_saved_time_has_an_interval() -> None:
    slow, fast = (unfinished("panes", "murk", time=timed(median)) for median in (10.0, 4.0))
    saved = saved_time(slow, fast)
    assert saved is not None
    assert saved.median == pytest.approx(6.0)
    assert saved.ends is not None
    assert 5.8 <= saved.ends[0] <= 6.0 <= saved.ends[1] <= 6.2
    opposite = saved_time(fast, slow)
    assert opposite is not None
    assert opposite.median == pytest.approx(-6.0)


def test_without_times_nothing_is_saved() -> None:
    timed_cell, other = unfinished("panes", "murk", time=timed(10)), unfinished("panes", "murk")
    assert saved_time(timed_cell, other) is None
    assert saved_time(other, timed_cell) is None


def test_gains_that_are_not_clear_are_ties(tmp_path: Path) -> None:
    complete = with_effects(tmp_path, "full", 0.1)
    reduced = with_effects(tmp_path, "full", 0.3, effects="-diffusion", gone=["DIFFUSION"])
    (panel,) = Results(tmp_path, (complete, reduced), FACTS).panels()
    (cost,) = effect_costs(panel, metrics.FLIP_LDR)
    assert cost.effect == "diffusion"
    assert cost.gain is not None
    assert cost.verdict == "better"
    assert cost.clear
    assert changed(cost, gain=-cost.gain).verdict == "worse"
    assert changed(cost, clear=False).verdict == "tie"
    assert changed(cost, gain=None).verdict == ""


def test_cells_that_did_not_finish_have_no_cost(tmp_path: Path) -> None:
    complete = with_effects(tmp_path, "full", 0.1)
    failed = unfinished("panes", "full", effects="-diffusion")
    for pair in ((complete, failed), (msgspec.structs.replace(complete, outcome=None), failed)):
        (panel,) = Results(tmp_path, pair, FACTS).panels()
        assert list(effect_costs(panel, metrics.FLIP_LDR)) == []
