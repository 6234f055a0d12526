"""Numbers as text, and tables as files."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from oitbench.errors import UsageError
from oitbench.report import Column, write_table
from oitbench.report.artifacts import writing_to


def test_text_distinguishes_zero_from_small_values() -> None:
    column = Column("e", "E", decimals=4)
    texts = [column.text(value) for value in (0.0, 1e-9, -1e-9, 0.25, None)]
    assert texts == ["0", "<0.0001", ">−0.0001", "0.2500", "–"]


def test_text_has_significant_digits() -> None:
    assert Column("n", "N").text(12345) == "12,345"
    assert Column("t", "T").text(0.012345) == "0.0123"
    assert Column("t", "T").text(1.2345e-7) == "1.23e-07"


def test_tables_hide_empty_columns_and_keep_them_in_the_file(tmp_path: Path) -> None:
    columns = (Column("e", "E"), Column("x", "X"))
    table = write_table(tmp_path / "new" / "t.csv", columns, [(0.1, None)], title="", caption="")
    assert table.visible == [0]
    assert pd.read_csv(table.csv).columns.tolist() == ["e", "x"]


def test_a_status_that_says_nothing_is_hidden(tmp_path: Path) -> None:
    columns = (Column("status", "Status", kind="status"),)
    for statuses, visible in ((["ok", "ok"], []), (["ok", "failed"], [0])):
        rows = [(status,) for status in statuses]
        table = write_table(tmp_path / "t.csv", columns, rows, title="", caption="")
        assert table.visible == visible
        assert pd.read_csv(table.csv)["status"].tolist() == statuses


def test_a_folder_that_cannot_be_written_to_is_named(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.touch()
    message = r"file cannot be written to .*; give -o DIR"
    with pytest.raises(UsageError, match=message), writing_to(file):
        pass
