"""Comparisons of made-up runs: differences that fail, and differences that do not."""

from __future__ import annotations

from pathlib import Path
from typing import cast

import pytest

import oitbench
from oitbench.errors import UsageError
from oitbench.image import metrics
from oitbench.results import baseline
from oitbench.results import comparison as regression
from oitbench.results.baseline import Snapshot
from oitbench.results.comparison import TOLERANCES, Comparison, Tolerance
from oitbench.results.custom import CustomMetric
from oitbench.results.schema import PassRuns, Record
from oitbench.results.times import Interval
from tests.made_up import VALUES, changed, failed, record, timed, write
from tests.results.helpers import ALPHA, BETA, Change, compared, exact, field, slower

SPREADS = {metrics.ORDER_SPREAD_MAX, metrics.ORDER_SPREAD_MEAN}
"""Metrics that `metrics.compare` does not return."""
MAE = CustomMetric(False, 0.1, 0.0, "digest")
"""A metric of a user's file."""


def found(comparison: Comparison) -> list[tuple[str, str, str]]:
    return [(item.verdict, item.cell, item.field) for item in comparison.differences]


def test_every_metric_has_a_tolerance_and_a_direction() -> None:
    assert set(TOLERANCES) == {*metrics.NAMES, metrics.TRANSMITTANCE, *SPREADS}
    higher = {name for name, entry in TOLERANCES.items() if entry.higher_is_better}
    assert higher == {metrics.SSIM, metrics.PSNR}


def test_a_run_equals_itself(before: Path) -> None:
    comparison = oitbench.compare(before, before)
    assert comparison.passed
    assert comparison.cells == 2
    assert comparison.differences == ()


@pytest.mark.parametrize("name", sorted(set(TOLERANCES) - SPREADS))
def test_a_metric_may_change_within_its_tolerance_only(before: Path, name: str) -> None:
    value = VALUES[name]
    assert value is not None
    allowed = TOLERANCES[name].absolute + TOLERANCES[name].relative * value
    worse = -1 if TOLERANCES[name].higher_is_better else 1
    for step, verdict in ((0.9, None), (1.1, "worse"), (-0.9, None), (-1.1, "better")):
        comparison = compared(before, exact(name, value + worse * step * allowed))
        expected = [(verdict, ALPHA, f"exact.{name}")] if verdict else []
        assert found(comparison) == expected, step
        assert comparison.passed == (verdict != "worse")
        assert bool(comparison.improvements) == (verdict == "better")


def test_metrics_against_traced_truths_are_compared_too(before: Path) -> None:
    change = field(f"outcome.scores.matched.metrics.{metrics.RMSE}", 0.1)
    assert found(compared(before, change)) == [("worse", ALPHA, f"matched.{metrics.RMSE}")]


def test_tolerances_grow_with_the_baseline() -> None:
    tolerance = Tolerance(0.1, 0.01)
    assert tolerance.judge(0.0, 0.2) == "worse"
    assert tolerance.judge(100.0, 101.0) is None
    assert tolerance.judge(100.0, 101.2) == "worse"
    assert tolerance.judge(100.0, 98.8) == "better"


@pytest.mark.parametrize(
    ("old", "new", "verdict"),
    [
        (120.0, 55.0, None),
        (120.0, 45.0, "worse"),
        (45.0, 120.0, "better"),
        (None, None, None),
        (None, 90.0, None),
        (90.0, None, None),
        (None, 30.0, "worse"),
        (30.0, None, "better"),
    ],
)
def test_ratios_above_their_ceiling_are_equal(
    old: float | None, new: float | None, verdict: str | None
) -> None:
    """PSNR of equal images is infinite (None) and counts as the ceiling."""
    findings = regression.compare_snapshots(ratio(new), ratio(old)).differences
    assert [finding.verdict for finding in findings] == ([verdict] if verdict else [])


def ratio(value: float | None) -> Snapshot:
    row = {"status": "ok", f"exact.{metrics.PSNR}": value, f"exact.{metrics.RMSE}": 0.0}
    return Snapshot("softly", {"cell": row})


