"""The table of all cells, and ranks with ties."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from oitbench.plugins import Collection
from tests.report.made_up import context, unfinished, with_effects

TABLE = Collection.load().reports["table"]


def test_errors_within_the_floor_share_a_rank() -> None:
    errors = {"a": 0.10, "b": 0.105, "c": 0.12, "d": 0.128, "e": 0.2}
    assert TABLE.ties(errors, 0.01) == {"a": "1=", "b": "1=", "c": "3=", "d": "3=", "e": "5"}
    assert TABLE.ties({"a": 0.1, "b": 0.1}, 0.0) == {"a": "1=", "b": "1="}


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
    assert rows["path_traced.rank"].to_list() == ["1", "2", "", ""]
    assert rows["missing_effects"].to_list() == ["", "diffusion", "", ""]
