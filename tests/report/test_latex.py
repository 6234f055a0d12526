"""Tables as LaTeX."""

from __future__ import annotations

from pathlib import Path

import pytest

from oitbench.report import Column, Note, latex, write_table
from oitbench.report.artifacts import Choices, Chosen, HeatTable, Shade, SubjectRow

COLUMNS = (
    Column("method", "Method", kind="method"),
    Column("ms", "Time", "ms"),
    Column("empty", "Empty"),
    Column("why", "Why & how", kind="prose"),
)


def test_a_table_has_the_rules_and_the_numbers_of_the_page(tmp_path: Path) -> None:
    rows = [("a_b[x=1]", 12.3456, None, "50 % of #1"), ("=c", None, None, "")]
    table = write_table(tmp_path / "t.csv", COLUMNS, rows, title="T_1", caption="")
    latex.write_all([table, Note("no table")])
    assert (tmp_path / "t.tex").read_text(encoding="utf-8") == (
        "% Needs \\usepackage{booktabs}. T\\_1\n"
        "\\begin{tabular}{lrp{60mm}}\n"
        "\\toprule\n"
        "Method & Time ms & Why \\& how \\\\\n"
        "\\midrule\n"
        "{a\\_b[x=1]} & 12.3 & {50 \\% of \\#1} \\\\\n"
        "{=c} & -- & -- \\\\\n"
        "\\bottomrule\n"
        "\\end{tabular}\n"
    )


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (r"\input{x}", r"\textbackslash{}input\{x\}"),
        ("a~b^c", r"a\textasciitilde{}b\textasciicircum{}c"),
        ("$1 & 2%", r"\$1 \& 2\%"),
        ("a\nb\\\\", r"a b\textbackslash{}\textbackslash{}"),
        ("≥ 3 †", r"$\geq$ 3 \dag{}"),
    ],
)
def test_signs_lose_their_meaning(text: str, expected: str) -> None:
    assert latex.escaped(text) == expected


def test_a_heat_table_marks_the_best(tmp_path: Path) -> None:
    rows = (("glass_bars", "exact", (Shade("0.1", best=True), Shade("–"))),)
    table = HeatTable("Errors", "", tmp_path / "h.csv", ("a_1", "b"), rows)
    text = latex.text(table)
    assert "glass\\_bars & \\textbf{0.1} & -- & exact \\\\" in text
    assert "\\begin{tabular}{lrrl}" in text


def test_choices_are_a_table(tmp_path: Path) -> None:
    rows = (SubjectRow("smoke", "2 scenes", ("a", "b"), (Chosen("m_1", "FLIP 0.1"), None)),)
    table = Choices("Which", "", tmp_path / "c.csv", (("Best", ""), ("Fastest", "")), rows)
    assert "smoke & m\\_1, FLIP 0.1 & -- \\\\" in latex.text(table)


def test_two_tables_of_one_csv_file_have_files_of_their_own(tmp_path: Path) -> None:
    one = write_table(tmp_path / "t.csv", COLUMNS, [], title="", caption="")
    assert one.tex == tmp_path / "t.tex"
