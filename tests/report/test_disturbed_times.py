"""Every page that shows a disturbed time shows that it is disturbed."""

from __future__ import annotations

import csv
from pathlib import Path

import msgspec
import pytest

from oitbench.plugins import Collection
from oitbench.report import accounts, markdown, page
from oitbench.report.artifacts import Column, Marked
from oitbench.report.times import explain, marked
from oitbench.results.records import Results
from oitbench.results.schema import Record
from oitbench.results.times import SIGN
from tests.made_up import timed
from tests.report.made_up import FACTS, context, finished, store, with_effects

REPORTS = Collection.load().reports
TIMED = {name: REPORTS.path(name) for name in ("ablation", "pareto", "table", "time")}


def records(folder: Path, foreign: float) -> list[Record]:
    """Return cells of one scene that were timed in one block, an effect left out in one of them."""
    made = [
        with_effects(folder, "full", 0.1),
        with_effects(folder, "full", 0.3, effects="-diffusion", gone=["DIFFUSION"]),
        with_effects(folder, "less", 0.2),
    ]
    time = timed(5.0, sort_ms=1.0, foreign=foreign)
    return [msgspec.structs.replace(record, time=time) for record in made]


def timed_tables(folder: Path) -> dict[str, list[dict[str, str]]]:
    """Return the rows of all tables with times, by name."""
    found = {}
    for path in folder.glob("*.csv"):
        with path.open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        if any(key == "ms" or "_ms" in key for key in rows[0]):
            found[path.stem] = rows
    return found


@pytest.mark.parametrize(("foreign", "mark"), [(0.04, ""), (0.06, "yes")])
def test_every_page_and_table_with_times_has_the_mark(
    tmp_path: Path, foreign: float, mark: str
) -> None:
    made = records(tmp_path, foreign)
    written = page.write(store(tmp_path, *made), tmp_path / "report", TIMED).path
    tables = timed_tables(tmp_path / "report")
    assert set(tables) == set(TIMED)
    for name, rows in tables.items():
        assert {row["disturbed"] for row in rows} == {mark}, name
    text = written.read_text(encoding="utf-8")
    assert (f"{SIGN} Disturbed times." in text) is bool(mark)
    assert (f"5.00 {SIGN}" in text) is bool(mark)
    tables_of_readme = markdown.tables(Results(tmp_path, tuple(made), FACTS))
    assert (f"5.00 ms {SIGN}" in tables_of_readme) is bool(mark)


def test_plots_have_the_mark(tmp_path: Path) -> None:
    (cell,) = [finished(tmp_path, "panes", "murk", 0.2, time=timed(5.0, foreign=0.06))]
    assert cell.time is not None
    assert cell.outcome is not None
    assert REPORTS["pareto"].Point("murk", cell.time, 0.5).label == f"murk {SIGN}"
    shown = context(tmp_path, [cell], tmp_path / "report")
    bar: accounts.Bar = REPORTS["time"]._bar(shown, cell, cell.outcome)
    assert bar.total.endswith(f" {SIGN}")
    assert SIGN in explain([cell])


def test_only_times_get_the_sign() -> None:
    values = {"frame_ms": 2.0, "ms": 3.0, "sort_ms": None, "memory": 4.0}
    found = marked(values, disturbed=True)
    assert [key for key, value in found.items() if isinstance(value, Marked)] == ["frame_ms", "ms"]
    assert Column("frame_ms", "Frame").text(found["frame_ms"]) == f"2.00 {SIGN}"
    assert marked(values, disturbed=False) == {**values, "disturbed": ""}
