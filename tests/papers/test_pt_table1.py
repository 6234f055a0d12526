"""Times of stages: sums of a frame's parts, and what they say about the paper."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path

import msgspec
import pytest

from oitbench.report import Note, Table
from oitbench.results.schema import Record
from oitbench.results.times import PassTime
from tests.helpers import collection
from tests.made_up import interval_of, timed
from tests.papers.made_up import context, made

REPORT = collection().reports["pt_table1"]
FOG = "Foggy Night"


def parts(ms: Mapping[str, float]) -> list[PassTime]:
    return [PassTime(name, interval_of([value] * 9)) for name, value in ms.items()]


def taking(folder: Path, key: tuple[str, str], gather: float, resolve: float) -> Record:
    """Return the record of one row, with these milliseconds in its largest passes."""
    time = msgspec.structs.replace(
        timed(1.0),
        passes=parts(
            {"start of the frame": 1, "gather": gather, "upsample bends=1": 2, "resolve": resolve}
        ),
        shading=parts({"shadow maps": 3, "variance maps": 4, "opaque picture": 5}),
    )
    return made(folder, REPORT.PICTURES[key].need, time=time)


def test_stages_are_sums_of_passes(tmp_path: Path) -> None:
    record = taking(tmp_path, ("Door", REPORT.METHOD), 7, 8)
    (table,) = REPORT.build(context(tmp_path, [record]))
    assert isinstance(table, Table)
    with table.csv.open() as file:
        (row,) = csv.DictReader(file)
    keys = ("maps_ms", "filters_ms", "accumulation_ms", "resolve_ms")
    assert [float(row[key]) for key in keys] == [3, 4, 8, 10]
    assert (row["paper_scene"], row["scene"], row["blocks"]) == ("Door", "frosted_door", "")
    assert float(row["paper_resolve"]) == 2.37


@pytest.mark.parametrize(("gather", "word"), [(99, "Reproduced"), (98, "Not reproduced")])
def test_the_gain_of_blocks_is_measured(tmp_path: Path, gather: float, word: str) -> None:
    records = [
        taking(tmp_path, (FOG, REPORT.METHOD), gather, 0),
        taking(tmp_path, (FOG, REPORT.BLOCKS), 9, 0),
    ]
    (table,) = REPORT.build(context(tmp_path, records))
    text = f"blocks speed OIT up by 10 times and more in {FOG} ({(gather + 1) / 10:.1f})"
    assert f" {word}: {text}" in table.caption


@pytest.mark.parametrize(("resolve", "word"), [(9, "Reproduced"), (5, "Not reproduced")])
def test_stages_are_compared_in_each_scene(tmp_path: Path, resolve: float, word: str) -> None:
    record = taking(tmp_path, ("Door", REPORT.METHOD), 7, resolve)
    (table,) = REPORT.build(context(tmp_path, [record]))
    assert f" {word}: Resolve takes longer than OIT in Door." in table.caption


def test_without_times_there_is_no_table(tmp_path: Path) -> None:
    record = made(tmp_path, REPORT.PICTURES["Door", REPORT.METHOD].need, time=None)
    (note,) = REPORT.build(context(tmp_path, [record]))
    assert isinstance(note, Note)
