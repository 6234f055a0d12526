"""The section of the page about demands and capability classes."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pandas as pd

from oitbench.method.demands import NOTHING, Demands
from oitbench.plugins import Collection
from tests.report.made_up import context, finished, unfinished

CAPABILITY = Collection.load().reports["capability"]


def test_a_method_has_a_row_for_each_of_its_demands_by_class(tmp_path: Path) -> None:
    lists: Demands = msgspec.structs.replace(NOTHING, atomics=True, unbounded=True)
    wide: Demands = msgspec.structs.replace(NOTHING, tile_bits=96, geometry_passes=None)
    cells = [
        finished(tmp_path, "panes", "lists", 0.1, outcome={"demands": lists}),
        finished(tmp_path, "smoke", "lists", 0.1, outcome={"demands": lists}),
        finished(tmp_path, "panes", "glow", 0.1, outcome={"demands": wide}),
        finished(tmp_path, "smoke", "glow", 0.1),
        unfinished("panes", "murk"),
    ]
    (table,) = CAPABILITY.build(context(tmp_path, cells, tmp_path))
    rows = pd.read_csv(table.csv, keep_default_na=False, dtype=str)
    assert rows[["method", "scenes"]].to_numpy().tolist() == [
        ["glow", "smoke"],
        ["glow", "panes"],
        ["lists", "all"],
    ]
    assert rows["class"][2] == "atomics and unbounded buffers"
    assert rows["geometry_passes"].to_list() == ["0", "grow with layers", "0"]
    assert rows["fragment_bits"].to_list() == ["0", "≥ 0", "≥ 0"]


def test_without_finished_cells_there_is_nothing_to_show(tmp_path: Path) -> None:
    assert CAPABILITY.build(context(tmp_path, [unfinished("panes", "murk")], tmp_path)) == []