def test_a_metric_that_has_no_value_any_more_is_lost(before: Path) -> None:
    lost = compared(before, exact(metrics.SSIM, None))
    assert found(lost) == [("lost", ALPHA, f"exact.{metrics.SSIM}")]
    assert not lost.passed


def test_an_unstable_cell_loses_all_metrics(before: Path) -> None:
    def change(item: Record) -> Record:
        item = changed(item, "status", "unstable")
        item = changed(item, "outcome.nonfinite.nan", 3)
        return cast(Record, changed(item, "outcome.scores.exact.metrics", dict.fromkeys(VALUES)))

    verdicts = {name: verdict for verdict, _, name in found(compared(before, change))}
    assert verdicts.pop("status") == "changed"
    assert verdicts.pop("nonfinite.nan") == "changed"
    assert set(verdicts.values()) == {"lost"}
    assert f"exact.{metrics.PSNR}" in verdicts


@pytest.mark.parametrize(
    ("change", "name"),
    [
        (field("outcome.statistics.fragments", 10_001), "fragments"),
        (field("outcome.statistics.fragments", 9_999), "fragments"),
        (field("outcome.statistics.complexity.worst", 5), "max_depth_complexity"),
        (field("outcome.memory.bytes", 961), "memory.bytes"),
        (field("outcome.traffic.bytes", 49_999), "traffic.bytes"),
        (field("outcome.nonfinite.negative", 1), "nonfinite.negative"),
        (field("outcome.passes", [PassRuns("peel", 8)]), "passes"),
        (
            field("outcome.passes", [PassRuns("peel", 7), PassRuns("resolve", 1)]),
            "passes",
        ),
        (field("outcome.effects.missing", ["REFRACTION"]), "effects.missing"),
        (field("status", "unstable"), "status"),
    ],
)
def test_repeatable_fields_must_be_equal(before: Path, change: Change, name: str) -> None:
    comparison = compared(before, change)
    assert found(comparison) == [("changed", ALPHA, name)]
    assert not comparison.passed


def test_another_renderer_may_differ_in_a_few_fragments(before: Path) -> None:
    for fragments, passed in ((10_021, True), (10_022, False)):
        comparison = compared(before, field("outcome.statistics.fragments", fragments), "hardly")
        assert comparison.passed == passed
        assert "'softly'" in str(comparison)
        assert "'hardly'" in str(comparison)


def test_the_tolerances_of_metrics_hold_for_another_renderer(before: Path) -> None:
    worse = exact(metrics.RMSE, 0.06)
    assert found(compared(before, worse, "hardly")) == [("worse", ALPHA, f"exact.{metrics.RMSE}")]


def test_a_cell_that_failed_is_one_difference(before: Path) -> None:
    comparison = compared(before, lambda _: failed("mean", "/home/me/x.glsl:3: error"))
    assert found(comparison) == [("changed", ALPHA, "status")]
    assert (comparison.differences[0].before, comparison.differences[0].now) == ("ok", "failed")


def test_a_metric_that_is_no_longer_recorded_is_lost(before: Path) -> None:
    kept = {name: value for name, value in VALUES.items() if name != metrics.RMSE}
    change = field("outcome.scores.exact.metrics", kept)
    assert found(compared(before, change)) == [("lost", ALPHA, f"exact.{metrics.RMSE}")]


def test_metrics_that_the_baseline_lacks_are_not_compared(before: Path) -> None:
    assert compared(before, exact(metrics.ORDER_SPREAD_MAX, 0.5)).differences == ()


def test_missing_cells_are_regressions_and_new_ones_are_not(before: Path) -> None:
    new, folder = record("peel[layers=9]"), before.parent / "now"
    comparison = oitbench.compare(write(folder, [record("mean"), new]), before)
    assert comparison.cells == 1
    added = ("added", BETA.replace("=8]", "=9]"), "")
    assert set(found(comparison)) == {("missing", BETA, ""), added}
    assert not comparison.passed
    kept = [record("mean"), record("peel[layers=8]")]
    comparison = oitbench.compare(write(folder, [*kept, new]), before)
    assert found(comparison) == [added]
    assert comparison.passed
    assert str(comparison) == "2 cells compared, 0 regressions, 0 improvements, 1 new cell"


