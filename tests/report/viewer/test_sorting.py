"""Tables of the page in a browser: a click on a heading sorts the rows."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from oitbench.plugins import Collection
from oitbench.report import write
from tests.report.viewer.conftest import METHODS

TABLES = {"table": Collection.load().places.reports["table"]}
SCRIPT = """
const table = document.querySelector("table.sortable");
const place = Array.from(table.tHead.rows[0].cells)
  .findIndex((cell) => cell.textContent.startsWith(arguments[0]));
if (arguments[1]) for (const row of table.tBodies[0].rows) {
  delete row.cells[place].dataset.sort;
  row.cells[place].textContent = arguments[1].pop() ?? "7";
}
table.tHead.rows[0].cells[place].click();
return Array.from(table.tBodies[0].rows, (row) => row.cells[place].textContent.trim());
"""


@pytest.fixture
def table(driver: Any, results: Path, tmp_path: Path) -> Any:
    driver.get(write(results, tmp_path / "page", TABLES).path.as_uri())
    return driver


def test_texts_are_sorted_in_both_directions(table: Any) -> None:
    rising = table.execute_script(SCRIPT, "Method")
    assert rising == sorted(rising)
    assert set(METHODS) <= set(rising)
    assert table.execute_script(SCRIPT, "Method") == rising[::-1]


def test_numbers_with_commas_are_sorted_by_value(table: Any) -> None:
    sorted_texts = table.execute_script(SCRIPT, "Frame", ["10,000", "9,000", "200"])
    assert sorted_texts[0] == "7"
    assert sorted_texts[-3:] == ["200", "9,000", "10,000"]
