"""Baseline files: their content and its layout."""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest

import oitbench
from oitbench.errors import StorageError, UsageError
from oitbench.image import metrics
from oitbench.results import baseline
from oitbench.results.schema import Record
from oitbench.results.store import CELLS, read_cells
from tests.damage import flip_bit, largest_file
from tests.made_up import VALUES, changed, failed, record, write
from tests.results.helpers import BETA, exact, slower, write_changed


def test_a_baseline_file_equals_its_folder_except_for_times(before: Path, tmp_path: Path) -> None:
    file = tmp_path / "baseline.json"
    baseline.save(before, file)
    assert baseline.read(file).rows == baseline.read(before).rows
    assert oitbench.compare(before, file).differences == ()
    assert oitbench.compare(write_changed(before, slower), file).differences == ()


def test_a_baseline_file_is_sorted_and_rounded_and_names_no_machine(
    before: Path, tmp_path: Path
) -> None:
    first, second = tmp_path / "a.json", tmp_path / "b.json"
    baseline.save(before, first)
    noisy = read_cells(write_changed(before, exact(metrics.RMSE, 0.05 + 1e-9)) / CELLS)
    baseline.save(write(tmp_path / "reversed", list(noisy.values())[::-1]), second)
    assert first.read_bytes() == second.read_bytes()
    text = first.read_text()
    content = json.loads(text)
    assert text == json.dumps(content, indent=1, sort_keys=True, ensure_ascii=False) + "\n"
    assert content["renderer"] == "softly"
    assert content["cells"][BETA]["passes"] == "peel × 8, resolve"
    for word in ("/home", ".exr", "method_ms", "samples", str(tmp_path)):
        assert word not in text


@pytest.mark.parametrize(
    ("records", "message"),
    [
        ([], "has no cell with numbers"),
        ([failed("mean")], "has no cell with numbers"),
        ([record("mean"), failed("peel")], "the cell .* peel .* is failed and has no numbers"),
        (
            [
                record("mean"),
                changed(
                    record("peel", status="unstable"),
                    "outcome.scores.exact.metrics",
                    dict.fromkeys(VALUES),
                ),
            ],
            "the cell .* peel .* is unstable and has no numbers",
        ),
    ],
    ids=["no cell", "only failed", "one failed", "nulls"],
)
def test_cells_without_numbers_are_no_baseline(
    tmp_path: Path, records: list[Record], message: str
) -> None:
    folder = write(tmp_path / "run", records)
    with pytest.raises(UsageError, match=message):
        baseline.save(folder, tmp_path / "baseline.json")
    assert not (tmp_path / "baseline.json").exists()


def test_a_run_without_numbers_is_nothing_to_compare_with(tmp_path: Path) -> None:
    broken = write(tmp_path / "run", [failed("mean")])
    with pytest.raises(UsageError, match="has no cell with numbers"):
        oitbench.compare(broken, broken)


def test_skipped_cells_may_be_in_a_baseline(tmp_path: Path) -> None:
    cells = [record("mean"), failed("peel", status="skipped")]
    rows = baseline.save(write(tmp_path / "run", cells), tmp_path / "baseline.json").rows
    assert baseline.read(tmp_path / "baseline.json").rows == rows
    assert len(rows) == 2


def empty(content: str) -> str:
    return json.dumps({"cells": {}, "format": 4, "renderer": "softly"})


def without_metrics(content: str) -> str:
    parsed = json.loads(content)
    for fields in parsed["cells"].values():
        fields["exact.rmse_lin"] = None
    return json.dumps(parsed)


@pytest.mark.parametrize("change", [empty, without_metrics])
def test_a_baseline_that_was_edited_is_refused(
    before: Path, tmp_path: Path, change: Callable[[str], str]
) -> None:
    file = tmp_path / "baseline.json"
    baseline.save(before, file)
    file.write_text(change(file.read_text()))
    with pytest.raises(UsageError, match=r"baseline\.json"):
        oitbench.compare(before, file)


def test_no_flipped_bit_of_a_baseline_is_believed(before: Path, tmp_path: Path) -> None:
    file = tmp_path / "baseline.json"
    rows = baseline.save(before, file).rows
    whole = file.read_bytes()
    for number in range(0, 8 * len(whole), 97):
        flip_bit(file, number)
        with suppress(UsageError):
            assert baseline.read(file).rows == rows, number
        file.write_bytes(whole)


def test_a_full_disk_keeps_the_old_baseline(before: Path, tmp_path: Path) -> None:
    file = tmp_path / "new" / "baseline.json"
    baseline.save(before, file)
    whole = file.read_bytes()
    with (
        largest_file(100),
        pytest.raises(StorageError, match=r"File too large\); free some space"),
    ):
        baseline.save(before, file)
    assert file.read_bytes() == whole
    assert list(file.parent.iterdir()) == [file]
