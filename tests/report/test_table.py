"""The table of all cells, and ranks with ties."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from oitbench.plugins import Collection
from oitbench.results.custom import CustomMetric
from tests.made_up import changed
from tests.report.made_up import context, unfinished, with_effects

TABLE = Collection.load().reports["table"]


def test_cells_that_leave_effects_out_are_listed_without_a_rank(tmp_path: Path) -> None:
    cells = [
        with_effects(tmp_path, "full", 0.1),
        with_effects(tmp_path, "full", 0.3, effects="-diffusion", gone=["DIFFUSION"]),
        with_effects(tmp_path, "plain", 0.4, missing=["DIFFUSION"]),
        unfinished("panes", "plain", effects="-shadows"),
    ]
    (table,) = TABLE.build(context(tmp_path, cells, tmp_path))
    rows = pd.read_csv(table.csv, keep_default_na=False)
    assert rows["left_out"].to_list() == ["", "", "diffusion", "shadows"]
    assert rows["rank"].to_list() == ["1", "2", "", ""]
    # A scene that requests diffusion is ranked by matched tracing; without it, by compositing.
    assert rows["ranking_truth"].to_list() == ["matched", "matched", "exact", ""]
    assert rows["exact.remark"].to_list() == ["compositing only", "compositing only", "", ""]
    ratio = pd.to_numeric(rows["matched.transparent.flip_ldr@67ppd"][:3]) / pd.to_numeric(
        rows["matched.opaque.flip_ldr@67ppd"][:3]
    )
    assert ratio.to_list() == pytest.approx([3.0] * 3)
    assert rows["missing_effects"].to_list() == ["", "diffusion", "", ""]


def test_metrics_of_users_have_columns_and_cells_may_lack_them(tmp_path: Path) -> None:
    scored = with_effects(tmp_path, "full", 0.1)
    scored = changed(scored, "outcome.scores.matched.metrics.mae", 0.25)
    scored = changed(scored, "outcome.custom", {"mae": CustomMetric(True, 0.0, 0.0, "digest")})
    cells = [scored, with_effects(tmp_path, "plain", 0.4), unfinished("panes", "broken")]
    (table,) = TABLE.build(context(tmp_path, cells, tmp_path))
    rows = pd.read_csv(table.csv)
    assert dict(zip(rows["method"], rows["matched.mae"].fillna(-1), strict=True)) == {
        "broken": -1,
        "full": 0.25,
        "plain": -1,
    }
    assert "exact.mae" not in rows
