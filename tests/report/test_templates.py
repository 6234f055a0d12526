"""Filters of the page's templates."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from oitbench.report import Column
from oitbench.report.templates import environment
from tests.report.made_up import context


def test_code_is_marked_and_all_else_escaped(tmp_path: Path) -> None:
    code = environment(context(tmp_path, [], tmp_path)).filters["code"]
    assert code("run `a <b>` & <i>") == "run <code>a &lt;b&gt;</code> &amp; &lt;i&gt;"
    # An odd backtick marks nothing.
    assert code("5` <b>") == "5` &lt;b&gt;"


@pytest.mark.parametrize(
    ("value", "key", "text"),
    [
        (1234567, None, "1,234,567"),
        (0.123456789012, "0.123456789", "0.123"),
        ("a, b", "a, b", "a, b"),
        (None, "", "–"),
    ],
)
def test_a_number_has_a_key_for_sorting_unless_its_text_is_one(
    tmp_path: Path, value: float | str | None, key: str | None, text: str
) -> None:
    """A report may write words into a column of numbers."""
    template = environment(context(tmp_path, [], tmp_path)).get_template("tables.html")
    cell = template.make_module().cell(Column("x", "X"), value)  # type: ignore[attr-defined]
    attribute = "" if key is None else f' data-sort="{key}"'
    assert cell.strip() == f'<td class="number"{attribute}>{text}</td>'


@pytest.mark.parametrize("count", range(2, 60))
def test_no_tile_is_alone_in_the_last_row(tmp_path: Path, count: int) -> None:
    across = environment(context(tmp_path, [], tmp_path)).filters["across"](count)
    wide, middle, narrow, lead = map(int, re.findall(r":(\d+)", across))
    assert count <= wide or count % wide != 1
    assert count <= middle or count % middle != 1
    # Two and three columns cannot avoid it for 7, 13, … tiles, so that the first one fills a row.
    filled = count - 1 if lead == narrow else count
    assert count <= narrow or filled % narrow != 1
    assert (lead > 1) == (count > narrow and count % 6 == 1)
