"""The list of figures of each paper: complete, and each with a report or a reason."""

from __future__ import annotations

from pathlib import Path

import pytest

from oitbench.errors import DeclarationError, UsageError
from oitbench.papers.listing import FOLDER, Paper, StandIn, figures_of, read_paper, read_papers
from oitbench.places import own_folder
from tests.helpers import collection

PAPERS = read_papers([own_folder()])


def numbers(figures: int, tables: int) -> set[str]:
    """Return the numbers of all figures and tables of a paper."""
    found = [f"Figure {number}" for number in range(1, figures + 1)]
    return {*found, *(f"Table {number}" for number in range(1, tables + 1))}


@pytest.mark.parametrize(
    ("name", "all_of"),
    [("at2011", numbers(10, 1)), ("pt2017", numbers(25, 2)), ("i3d2016", numbers(14, 2))],
)
def test_each_figure_is_drawn_or_has_a_reason(name: str, all_of: set[str]) -> None:
    paper = PAPERS[name]
    assert {*paper.drawn, *paper.omitted} == all_of
    assert not paper.drawn.keys() & paper.omitted.keys()
    assert all(paper.omitted.values())


@pytest.mark.parametrize("name", PAPERS)
def test_each_report_exists_and_has_one_number(name: str) -> None:
    drawn = PAPERS[name].drawn
    assert set(drawn.values()) <= set(collection().places.reports)
    assert len(set(drawn.values())) == len(drawn)


@pytest.mark.parametrize("name", PAPERS)
def test_variants_stand_for_methods_that_are_needed(name: str) -> None:
    paper = PAPERS[name]
    modules = [collection().reports[report] for report in paper.drawn.values()]
    needed = {need.method for module in modules for need in getattr(module, "needs", ())}
    assert paper.variants.keys() <= needed


def test_an_edition_has_the_numbers_of_its_paper() -> None:
    paper = PAPERS["at2011"]
    assert list(paper.edition.numbers.items())[:2] == [
        ("at_figure01", "Figure 1"),
        ("at_figure02", "Figure 2"),
    ]
    assert paper.edition.heading.startswith("Salvi")
    assert "at_figure01" in figures_of(PAPERS.values())


def test_pictures_have_the_settings_of_their_scene() -> None:
    paper = PAPERS["at2011"]
    adaptive, base = paper.picture("SMOKE", "AT", "here"), paper.picture("HAIR", "A-buffer")
    assert (adaptive.method, adaptive.label) == ("adaptive[nodes=24]", "here")
    assert (base.scene, base.method) == ("hair", "a_buffer")
    scenes = {"FOG": StandIn("fog", {"AT": "adaptive[nodes=2]"})}
    other = Paper("", {}, methods={"AT": "adaptive"}, scenes=scenes)
    assert other.picture("FOG", "AT").method == "adaptive[nodes=2]"


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("cite = 1", "Expected `str`"),
        ("cite = ", "papers/new.toml"),
        ("cites = ''", "unknown field"),
    ],
)
def test_faulty_files_are_refused(tmp_path: Path, text: str, part: str) -> None:
    path = tmp_path / FOLDER / "new.toml"
    path.parent.mkdir(parents=True)
    path.write_text(text)
    with pytest.raises(DeclarationError, match=part):
        read_papers([tmp_path])
    with pytest.raises(UsageError, match="cannot be read: No such file"):
        read_paper(tmp_path / "none.toml")


def test_papers_have_different_names(tmp_path: Path) -> None:
    for folder in ("a", "b"):
        path = tmp_path / folder / FOLDER / "same.toml"
        path.parent.mkdir(parents=True)
        path.write_text("cite = ''\n[drawn]\n")
    with pytest.raises(DeclarationError, match=r"b/.*same\.toml: another collection also has"):
        read_papers([tmp_path / "a", tmp_path / "b"])
