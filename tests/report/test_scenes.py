"""The contact sheet of scenes."""

from __future__ import annotations

import csv
from pathlib import Path

import msgspec
import numpy as np
import pytest

from oitbench.image import files, stored
from oitbench.measure.scene_statistics import describe
from oitbench.report import Figure, Note, Table
from oitbench.results.schema import COMPLEXITY, Record
from oitbench.results.statistics import SceneStatistics
from tests.helpers import collection
from tests.report.made_up import SIDE, context, finished, unfinished

build = collection().reports["scenes"].build


def with_counts(folder: Path, scene: str, deepest: int, method: str = "glow") -> Record:
    """Return a record whose map of depth complexity rises from 0 to `deepest`."""
    counts = np.linspace(0, deepest, SIDE * SIDE).reshape(SIDE, SIDE).astype(np.int64)
    made = finished(folder, scene, method, 0.1)
    assert made.outcome is not None
    image = stored.store(folder, f"images/{COMPLEXITY}", files.count_channels(counts))
    statistics = SceneStatistics(
        5, 3, 4_321, 1_234, 5, int(counts.sum()), int((counts > 0).sum()), describe(counts)
    )
    outcome = msgspec.structs.replace(
        made.outcome, statistics=statistics, images={**made.outcome.images, COMPLEXITY: image}
    )
    return msgspec.structs.replace(made, outcome=outcome)


def test_each_scene_is_one_row_of_a_sheet_and_of_the_table(tmp_path: Path) -> None:
    records = [
        with_counts(tmp_path, "fog", 3),
        with_counts(tmp_path, "fog", 3, "murk"),
        with_counts(tmp_path, "hair", 700),
        with_counts(tmp_path, "nothing", 0),
    ]
    sheet, table = build(context(tmp_path, records, tmp_path))
    assert isinstance(sheet, Figure)
    assert sheet.png.is_file()
    assert sheet.pdf.is_file()
    assert isinstance(table, Table)
    with table.csv.open() as file:
        rows = list(csv.DictReader(file))
    assert [row["scene"] for row in rows] == ["fog", "hair", "nothing"]
    assert rows[1]["max_depth_complexity"] == "700"
    assert rows[1]["triangles"] == "4321"
    assert float(rows[2]["covered_percent"]) == 0
    assert rows[2]["mean_depth_complexity"] == ""


def test_each_view_is_a_row(tmp_path: Path) -> None:
    record = with_counts(tmp_path, "engine", 3)
    records = [record, msgspec.structs.replace(record, view="rear")]
    _, table = build(context(tmp_path, records, tmp_path))
    assert isinstance(table, Table)
    assert [row[:2] for row in table.rows] == [("engine", "main"), ("engine", "rear")]


def test_many_scenes_fill_several_sheets(tmp_path: Path) -> None:
    records = [with_counts(tmp_path, f"scene {number}", 2) for number in range(7)]
    drawn = build(context(tmp_path, records, tmp_path))
    sheets = [item for item in drawn if isinstance(item, Figure)]
    assert [item.title for item in sheets] == ["Contact sheet (1 of 2)", "Contact sheet (2 of 2)"]


def test_maps_that_are_lost_leave_the_numbers(tmp_path: Path) -> None:
    record = with_counts(tmp_path, "fog", 3)
    for path in (tmp_path / "images").glob(f"{COMPLEXITY}*"):
        path.unlink()
    sheet, table = build(context(tmp_path, [record], tmp_path))
    assert isinstance(sheet, Figure)
    assert isinstance(table, Table)
    assert len(table.rows) == 1


def test_the_colors_of_a_map_follow_its_counts(tmp_path: Path) -> None:
    from matplotlib.figure import Figure as Canvas

    report = collection().reports["scenes"]
    axes = Canvas().subplots()
    report._draw_map(axes, np.array([[0, 1, 100]], np.uint32))
    picture = axes.images[0].get_array()
    assert picture is not None
    gray, low, high = np.asarray(picture)[0, :, :3]
    assert gray == pytest.approx([0xE9 / 255] * 3)
    # Viridis rises from dark violet to yellow.
    assert low.sum() < high.sum()
    assert high[2] < 0.2 < low[2]


def test_without_finished_cells_there_is_a_note(tmp_path: Path) -> None:
    (note,) = build(context(tmp_path, [unfinished("fog", "glow")], tmp_path))
    assert isinstance(note, Note)
