"""The section of claims: its tables and files, and texts that would be markup or formulas."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import pytest

from oitbench.report.artifacts import Note, Table, write_csv
from oitbench.report.context import ReportContext
from oitbench.report.templates import environment
from tests.helpers import collection
from tests.report.made_up import context, finished

DATA = """
[[source]]
cite = "<b>Me</b> 2026"
machine = "an abacus"

[[source.claim]]
id = "calm-first"
section = "=1+1"
said = "<script>alert(1)</script>"
figure = "pareto"
trials = [
    { kind = "ratio", quantity = "flip", of = ["calm"], to = ["wild"], bounds = { below = 1 } },
]

[[source.claim]]
id = "splats"
section = "2"
said = "@Splats."
trials = [{ kind = "untestable", reason = "-none" }]
"""


@pytest.fixture
def claims(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The report, with claims of its own."""
    report = collection().reports["claims"]
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "mine.toml").write_text(DATA)
    monkeypatch.setattr(report, "DATA", tmp_path / "data")
    return report


def rows(path: Path) -> dict[str, dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return {row["claim"]: row for row in csv.DictReader(file)}


@pytest.mark.parametrize(("error", "verdict"), [(0.1, "reproduced"), (0.6, "refuted")])
def test_a_verdict_changes_with_the_evidence(
    claims: ModuleType, tmp_path: Path, error: float, verdict: str
) -> None:
    cells = [finished(tmp_path, "fog", "calm", error), finished(tmp_path, "fog", "wild", 0.3)]
    summary, table, repeat, cases = claims.build(context(tmp_path, cells, tmp_path))
    assert isinstance(summary, Note)
    assert summary.text == f"Of 2 claims: 1 {verdict}, 1 not testable here."
    assert isinstance(table, Table)
    assert "an abacus" in table.caption
    found = rows(tmp_path / "claims.csv")
    assert found["calm-first"]["verdict"] == verdict
    assert found["calm-first"]["figure"] == "pareto"
    assert found["calm-first"]["machine"] == "an abacus"
    assert (
        "ratio of FLIP against exact compositing of calm to wild below 1"
        in (found["calm-first"]["test"])
    )
    command = f"--method calm --method wild --size 16x16 --truth exact --out {tmp_path}"
    assert command in found["calm-first"]["command"]
    assert [repeat.collapsed, cases.collapsed] == [True, True]
    (case,) = rows(tmp_path / "claims-cases.csv").values()
    assert case["holds"] == ("yes" if verdict == "reproduced" else "no")


def test_hostile_texts_are_no_markup_and_no_formulas(claims: ModuleType, tmp_path: Path) -> None:
    scene = "=<img src=x>"
    cells = [
        finished(tmp_path, scene, name, error) for name, error in (("calm", 0.1), ("wild", 0.3))
    ]
    known = context(tmp_path, cells, tmp_path)
    page = rendered(claims, known)
    for tag in ("<script>", "<b>Me", "<img"):
        assert tag not in page
    assert "&lt;script&gt;" in page
    assert "&lt;img" in page
    found = rows(tmp_path / "claims.csv")
    assert found["calm-first"]["section"] == "'=1+1"
    assert found["calm-first"]["numbers"].startswith("'=<img")
    assert found["splats"]["said"] == "'@Splats."
    assert found["splats"]["reason"] == "'-none"


def test_a_claim_links_to_its_figure_if_the_page_has_it(claims: ModuleType, tmp_path: Path) -> None:
    known = context(tmp_path, [finished(tmp_path, "hall", "calm", 0.1)], tmp_path)
    link = '<a href="#pareto">pareto</a>'
    page = rendered(claims, known)
    assert link not in page
    assert ">pareto</td>" in page
    assert link in rendered(claims, replace(known, sections=frozenset({"pareto"})))


def rendered(claims: ModuleType, known: ReportContext) -> str:
    """Return the section of claims."""
    section = environment(known).get_template("section.html")
    return section.render(artifacts=claims.build(known), heading="")


def test_headings_of_csv_files_are_no_formulas(tmp_path: Path) -> None:
    write_csv(tmp_path / "a.csv", ["=1+1", "b"], [["+1", -1]])
    assert (tmp_path / "a.csv").read_text() == "'=1+1,b\n'+1,-1\n"


def test_the_claims_of_the_suite_have_a_verdict_each(tmp_path: Path) -> None:
    report = collection().reports["claims"]
    cells = [finished(tmp_path, "foliage", "phenomenological", 0.1)]
    *_, cases = report.build(context(tmp_path, cells, tmp_path))
    assert isinstance(cases, Table)
    found = rows(tmp_path / "claims.csv")
    assert len(found) > 80
    assert all(row["verdict"] for row in found.values())


def test_the_same_results_give_the_same_bytes(claims: ModuleType, tmp_path: Path) -> None:
    cells = [finished(tmp_path, "fog", "calm", 0.1), finished(tmp_path, "fog", "wild", 0.3)]
    texts = []
    for _ in range(2):
        claims.build(context(tmp_path, cells, tmp_path))
        texts.append(
            [(tmp_path / name).read_bytes() for name in ("claims.csv", "claims-cases.csv")]
        )
    assert texts[0] == texts[1]
