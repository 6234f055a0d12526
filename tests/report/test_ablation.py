"""Effects left out one at a time: what reports say of their cost and gain, and how they show it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from oitbench.image import metrics
from oitbench.plugins import Collection
from oitbench.report import Figure, ImageGrid, Note, Table, write
from oitbench.results.records import Results, fullest, shaded_total
from oitbench.results.store import Record, Store
from tests.report.test_report import finished, unfinished

CALLED = ["COVERAGE", "DIFFUSION", "SHADOWS", "TRANSLUCENT_SHADOWS", "COLORED_SHADOWS"]
FLOOR = 0.01
REPORTS = Collection.load().reports


def cell(folder: Path, method: str, effects: str, error: float, **more: Any) -> Record:
    """Return a record of that variant; `more` may tell `gone`, `missing`, `ms`, `shading`."""
    gone, missing = more.get("gone", ()), list(more.get("missing", ()))
    milliseconds = more.get("ms", 10.0)
    called = [name for name in CALLED if name not in gone]
    record = finished(folder, "panes", method, error)
    return record | {
        "variant": {"ssaa": 2, "effects": effects},
        "effects": {"called": called, "expressed": called, "missing": missing},
        "time": {
            "frame_ms": {
                "median": milliseconds,
                "low": milliseconds - 0.1,
                "high": milliseconds + 0.1,
                "samples": [milliseconds - 0.1, milliseconds, milliseconds + 0.1],
            }
        },
        "shading": {"memory": {"bytes": more.get("shading", 2**20)}, "traffic": {"bytes": 0}},
    }


def records(folder: Path) -> list[Record]:
    shadows = ("TRANSLUCENT_SHADOWS", "COLORED_SHADOWS")
    return [
        cell(folder, "full", "called", 0.1),
        cell(folder, "full", "-diffusion", 0.3, gone=("DIFFUSION",), ms=7.0),
        cell(folder, "full", "-translucent_shadows", 0.1, gone=shadows, ms=6.0, shading=0),
        cell(folder, "full", "-shadows", 0.05, gone=("SHADOWS",), ms=10.5),
        cell(folder, "plain", "called", 0.4, missing=["DIFFUSION"], ms=5.0),
        unfinished("panes", "plain", "failed", "no")
        | {"variant": {"ssaa": 2, "effects": "-shadows"}},
    ]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("results")
    store = Store.open(path)
    for record in records(path):
        store.append(record)
    return path


@pytest.fixture(scope="module")
def results(folder: Path) -> Results:
    return Results.load(folder)


def test_what_leaves_effects_out_belongs_to_the_panel_of_what_does_not(results: Results) -> None:
    (panel,) = results.panels()
    assert panel.title == "panes"
    assert [record["method"] for record in panel.cells] == ["full", "plain"]
    told = {a.named: a.implied for a in panel.ablations if a.complete is panel.cells[0]}
    assert told == {
        ("diffusion",): (),
        ("translucent shadows",): ("colored shadows",),
        ("shadows",): (),
    }
    assert panel.ablations[-1].without["status"] == "failed"


def test_a_variant_without_its_complete_cell_has_a_panel_of_its_own(folder: Path) -> None:
    alone = cell(folder, "full", "-diffusion", 0.3, gone=("DIFFUSION",))
    (panel,) = Results(folder, (alone,), {}).panels()
    assert panel.ablations == ()
    assert panel.cells == (alone,)


def test_costs_and_gains(results: Results, tmp_path: Path) -> None:
    figure, table = REPORTS["ablation"].build(results, tmp_path)
    assert isinstance(figure, Figure)
    assert figure.png.stat().st_size > 0
    assert isinstance(table, Table)
    rows = pd.read_csv(table.csv).set_index("left_out")
    # The failed cell tells nothing and has no row.
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
    assert rows.loc["translucent shadows", "with_it"] == "colored shadows"


def test_the_interval_follows_from_ends_where_there_are_no_samples() -> None:
    def timed(median: float, low: float, high: float) -> Record:
        return {"time": {"frame_ms": {"median": median, "low": low, "high": high}}}

    saved = REPORTS["ablation"].saved_time(timed(10, 7, 14), timed(4, 1, 8))
    assert saved == pytest.approx((6.0, 1.0, 11.0))
    assert REPORTS["ablation"].saved_time(timed(10, 7, 14), {"time": None}) is None


def test_shading_counts(results: Results) -> None:
    (panel,) = results.panels()
    assert shaded_total(panel.cells[0], "memory") == 3072 + 2**20
    assert shaded_total({"memory": {"bytes": 5}}, "memory") == 5
    assert shaded_total({"shading": {"memory": {"bytes": 5}}}, "memory") is None


def test_no_cell_is_missing_from_the_table(results: Results, tmp_path: Path) -> None:
    (table,) = REPORTS["table"].build(results, tmp_path)
    rows = pd.read_csv(table.csv, keep_default_na=False)
    assert len(rows) == len(results.records)
    assert sorted(rows["left_out"])[2:] == [
        "diffusion",
        "shadows",
        "shadows",
        "translucent shadows",
    ]
    assert (rows.loc[rows["left_out"] != "", "path_traced.rank"] == "").all()


def test_the_fullest_misses_least_then_errs_least(folder: Path) -> None:
    near = cell(folder, "near", "called", 0.1, missing=["DIFFUSION"])
    far = cell(folder, "far", "called", 0.4)
    assert fullest([near, far], metrics.FLIP_LDR) is far
    nearer = cell(folder, "nearer", "called", 0.2)
    assert fullest([far, near, nearer], metrics.FLIP_LDR) is nearer
    assert fullest([], metrics.FLIP_LDR) is None


def payoff(folder: Path, cells: list[Record], out: Path) -> list[str]:
    _, *notes = REPORTS["payoff"].build(Results(folder, tuple(cells), {}), out)
    return [note.text for note in notes]


def test_it_is_told_where_expressing_more_pays(folder: Path, tmp_path: Path) -> None:
    full = cell(folder, "full", "called", 0.1)
    plain = cell(folder, "plain", "called", 0.4, missing=["DIFFUSION"])
    summary, told = payoff(folder, [full, plain], tmp_path)
    assert "in every scene" in summary
    assert "expressing more pays" in told
    assert "plain (misses diffusion)" in told
    rows = pd.read_csv(tmp_path / "payoff.csv", keep_default_na=False)
    assert rows["mark"].to_list() == ["best", ""]


def test_it_is_told_where_expressing_more_does_not_pay(folder: Path, tmp_path: Path) -> None:
    full = cell(folder, "full", "called", 0.4)
    plain = cell(folder, "plain", "called", 0.1, missing=["DIFFUSION"])
    summary, told = payoff(folder, [full, plain], tmp_path)
    assert summary.endswith(f"do not have the lower {metrics.FLIP_LDR} in panes.")
    assert "does not pay" in told
    tied = cell(folder, "plain", "called", 0.4, missing=["DIFFUSION"])
    summary, told = payoff(folder, [full, tied], tmp_path)
    assert summary.endswith("in panes (tied).")
    assert "a tie within the noise floor of 0.0100" in told
    (summary,) = payoff(folder, [full], tmp_path)
    assert "decides nothing" in summary


def test_plates_of_methods_of_diffusion_and_of_variants(results: Results, tmp_path: Path) -> None:
    methods, pair, variants = REPORTS["phenomena"].build(results, tmp_path)
    assert isinstance(methods, ImageGrid)
    assert [tile.label for tile in methods.tiles] == ["path traced", "full", "plain"]
    assert methods.tiles[1].values[1] == "all effects"
    assert methods.tiles[2].values[1] == "misses 1 of 5 effects"
    assert all(tile.error_map is not None for tile in methods.tiles[1:])
    assert isinstance(pair, Figure)
    assert "full" in pair.caption
    assert isinstance(variants, ImageGrid)
    assert [tile.label for tile in variants.tiles] == [
        "path traced",
        "all effects",
        "without diffusion",
        "without translucent shadows",
        "without shadows",
    ]
    assert "Without translucent shadows, colored shadows would mean nothing" in variants.caption


@pytest.mark.parametrize("name", ["ablation", "payoff", "phenomena"])
def test_results_without_effects_get_a_note(name: str, tmp_path: Path) -> None:
    plain = finished(tmp_path, "panes", "murk", 0.2)
    for cells in ((), (plain,), (unfinished("panes", "murk", "failed", "no"),)):
        (note,) = REPORTS[name].build(Results(tmp_path, cells, {}), tmp_path)
        assert isinstance(note, Note)


def test_gains_without_times_are_listed_all_the_same(folder: Path, tmp_path: Path) -> None:
    cells = tuple({**record, "time": None} for record in records(folder)[:2])
    note, table = REPORTS["ablation"].build(Results(folder, cells, {}), tmp_path)
    assert isinstance(note, Note)
    assert pd.read_csv(table.csv)["verdict"].to_list() == ["better"]


def test_the_page_holds_them_all(folder: Path, tmp_path: Path) -> None:
    names = ("ablation", "payoff", "table")
    page = write(folder, tmp_path, {name: REPORTS[name] for name in names})
    text = page.read_text(encoding="utf-8")
    for part in ("ablation.png", "payoff.csv", "Left out", "translucent shadows"):
        assert part in text
