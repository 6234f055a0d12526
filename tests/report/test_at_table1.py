"""Counts beside those of a paper."""

from __future__ import annotations

import csv
from pathlib import Path

import msgspec

from oitbench.report import Note, Table
from oitbench.results.schema import Memory, Record
from tests.helpers import collection
from tests.report.made_up import SIDE, context, finished
from tests.report.test_scenes import with_counts

build = collection().reports["at_table1"].build


def storing(record: Record, name: str, bits: float) -> Record:
    """Return a record of method `name` with that many bits per pixel."""
    assert record.outcome is not None
    memory = Memory(0, bits, [])
    outcome = msgspec.structs.replace(record.outcome, memory=memory)
    return msgspec.structs.replace(record, method=f"{name}[x=1]", name=name, outcome=outcome)


def test_each_scene_of_the_paper_is_a_row_with_both_numbers(tmp_path: Path) -> None:
    hair = with_counts(tmp_path, "hair[detail=0.5]", 700)
    records = [
        storing(hair, "adaptive", 1600),
        storing(hair, "fourier_map", 640),
        storing(hair, "opacity_map", 8),
        finished(tmp_path, "fog", "glow", 0.1),
    ]
    (table,) = build(context(tmp_path, records, tmp_path))
    assert isinstance(table, Table)
    with table.csv.open() as file:
        (row,) = csv.DictReader(file)
    assert (row["scene"], row["paper_scene"], row["size"]) == (
        "hair[detail=0.5]",
        "HAIR",
        f"{SIDE} × {SIDE}",
    )
    assert (row["worst"], row["paper_worst"]) == ("700", "663")
    assert hair.outcome is not None
    assert float(row["per_pixel"]) == hair.outcome.statistics.fragments / SIDE**2
    # 15.0 million fragments, and 174.6 and 63.3 MiB, at 1280 × 720.
    assert round(float(row["paper_per_pixel"]), 2) == 16.28
    assert round(float(row["paper_lists"])) == 199
    assert round(float(row["paper_maps"])) == 72
    assert (float(row["lists"]), float(row["maps"]), row["samples"]) == (200, 80, "")
    assert row["methods"] == "adaptive[x=1], fourier_map[x=1]"


def test_other_scenes_are_no_rows(tmp_path: Path) -> None:
    (note,) = build(context(tmp_path, [finished(tmp_path, "fog", "glow", 0.1)], tmp_path))
    assert isinstance(note, Note)
    assert "smoke_yard, hair" in note.text
