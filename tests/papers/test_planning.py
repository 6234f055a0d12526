"""The matrix of a paper has exactly the cells that its figures need; nothing is rendered."""

from __future__ import annotations

from pathlib import Path

import pytest

from oitbench.catalog.catalog import Catalog
from oitbench.catalog.needs import Need, merged
from oitbench.errors import DeclarationError, UsageError
from oitbench.papers.listing import Paper, read_papers
from oitbench.papers.planning import check_results, needs_of_reports, plan_figures
from oitbench.places import own_folder
from oitbench.results.records import Results
from oitbench.truths import EXACT, MATCHED
from tests.helpers import collection
from tests.papers.made_up import made
from tests.report.made_up import FACTS

PAPERS = read_papers([own_folder()])
FIGURE = """
from oitbench.papers import Picture, needs_of
title = "Bars"
needs = needs_of([{pictures}])
def build(context):
    return []
"""


def figure(folder: Path, pictures: str) -> Paper:
    """Write a collection with one figure, and return its paper."""
    (folder / "reports").mkdir()
    (folder / "reports" / "bars.py").write_text(FIGURE.format(pictures=pictures))
    return Paper("cite", {"Figure 1": "bars"}, variants={"k_buffer": "k_buffer[k=4]"})


@pytest.mark.parametrize("name", PAPERS)
def test_a_paper_plans_exactly_the_needed_cells(name: str, tmp_path: Path) -> None:
    paper = PAPERS[name]
    matrix = plan_figures(paper, size=(64, 48), out=tmp_path / "out")
    modules = [collection().reports[report] for report in paper.drawn.values()]
    needs = [need for module in modules for need in getattr(module, "needs", ())]
    wanted = {
        (need.scene, paper.variants.get(need.method, need.method), need.view, need.effects,
         need.shading)
        for need in needs
    }  # fmt: skip
    planned = [(c.scene, c.method, c.view, c.effects, c.shading) for c in matrix.cells]
    assert len(planned) == len(set(planned))
    assert set(planned) == wanted
    assert {cell.size for cell in matrix.cells} == {(64, 48)}
    assert matrix.unusable == {}
    assert not (tmp_path / "out").exists()


def test_cells_have_the_truths_that_any_figure_shows(tmp_path: Path) -> None:
    bars = "Picture('glass_bars', 'k_buffer'"
    paper = figure(tmp_path, f"{bars}), {bars}, truth='matched'), {bars}, view='plan')")
    first, second = plan_figures(paper, collections=[tmp_path]).cells
    assert (first.method, first.view, first.truths) == ("k_buffer[k=4]", "main", (EXACT, MATCHED))
    assert (second.view, second.truths) == ("plan", (EXACT,))
    # The stored pictures of 256² stand for this size, whose sub-pixels are theirs.
    assert (first.size, first.reduced, second.reduced) == ((512, 512), True, False)


def test_only_chosen_figures_are_planned(tmp_path: Path) -> None:
    cells = plan_figures(PAPERS["at2011"], ["at_figure02"], out=tmp_path / "out").cells
    assert {cell.scene for cell in cells} == {"hair"}
    with pytest.raises(UsageError, match="unknown figure 'at_figure2'; did you mean"):
        plan_figures(PAPERS["at2011"], ["at_figure2"])


@pytest.mark.parametrize(
    ("pictures", "part"),
    [
        ("Picture('glass_bars', 'adaptive[nodes=8]')", "write it as adaptive$"),
        ("Picture('glass_bars', 'k_buffer', colour='red')", "colour"),
    ],
)
def test_a_faulty_figure_is_named(tmp_path: Path, pictures: str, part: str) -> None:
    paper = figure(tmp_path, pictures)
    with pytest.raises(DeclarationError, match=part):
        plan_figures(paper, collections=[tmp_path])


def test_scenes_stay_together() -> None:
    needs = [Need("b", "m", "main", "requested", truths=("matched",)), Need("a", "m", "main", ""),
             Need("b", "m", "main", "requested", truths=("full", "matched"))]  # fmt: skip
    assert merged(needs) == [
        Need("b", "m", "main", "requested", truths=("matched", "full")),
        Need("a", "m", "main", ""),
    ]


def test_lacking_cells_are_named_with_the_command(tmp_path: Path) -> None:
    with Catalog() as catalog:
        needs = needs_of_reports(catalog, ["pt_figure07"], {})
        records = [made(tmp_path, need) for need in needs]
        complete = Results(tmp_path, tuple(records), FACTS)
        check_results(catalog, complete, "pt_figure07", "pt2017", Path("my results"))
        lacking = Results(tmp_path, tuple(records[:1]), FACTS)
        with pytest.raises(UsageError) as caught:
            check_results(catalog, lacking, "pt_figure07", "pt2017", Path("my results"))
    assert str(caught.value) == (
        "pt_figure07 needs 2 cells that my results lacks: glass_bars phenomenological, glass_bars"
        " sorted_two_pass; make them with: oitbench reproduce pt2017 --figure pt_figure07 --out"
        " 'my results' --size 16x16"
    )
