"""`oitbench visibility`: files, and pixels that are refused."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from tests.cli.helpers import Call


def test_data_and_a_figure_are_written(call: Call, tmp_path: Path) -> None:
    options = ("--pixel", "32,32", "--size", "64x64", "-o", tmp_path)
    methods = ("--method", "a_buffer", "--method", "k_buffer[k=2,4]")
    assert call("visibility", "layer_stack", *options, *methods).code == 0
    facts = json.loads((tmp_path / "visibility.json").read_text(encoding="utf-8"))
    assert set(facts["visibility"]) == {"exact", "a_buffer", "k_buffer[k=2]", "k_buffer[k=4]"}
    z = facts["fragments"]["z"]
    assert z == sorted(z)
    assert len(facts["visibility"]["exact"]) == len(z) + 1
    with (tmp_path / "visibility.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 4 * (len(z) + 1)
    errors = [float(row["error_g"]) for row in rows if row["method"] == "a_buffer"]
    assert max(map(abs, errors)) < 1e-5
    assert (tmp_path / "visibility.png").stat().st_size > 10_000
    assert (tmp_path / "visibility.pdf").stat().st_size > 1_000


@pytest.mark.parametrize(
    ("pixel", "message"),
    [
        ("64,0", "pixel 64,0 lies outside a frame of 64x64"),
        ("middle", "cannot read pixel 'middle'"),
        ("0,0", "nothing transparent is at pixel 0,0"),
    ],
)
def test_pixels_that_cannot_be_measured_are_refused(
    call: Call, tmp_path: Path, pixel: str, message: str
) -> None:
    options = ("--pixel", pixel, "--size", "64x64", "-o", tmp_path)
    answer = call("visibility", "smoke_ball[detail=0.1]", *options)
    assert answer.code == 2
    assert message in answer.err
