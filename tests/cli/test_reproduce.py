"""`oitbench reproduce`, and figures of papers from results."""

from __future__ import annotations

from pathlib import Path

import pytest

from oitbench.papers import Picture, needs_of
from oitbench.results.records import Results
from tests.cli.helpers import Call
from tests.papers.made_up import made
from tests.report.made_up import finished, store

FIGURE = '''"""Two bars & more."""
from oitbench.papers import Album, Picture, Row, alike, caption, needs_of, plate
title = "Bars <two>"
PICTURES = [Picture("layer_stack", name, name) for name in ("alpha_blend", "weighted_sum")]
needs = needs_of(PICTURES)
def build(context):
    album = Album(context, needs)
    text = caption(album, "Bars.", [alike(album, *PICTURES, "both look the same")])
    return [plate(album, [Row(PICTURES)], "bars", title=title, caption=text)]
'''
PAPER = """cite = "A & B 2020, “<Bars>”"
[drawn]
"Figure 2" = "bars"
[omitted]
"Figure 1" = "a diagram <of> bars"
[variants]
alpha_blend = "alpha_blend[precision=float]"
"""


@pytest.fixture
def world(tmp_path: Path) -> Path:
    """A collection with a paper of one figure."""
    folder = tmp_path / "world"
    (folder / "reports" / "papers").mkdir(parents=True)
    (folder / "reports" / "bars.py").write_text(FIGURE)
    (folder / "reports" / "papers" / "bars2020.toml").write_text(PAPER)
    return folder


def test_a_paper_is_run_and_drawn_on_a_page_of_its_own(
    call: Call, world: Path, tmp_path: Path
) -> None:
    arguments = ("reproduce", "bars2020", "--collection", world, "-o", tmp_path / "out")
    answer = call(*arguments, "--size", "32x24", "--preset", "quick", "--quiet")
    assert answer.code == 0, answer
    page = tmp_path / "out" / "report" / "index.html"
    assert answer.out.splitlines()[-1] == str(page)
    records = Results.load(tmp_path / "out").records
    assert {record.method for record in records} == {
        "alpha_blend[precision=float]",
        "weighted_sum",
    }
    assert {record.size for record in records} == {(32, 24)}
    assert all(record.time for record in records)
    text = page.read_text(encoding="utf-8")
    assert "<h1>A &amp; B 2020, “&lt;Bars&gt;”</h1>" in text
    assert "<h2>Figure 2: Bars &lt;two&gt;</h2>" in text
    assert "<h3>Bars &lt;two&gt;</h3>" not in text  # once is enough
    assert "Figure 1: a diagram &lt;of&gt; bars." in text
    assert text.count("<section id=") == 3  # the figure, what is not drawn, and the environment
    assert "eproduced: both look the same (FLIP 0." in text
    assert (page.parent / "bars.png").is_file()
    assert call(*arguments, "--size", "32x24", "--preset", "quick", "--quiet").out.startswith(
        f"{tmp_path / 'out'}: nothing to do; 2 kept"
    )


def test_a_dry_run_lists_the_cells(call: Call, world: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    answer = call(
        "reproduce", "bars2020", "--collection", world, "-o", out, "--size", "8x8", "--dry-run"
    )
    assert "layer_stack alpha_blend[precision=float], 8x8" in answer.out
    assert "cells: 2, 0 done, 2 to do" in answer.out
    assert not out.exists()


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        (["at2012"], "unknown paper 'at2012'; did you mean at2011 or pt2017?"),
        (["at2011", "--figure", "bars"], "unknown figure 'bars'"),
        (["at2011", "--size", "big"], "cannot read size 'big'"),
    ],
)
@pytest.mark.usefixtures("empty_folder")
def test_wrong_arguments_are_refused(call: Call, arguments: list[str], part: str) -> None:
    call("reproduce", *arguments).assert_refused(part)


def test_figures_of_papers_are_not_on_the_page_of_all_results(
    call: Call, world: Path, tmp_path: Path
) -> None:
    folder = store(tmp_path / "r", finished(tmp_path / "r", "layer_stack", "glow", 0.1))
    answer = call("report", folder, "--collection", world)
    assert answer.code == 0, answer
    page = (folder / "report" / "index.html").read_text(encoding="utf-8")
    assert 'id="table"' in page
    assert 'id="bars"' not in page
    assert 'id="at_figure06"' not in page
    assert call("report", folder, "--collection", world, "--section", "bars").code == 0


def test_a_figure_is_drawn_alone(call: Call, world: Path, tmp_path: Path) -> None:
    needs = needs_of(Picture("layer_stack", name) for name in ("alpha_blend", "weighted_sum"))
    folder = store(tmp_path / "r", *(made(tmp_path / "r", need) for need in needs))
    answer = call("report", folder, "--collection", world, "--figure", "bars", "-o", tmp_path / "f")
    files = [tmp_path / "f" / "bars.png", tmp_path / "f" / "bars.pdf"]
    assert answer.out.splitlines() == list(map(str, files))
    assert sorted(tmp_path.glob("f/*")) == sorted(files)


def test_a_figure_whose_cells_are_missing_is_refused(
    call: Call, world: Path, tmp_path: Path
) -> None:
    (need,) = needs_of([Picture("layer_stack", "alpha_blend")])
    folder = store(tmp_path / "r", made(tmp_path / "r", need))
    arguments = ("report", folder, "--collection", world)
    call(*arguments, "--figure", "bars").assert_refused(
        f"bars needs 1 cell that {folder} lacks: layer_stack weighted_sum; make it with: oitbench"
        f" reproduce bars2020 --figure bars --out {folder} --size 16x16"
    )
    call(*arguments, "--figure", "claims").assert_refused("claims draws no figure")
    call(*arguments, "--figure", "bar").assert_refused("unknown report 'bar'; did you mean bars?")
    assert not (folder / "report" / "index.html").exists()
