"""The report of effects that were left out one at a time."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pandas as pd
import pytest

from oitbench.image import metrics
from oitbench.plugins import Collection
from oitbench.report import Figure, Note, Table, write
from oitbench.results.schema import Record
from tests.report.made_up import FLOOR, context, finished, store, unfinished, with_effects

REPORTS = Collection.load().reports


def records(folder: Path) -> list[Record]:
    shadows = ("TRANSLUCENT_SHADOWS", "COLORED_SHADOWS")
    return [
        with_effects(folder, "full", 0.1),
        with_effects(folder, "full", 0.3, effects="-diffusion", gone=["DIFFUSION"], ms=7.0),
        with_effects(
            folder, "full", 0.1, effects="-translucent_shadows", gone=shadows, ms=6.0, shadow_maps=0
        ),
        with_effects(folder, "full", 0.05, effects="-shadows", gone=["SHADOWS"], ms=10.5),
        with_effects(folder, "plain", 0.4, missing=["DIFFUSION"], ms=5.0),
        unfinished("panes", "plain", effects="-shadows"),
    ]


def test_costs_and_gains(tmp_path: Path) -> None:
    shown = context(tmp_path, records(tmp_path), tmp_path)
    figure, table = REPORTS["ablation"].build(shown)
    assert isinstance(figure, Figure)
    assert figure.png.stat().st_size > 0
    assert isinstance(table, Table)
    rows = pd.read_csv(table.csv).set_index("left_out")
    # The failed cell has no costs and no row.
    assert len(rows) == 3
    assert rows["saved_ms"].to_dict() == pytest.approx(
        {"diffusion": 3.0, "translucent shadows": 4.0, "shadows": -0.5}
    )
    assert (rows["saved_ms_low"] < rows["saved_ms"]).all()
    assert (rows["saved_ms"] < rows["saved_ms_high"]).all()
    assert rows["saved_mib"].to_dict() == {
        "diffusion": 0.0,
        "translucent shadows": 1.0,
        "shadows": 0.0,
    }
    gains = rows[f"gain.{metrics.FLIP_LDR}"].to_dict()
    assert gains["diffusion"] > FLOOR
    assert gains["shadows"] < -FLOOR
    assert rows["verdict"].to_dict() == {
        "diffusion": "better",
        "translucent shadows": "tie",
        "shadows": "worse",
    }
    assert rows.loc["translucent shadows", "also_left_out"] == "colored shadows"


def test_gains_are_listed_without_times(tmp_path: Path) -> None:
    cells = [msgspec.structs.replace(cell, time=None) for cell in records(tmp_path)[:2]]
    note, table = REPORTS["ablation"].build(context(tmp_path, cells, tmp_path))
    assert isinstance(note, Note)
    assert pd.read_csv(table.csv)["verdict"].to_list() == ["better"]


@pytest.mark.parametrize("name", ["ablation", "payoff", "phenomena"])
def test_results_without_effects_get_a_note(name: str, tmp_path: Path) -> None:
    plain = finished(tmp_path, "panes", "murk", 0.2)
    for cells in ([], [plain], [unfinished("panes", "murk")]):
        (note,) = REPORTS[name].build(context(tmp_path, cells, tmp_path))
        assert isinstance(note, Note)


def test_the_page_shows_reports_of_effects(tmp_path: Path) -> None:
    names = ("ablation", "payoff", "table")
    folder = store(tmp_path, *records(tmp_path))
    paths = {name: REPORTS.path(name) for name in names}
    page = write(folder, tmp_path / "out", paths).path
    text = page.read_text(encoding="utf-8")
    for part in ("ablation.png", "payoff.csv", "Left out", "translucent shadows"):
        assert part in text
