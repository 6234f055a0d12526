"""Counts and memory beside those of a paper."""

from __future__ import annotations

import csv
from pathlib import Path

import msgspec
import pytest

from oitbench.report import Note, Table
from oitbench.results.schema import Memory, Record
from oitbench.results.statistics import DepthComplexity
from tests.helpers import collection
from tests.papers.made_up import context, made
from tests.report.made_up import SIDE

REPORT = collection().reports["at_table1"]


def storing(folder: Path, name: str, kind: str, bits: float) -> Record:
    """Return the record of one place of the table, with 700 layers and that many bits per pixel."""
    record = made(folder, REPORT.PICTURES[name, kind].need)
    assert record.outcome is not None
    complexity = DepthComplexity(2.5, 2.0, 700, [])
    statistics = msgspec.structs.replace(record.outcome.statistics, complexity=complexity)
    memory = Memory(0, bits, [])
    outcome = msgspec.structs.replace(record.outcome, memory=memory, statistics=statistics)
    return msgspec.structs.replace(record, outcome=outcome)


def test_each_scene_of_the_paper_is_a_row_with_both_numbers(tmp_path: Path) -> None:
    records = [storing(tmp_path, "HAIR", "lists", 1600), storing(tmp_path, "HAIR", "maps", 640)]
    (table,) = REPORT.build(context(tmp_path, records))
    assert isinstance(table, Table)
    with table.csv.open() as file:
        (row,) = csv.DictReader(file)
    assert (row["scene"], row["paper_scene"], row["size"]) == ("hair", "HAIR", f"{SIDE} × {SIDE}")
    assert (row["worst"], row["paper_worst"]) == ("700", "663")
    assert records[0].outcome is not None
    assert float(row["per_pixel"]) == records[0].outcome.statistics.fragments / SIDE**2
    # 15.0 million fragments, and 174.6 and 63.3 MiB, at 1280 × 720.
    assert round(float(row["paper_per_pixel"]), 2) == 16.28
    assert round(float(row["paper_lists"])) == 199
    assert round(float(row["paper_maps"])) == 72
    assert (float(row["lists"]), float(row["maps"]), row["samples"]) == (200, 80, "")
    assert row["methods"] == "adaptive[nodes=16], opacity_map[memory=fixed]"


@pytest.mark.parametrize(("bits", "word"), [(576, "Reproduced"), (640, "Not reproduced")])
def test_the_verdict_follows_from_the_memory(tmp_path: Path, bits: float, word: str) -> None:
    (table,) = REPORT.build(context(tmp_path, [storing(tmp_path, "HAIR", "maps", bits)]))
    assert f" {word}: 72 bytes per pixel for maps in HAIR ({bits / 8:.0f})." in table.caption


def test_other_scenes_are_no_rows(tmp_path: Path) -> None:
    (note,) = REPORT.build(context(tmp_path, []))
    assert isinstance(note, Note)
