"""Tables for readers of Markdown."""

from __future__ import annotations

from pathlib import Path

from oitbench.image.metrics import FLIP_LDR
from oitbench.report import markdown
from oitbench.results.records import Results
from oitbench.results.schema import Record
from oitbench.truths import EXACT
from tests.report.made_up import FACTS, finished, unfinished, with_effects


def test_scenes_are_rows_and_methods_are_columns(tmp_path: Path) -> None:
    records = [
        finished(tmp_path, "panes", "glow", 0.0),
        finished(tmp_path, "panes", "murk", 0.3),
        finished(tmp_path, "lists", "glow", 0.0, traced=False),
        unfinished("lists", "murk"),
    ]
    tables = markdown.tables(Results(tmp_path, tuple(records), FACTS)).split("\n\nF")
    ranked, matched, full = tables
    assert ranked.splitlines()[2:] == [
        "| scene | truth | noise floor | `glow` | `murk` |",
        "| --- | --- | --- | --- | --- |",
        f"| panes | exact | – | **0.0000**, 2.00 ms | {error(records[1])}, 1.70 ms |",
        "| lists | exact | – | 0.0000, 2.00 ms | –, – |",
    ]
    for table, name in ((matched, "matched tracing"), (full, "full path tracing")):
        title, _, *rows = table.splitlines()
        assert f"LIP against {name}" in title
        assert rows == [
            "| scene | noise floor | `glow` | `murk` |",
            "| --- | --- | --- | --- |",
            f"| panes | 0.0100 | 0.0000 | {error(records[1])} |",
        ]


def test_compositing_alone_ranks_no_scene_with_diffusion(tmp_path: Path) -> None:
    cells = [
        with_effects(tmp_path, "full", 0.1),
        with_effects(tmp_path, "alike", 0.1),
        with_effects(tmp_path, "plain", 0.4, missing=["DIFFUSION"]),
    ]
    ranked, exact, *_ = markdown.tables(Results(tmp_path, tuple(cells), FACTS)).split("\n\nF")
    (row,) = ranked.splitlines()[4:]
    # Ties with the best are bold.
    assert row.startswith("| panes | matched | 0.0100 | **")
    assert row.count("**") == 4
    assert exact.startswith("LIP against exact compositing: compositing only, no ranking\n")


def test_runs_without_path_tracing_have_one_table(tmp_path: Path) -> None:
    record = finished(tmp_path, "lists", "glow", 0.0, traced=False)
    text = markdown.tables(Results(tmp_path, (record,), FACTS))
    assert text.count("| scene |") == 1


def error(record: Record) -> str:
    value = record.metric(EXACT, FLIP_LDR)
    assert value is not None
    return f"{value:.4f}"
