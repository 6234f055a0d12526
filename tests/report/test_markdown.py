"""Tables for readers of Markdown."""

from __future__ import annotations

from pathlib import Path

from oitbench.image.metrics import FLIP_LDR
from oitbench.report import markdown
from oitbench.results.records import Results
from oitbench.results.schema import EXACT, Record
from tests.report.made_up import FACTS, finished, unfinished


def test_scenes_are_rows_and_methods_are_columns(tmp_path: Path) -> None:
    records = [
        finished(tmp_path, "panes", "glow", 0.0),
        finished(tmp_path, "panes", "murk", 0.3),
        finished(tmp_path, "lists", "glow", 0.0, traced=False),
        unfinished("lists", "murk"),
    ]
    exact, traced = markdown.tables(Results(tmp_path, tuple(records), FACTS)).split("\n\nF")
    assert exact.splitlines()[2:] == [
        "| scene | `glow` | `murk` |",
        "| --- | --- | --- |",
        f"| panes | 0.0000, 2 ms | {error(records[1], 4)}, 1.7 ms |",
        "| lists | 0.0000, 2 ms | –, – |",
    ]
    assert traced.splitlines()[2:] == [
        "| scene | noise floor | `glow` | `murk` |",
        "| --- | --- | --- | --- |",
        f"| panes | 0.010 | 0.000 | {error(records[1], 3)} |",
    ]


def test_runs_without_path_tracing_have_one_table(tmp_path: Path) -> None:
    record = finished(tmp_path, "lists", "glow", 0.0, traced=False)
    text = markdown.tables(Results(tmp_path, (record,), FACTS))
    assert text.count("| scene |") == 1


def error(record: Record, decimals: int) -> str:
    value = record.metric(EXACT, FLIP_LDR)
    assert value is not None
    return f"{value:.{decimals}f}"
