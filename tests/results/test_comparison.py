"""Regressions, on made-up cells: passes, remarks and failures."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import msgspec
import pytest

import oitbench
from oitbench.cli import main
from oitbench.errors import UsageError
from oitbench.image import metrics
from oitbench.results import baseline
from oitbench.results import comparison as regression
from oitbench.results.baseline import Snapshot
from oitbench.results.comparison import TOLERANCES, Comparison, Tolerance
from oitbench.results.schema import Interval, PassRuns, Record, Renderer
from oitbench.results.store import Store
from tests.made_up import FACTS, VALUES, changed, failed, record, write

ALPHA = "glass[count=4] mean 8x6 effects=requested ssaa=2"
SPREADS = {metrics.ORDER_SPREAD_MAX, metrics.ORDER_SPREAD_MEAN}
"""Metrics that `metrics.compare` does not give."""
BETA = "glass[count=4] peel[layers=8] 8x6 effects=requested ssaa=2"
Change = Callable[[Record], Record]


@pytest.fixture
def before(tmp_path: Path) -> Path:
    return write(tmp_path / "before", [record("mean"), record("peel[layers=8]")])


def compared(before: Path, change: Change, renderer: str = "softly") -> Comparison:
    """Compare a run whose first cell was changed."""
    records = [change(record("mean")), record("peel[layers=8]")]
    facts = msgspec.structs.replace(FACTS, gl=Renderer(renderer))
    return oitbench.compare(write(before.parent / "now", records, facts), before)


def field(path: str, value: Any) -> Change:
    """Return the change of one field."""
    return lambda item: cast(Record, changed(item, path, value))


def found(comparison: Comparison) -> list[tuple[str, str, str]]:
    return [(item.verdict, item.cell, item.field) for item in comparison.differences]


def exact(name: str, value: float | None) -> Change:
    return field(f"outcome.scores.exact.metrics.{name}", value)


def test_every_metric_has_a_tolerance_and_the_direction_of_the_metrics() -> None:
    assert set(TOLERANCES) == {*metrics.NAMES, metrics.TRANSMITTANCE, *SPREADS}
    higher = {name for name, entry in TOLERANCES.items() if entry.higher_is_better}
    assert higher == {metrics.SSIM, metrics.PSNR}


def test_a_run_equals_itself(before: Path) -> None:
    comparison = oitbench.compare(before, before)
    assert comparison.passed
    assert comparison.cells == 2
    assert comparison.differences == ()


@pytest.mark.parametrize("name", sorted(set(TOLERANCES) - SPREADS))
def test_a_metric_may_move_within_its_tolerance_and_no_further(before: Path, name: str) -> None:
    value = VALUES[name]
    assert value is not None
    allowed = TOLERANCES[name].absolute + TOLERANCES[name].relative * value
    worse = -1 if TOLERANCES[name].higher_is_better else 1
    for step, verdict in ((0.9, None), (1.1, "worse"), (-0.9, None), (-1.1, "better")):
        comparison = compared(before, exact(name, value + worse * step * allowed))
        wanted = [(verdict, ALPHA, f"exact.{name}")] if verdict else []
        assert found(comparison) == wanted, step
        assert comparison.passed == (verdict != "worse")
        assert bool(comparison.improvements) == (verdict == "better")


def test_the_path_traced_truth_is_gated_too(before: Path) -> None:
    change = field(f"outcome.scores.path_traced.metrics.{metrics.RMSE}", 0.1)
    assert found(compared(before, change)) == [("worse", ALPHA, f"path_traced.{metrics.RMSE}")]


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
def test_above_its_ceiling_a_ratio_shows_no_difference(
    old: float | None, new: float | None, verdict: str | None
) -> None:
    """The ratio of equal images, which has no finite value, counts as the ceiling."""
    findings = regression.compare_snapshots(ratio(new), ratio(old)).differences
    assert [finding.verdict for finding in findings] == ([verdict] if verdict else [])


def ratio(value: float | None) -> Snapshot:
    row = {"status": "ok", f"exact.{metrics.PSNR}": value, f"exact.{metrics.RMSE}": 0.0}
    return Snapshot("softly", {"cell": row})


def test_a_metric_without_a_value_is_lost_and_not_equal(before: Path) -> None:
    lost = compared(before, exact(metrics.SSIM, None))
    assert found(lost) == [("lost", ALPHA, f"exact.{metrics.SSIM}")]
    assert not lost.passed


def test_without_any_value_an_unstable_cell_has_lost_all(before: Path) -> None:
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
        (field("outcome.fragments", 10_001), "fragments"),
        (field("outcome.fragments", 9_999), "fragments"),
        (field("outcome.max_depth_complexity", 5), "max_depth_complexity"),
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
def test_what_must_repeat_is_exact_both_ways(before: Path, change: Change, name: str) -> None:
    comparison = compared(before, change)
    assert found(comparison) == [("changed", ALPHA, name)]
    assert not comparison.passed


def test_another_renderer_may_disagree_about_a_few_edges_only(before: Path) -> None:
    for fragments, passed in ((10_021, True), (10_022, False)):
        comparison = compared(before, field("outcome.fragments", fragments), "hardly")
        assert comparison.passed == passed
        assert "'softly'" in str(comparison)
        assert "'hardly'" in str(comparison)


def test_another_renderer_has_the_same_tolerance_of_metrics(before: Path) -> None:
    worse = exact(metrics.RMSE, 0.06)
    assert found(compared(before, worse, "hardly")) == [("worse", ALPHA, f"exact.{metrics.RMSE}")]


def test_a_cell_that_failed_is_told_once(before: Path) -> None:
    comparison = compared(before, lambda _: failed("mean", "/home/me/x.glsl:3: error"))
    assert found(comparison) == [("changed", ALPHA, "status")]
    assert (comparison.differences[0].before, comparison.differences[0].now) == ("ok", "failed")


def test_a_number_that_a_run_no_longer_records_is_lost(before: Path) -> None:
    lost = [name for name in VALUES if name != metrics.RMSE]
    change = field("outcome.scores.exact.metrics", {name: VALUES[name] for name in lost})
    assert found(compared(before, change)) == [("lost", ALPHA, f"exact.{metrics.RMSE}")]


def test_what_the_baseline_does_not_hold_is_not_judged(before: Path) -> None:
    assert compared(before, exact(metrics.ORDER_SPREAD_MAX, 0.5)).differences == ()


def test_missing_and_orphaned_cells_are_listed(before: Path) -> None:
    now = write(before.parent / "now", [record("mean"), record("peel[layers=9]")])
    comparison = oitbench.compare(now, before)
    assert comparison.cells == 1
    orphan = BETA.replace("=8]", "=9]")
    assert set(found(comparison)) == {("missing", BETA, ""), ("orphaned", orphan, "")}
    assert not comparison.passed


slow = field("time.frame_ms", Interval(9.0, 8.0, 10.0, [9.0]))


def test_times_are_told_for_one_renderer_and_never_fail(before: Path) -> None:
    comparison = compared(before, slow)
    assert comparison.passed
    assert found(comparison) == [("slower", ALPHA, "frame_ms")]
    back = oitbench.compare(before, before.parent / "now")
    assert found(back) == [("faster", ALPHA, "frame_ms")]


def test_times_of_two_renderers_are_not_compared(before: Path) -> None:
    assert compared(before, slow, "hardly").differences == ()


def test_times_that_overlap_are_not_found(before: Path) -> None:
    assert compared(before, field("time.frame_ms.high", 2.3)).differences == ()


def test_a_baseline_file_holds_what_its_folder_does_but_times(before: Path, tmp_path: Path) -> None:
    file = tmp_path / "baseline.json"
    baseline.save(before, file)
    assert baseline.read(file).rows == baseline.read(before).rows
    assert oitbench.compare(before, file).differences == ()
    compared(before, slow)
    assert oitbench.compare(before.parent / "now", file).differences == ()


def test_a_baseline_file_is_stable_rounded_and_names_no_machine(
    before: Path, tmp_path: Path
) -> None:
    first, second = tmp_path / "a.json", tmp_path / "b.json"
    baseline.save(before, first)
    noisy = exact(metrics.RMSE, 0.05 + 1e-9)
    compared(before, noisy)
    store = Store.open(before.parent / "now")
    turned = write(tmp_path / "turned", store.records()[::-1])
    baseline.save(turned, second)
    assert first.read_bytes() == second.read_bytes()
    text = first.read_text()
    content = json.loads(text)
    assert text == json.dumps(content, indent=1, sort_keys=True, ensure_ascii=False) + "\n"
    assert content["renderer"] == "softly"
    assert content["cells"][BETA]["passes"] == "peel × 8, resolve"
    for word in ("/home", ".exr", "frame_ms", "samples", str(tmp_path)):
        assert word not in text


def call(monkeypatch: pytest.MonkeyPatch, *arguments: str | Path) -> int:
    monkeypatch.setattr(sys, "argv", ["oitbench", *map(str, arguments)])
    try:
        main()
    except SystemExit as stop:
        return stop.code if isinstance(stop.code, int) else 1
    return 0


def test_verbs_save_and_check_by_default_names(
    before: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert call(monkeypatch, "baseline", "save", before) == 0
    assert capsys.readouterr().out == "baseline.json: 2 cells\n"
    assert call(monkeypatch, "baseline", "check", before) == 0
    assert capsys.readouterr().out == "2 cells compared, 0 regressions, 0 improvements\n"
    assert call(monkeypatch, "compare", before, "baseline.json") == 0
    compared(before, exact(metrics.RMSE, 0.06))
    assert call(monkeypatch, "baseline", "check", "now", "--baseline", "baseline.json") == 1
    printed = capsys.readouterr().out
    (line,) = [line for line in printed.splitlines() if metrics.RMSE in line]
    assert line.split() == ["worse", *ALPHA.split(), f"exact.{metrics.RMSE}", "0.05", "0.06"]
    assert "1 regression," in printed


def test_json_tells_every_finding(
    before: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    compared(before, exact(metrics.SSIM, 0.99))
    now = before.parent / "now"
    assert call(monkeypatch, "compare", now, before, "--json") == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts == {
        "passed": True,
        "cells": 2,
        "renderer": {"before": "softly", "now": "softly"},
        "differences": [
            {
                "cell": ALPHA,
                "field": f"exact.{metrics.SSIM}",
                "before": 0.9,
                "now": 0.99,
                "verdict": "better",
                "regression": False,
            }
        ],
    }
    assert call(monkeypatch, "compare", before, now, "--json") == 1
    assert json.loads(capsys.readouterr().out)["passed"] is False


@pytest.mark.parametrize(
    ("content", "part"),
    [
        ("", "is no baseline"),
        ("[1]", "is no baseline of format 2"),
        ('{"format": 1, "renderer": "a", "cells": {}}', "is no baseline of format 2"),
        ('{"format": 2, "cells": {}}', "lacks its renderer or its cells"),
        ('{"format": 2, "renderer": "a", "cells": []}', "lacks its renderer or its cells"),
        ('{"format": 2, "renderer": "a", "cells": {"x": {}}}', "the cell x is damaged"),
        (
            '{"format": 2, "renderer": "a", "cells": {"x": {"status": "ok", "exact.f": "1"}}}',
            "the cell x is damaged",
        ),
        (
            '{"format": 2, "renderer": "a", "cells": {"x": {"status": "ok", "exact.f": NaN}}}',
            "NaN is not a number",
        ),
    ],
)
def test_a_bad_baseline_gets_one_line_and_code_2(
    content: str,
    part: str,
    before: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    bad = before.parent / "bad.json"
    bad.write_text(content)
    assert call(monkeypatch, "compare", before, bad) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert part in printed.err
    assert printed.err.count("\n") == 1


def test_paths_that_cannot_be_used_get_one_line_and_code_2(
    before: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    empty = before.parent / "empty"
    empty.mkdir()
    for arguments, part in (
        (("compare", before, "no/such/file"), "no/such/file cannot be read"),
        (("compare", empty, before), "holds no cells.jsonl"),
        (("baseline", "save", empty), "holds no cells.jsonl"),
        (("baseline", "save", before, "-o", empty / "no" / "b.json"), "cannot be written"),
        (("baseline", "check", before, "--baseline", empty / "b.json"), "cannot be read"),
        (("baseline", "sav", before), "sav"),
    ):
        assert call(monkeypatch, *arguments) == 2, arguments
        printed = capsys.readouterr().err
        assert part in printed
        assert printed.count("\n") == 1


def test_python_gets_the_same_errors(before: Path) -> None:
    with pytest.raises(UsageError, match="cannot be read"):
        oitbench.compare(before, before / "nothing")