def test_a_change_of_time_is_a_difference_that_does_not_fail(before: Path) -> None:
    comparison = compared(before, slower)
    assert comparison.passed
    assert found(comparison) == [("slower", ALPHA, "method_ms")]
    back = oitbench.compare(before, before.parent / "now")
    assert found(back) == [("faster", ALPHA, "method_ms")]


def test_times_of_two_renderers_are_not_compared(before: Path) -> None:
    assert compared(before, slower, "hardly").differences == ()


def test_times_whose_intervals_overlap_are_equal(before: Path) -> None:
    assert compared(before, field("time.method_ms.high", 2.3)).differences == ()


def test_times_without_an_interval_are_not_compared(before: Path) -> None:
    few = Interval(9.0, None, None, None, [9.0] * 5)
    assert compared(before, field("time.method_ms", few)).differences == ()


def test_times_that_were_disturbed_are_not_compared(before: Path) -> None:
    assert compared(before, field("time", timed(9.0))).differences != ()
    assert compared(before, field("time", timed(9.0, foreign=0.06))).differences == ()


def test_a_file_that_does_not_exist_is_refused(before: Path) -> None:
    with pytest.raises(UsageError, match="cannot be read"):
        oitbench.compare(before, before / "nothing")


def judged(name: str, value: float, facts: CustomMetric = MAE) -> Change:
    """Return the change of a cell to one with a metric of a user's file."""

    def change(item: Record) -> Record:
        scored = changed(item, f"outcome.scores.exact.metrics.{name}", value)
        return cast(Record, changed(scored, "outcome.custom", {name: facts}))

    return change


@pytest.mark.parametrize("kind", ["folder", "file"])
@pytest.mark.parametrize(
    ("value", "higher", "verdict"),
    [
        (2.0, False, None),
        (2.29, False, None),
        (2.31, False, "worse"),
        (1.69, False, "better"),
        (2.31, True, "better"),
        (1.69, True, "worse"),
    ],
)
def test_a_users_metric_is_judged_by_its_direction_and_tolerances(
    before: Path, kind: str, value: float, higher: bool, verdict: str | None
) -> None:
    facts = CustomMetric(higher, 0.1, 0.1, "digest")
    old: Path = write(before.parent / "old", [judged("mae", 2.0, facts)(record("mean"))])
    new = write(before.parent / "new", [judged("mae", value, facts)(record("mean"))])
    if kind == "file":
        old = before.parent / "baseline.json"
        baseline.save(before.parent / "old", old)
    expected = [(verdict, ALPHA, "exact.mae")] if verdict else []
    assert found(oitbench.compare(new, old)) == expected


def test_values_of_a_users_metric_that_has_changed_are_not_compared(before: Path) -> None:
    other = CustomMetric(False, 0.1, 0.0, "other")
    old = write(before.parent / "old", [judged("mae", 2.0)(record("mean"))])
    new = write(before.parent / "new", [judged("mae", 2.0, other)(record("mean"))])
    assert found(oitbench.compare(new, old)) == [("changed", ALPHA, "exact.mae")]


def test_a_users_metric_that_only_one_side_has_is_lost_or_new(before: Path) -> None:
    scored = write(before.parent / "scored", [judged("mae", 2.0)(record("mean"))])
    plain = write(before.parent / "plain", [record("mean")])
    assert found(oitbench.compare(plain, scored)) == [("lost", ALPHA, "exact.mae")]
    assert found(oitbench.compare(scored, plain)) == []


def test_the_tolerance_of_a_users_metric_in_a_baseline_cannot_be_edited(before: Path) -> None:
    file = before.parent / "baseline.json"
    baseline.save(write(before.parent / "old", [judged("mae", 2.0)(record("mean"))]), file)
    file.write_text(file.read_text().replace('"tolerance": 0.1', '"tolerance": 9.1'))
    with pytest.raises(UsageError, match="damaged or was edited by hand"):
        oitbench.compare(before, file)
