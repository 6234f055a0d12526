"""Pages of methods, beside the page of the report and inside of it."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import msgspec
import pytest

from oitbench.catalog.messages import Portrait
from oitbench.catalog.outline import Access, Outline, PassOutline, Storage
from oitbench.method.demands import NOTHING
from oitbench.plugins import Collection
from oitbench.report import write
from oitbench.report.bibliography import NAME
from oitbench.results.schema import Record, Renderer
from oitbench.stability import files as stability
from oitbench.stability.result import BREAKS, HOLDS, CheckResult
from tests.report.made_up import finished, store

REPORTS = Collection.load().places.reports
CHOSEN = {name: REPORTS[name] for name in ("methods", "references", "capability", "images")}
BIBLIOGRAPHY = REPORTS["methods"].parent / NAME
HOSTILE = "<img src=x onerror=alert(1)>"
DOC = f"""Murk: {HOSTILE}

    C = sum_i alpha_i {HOSTILE}

Code `{HOSTILE}`.

Source: Porter & Duff 1984 [PorterDuff1984]; nobody [Nobody2000].

Known failures: a front layer is lost {HOSTILE}. More.
"""


def portrait(fingerprint: str = "m") -> Portrait:
    outline = Outline(
        [Storage("sum", "rgba16f", 64), Storage(HOSTILE, "r8", 8)],
        [PassOutline("gather", "all fragments", "", [Access("sum", True, True, "add")])],
    )
    parameters = {"n": ("8", "8, 16", HOSTILE)}
    promises = ["order_independent", "white_furnace"]
    return Portrait(
        "murk", DOC, "lists", parameters, promises, ["coverage"], NOTHING, outline, fingerprint
    )


def cells(folder: Path) -> list[Record]:
    return [
        finished(folder, "panes", "murk", 0.3),
        finished(folder, "lists", "murk", 0.1),
        finished(folder, "panes", "murk[n=16]", 0.2),
        finished(folder, "panes", HOSTILE, 0.2, name=HOSTILE),
    ]


def checks(folder: Path) -> None:
    """Write results of `oitbench stability`: a promise that holds, and a limit that breaks."""
    result = CheckResult("murk", "murk", "order_independent", "any order", True, True, HOLDS, 0.125)
    limit = msgspec.structs.replace(
        result, check="near plane", promised=False, status=BREAKS, sentence=HOSTILE
    )
    stability.write(folder, [result, limit], Renderer("softly"))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("results")
    store(path, *cells(path))
    checks(path)
    return path


@pytest.fixture(scope="module")
def page(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    portraits: dict[str, Portrait | str] = {"murk": portrait(), HOSTILE: "no such file"}
    out = tmp_path_factory.mktemp("page")
    made = write(folder, out, CHOSEN, portraits=portraits, bibliographies=[BIBLIOGRAPHY])
    assert not made.missing
    return made.path


class Tags(HTMLParser):
    """Collects all tags of a page with their attributes."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))


def tags(page: Path) -> list[tuple[str, dict[str, str | None]]]:
    parser = Tags()
    parser.feed(page.read_text(encoding="utf-8"))
    return parser.found


def words(page: Path) -> str:
    """Return the text of a page without tags, blanks joined."""
    return " ".join(re.sub(r"<[^>]*>", "", page.read_text(encoding="utf-8")).split())


def pages(page: Path) -> list[Path]:
    return sorted((page.parent / "methods").glob("*.html"))


def test_each_method_has_a_page_and_no_variant_has_one(page: Path) -> None:
    assert [path.name for path in pages(page)] == [
        "%3Cimg%20src=x%20onerror=alert%281%29%3E.html", "murk.html"
    ]  # fmt: skip


def test_names_of_methods_and_variants_link_to_their_page(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert '<a class="page" href="methods/murk.html">murk</a>' in text
    assert '<a class="page" href="methods/murk.html">murk[n=16]</a>' in text


def test_every_link_of_every_page_has_a_target(page: Path) -> None:
    for path in [page, *pages(page)]:
        found = tags(path)
        ids = {attributes.get("id") for _, attributes in found}
        links = [attributes["href"] or "" for _, attributes in found if "href" in attributes]
        assert len(links) > 5
        for link in links:
            parts = urlsplit(link)
            if parts.path:
                assert (path.parent / unquote(parts.path)).is_file(), link
            elif not parts.fragment.startswith("view="):
                assert parts.fragment in ids, link


def test_nothing_from_plugins_is_markup(page: Path) -> None:
    for path in [page, *pages(page)]:
        text = path.read_text(encoding="utf-8")
        assert HOSTILE not in text
        assert not any("onerror" in attributes for _, attributes in tags(path))
    assert "&lt;img src=x onerror=alert(1)&gt;" in pages(page)[1].read_text(encoding="utf-8")


def test_a_page_needs_no_network(page: Path) -> None:
    for path in pages(page):
        text = path.read_text(encoding="utf-8")
        for word in ("http:", "https:", "@import", "url("):
            assert word not in text


def test_a_page_shows_docstring_declaration_and_checks(page: Path) -> None:
    text = words(pages(page)[1])
    assert "C = ∑i αi" in text
    assert "A front layer is lost" in text
    assert "all fragments" in text
    assert "64 bit/px" in text
    assert "order_independent random orders of the draws give one picture holds 0.125" in text
    assert "white_furnace white layers before a white background are invisible not checked" in text
    assert "near plane" in text
    assert "Porter and Duff 1984, “Compositing Digital Images”" in text
    assert "@inproceedings{PorterDuff1984," in text
    assert "[Nobody2000]" in text


def test_a_page_shows_the_best_and_the_worst_scene(page: Path) -> None:
    text = words(pages(page)[1])
    assert re.search(r"Best scene: lists .*Worst scene: panes ", text)
    images = [a for tag, a in tags(pages(page)[1]) if tag == "img"]
    assert len(images) == 6
    assert all((image["src"] or "").startswith("data:image/") for image in images)


def test_all_cells_of_all_variants_are_in_the_table(page: Path) -> None:
    lines = (
        (page.parent / "methods" / "tables" / "murk" / "cells.csv")
        .read_text(encoding="utf-8")
        .splitlines()
    )
    assert [line.split(",")[:2] for line in lines[1:]] == [
        ["murk", "panes"], ["murk[n=16]", "panes"], ["murk", "lists"]
    ]  # fmt: skip
    assert (page.parent / "methods" / "tables" / "murk" / "cells.tex").is_file()


def test_a_method_without_a_file_shows_its_results(page: Path) -> None:
    text = words(pages(page)[0])
    assert "was not found or cannot be used: no such file." in text
    assert "formats are not known" in text
    assert "gather" not in text.partition("What a frame declares")[0]
    assert "Best scene: panes" in text


@pytest.mark.parametrize(("fingerprint", "newer"), [("m", False), ("other", True)])
def test_a_file_that_has_changed_is_noted(
    folder: Path, tmp_path: Path, fingerprint: str, newer: bool
) -> None:
    chosen = {"methods": REPORTS["methods"]}
    portraits = {"murk": portrait(fingerprint)}
    path = write(folder, tmp_path, chosen, portraits=portraits).path
    assert ("has changed since these results" in words(pages(path)[1])) is newer


def test_the_references_are_those_that_are_cited(page: Path) -> None:
    text = words(page)
    assert (
        "“Compositing Digital Images”, Computer Graphics (Proceedings of SIGGRAPH) cited by" in text
    )
    assert "Everitt" not in text
    bib = (page.parent / NAME).read_text(encoding="utf-8")
    assert "@inproceedings{PorterDuff1984," in bib
    assert "Everitt2001" not in bib


def test_a_single_file_has_the_pages_inside(folder: Path, tmp_path: Path) -> None:
    chosen = {name: CHOSEN[name] for name in ("methods", "capability")}
    portraits = {"murk": portrait()}
    path = write(folder, tmp_path, chosen, portraits=portraits, single_file=True).path
    assert not pages(path)
    found = tags(path)
    ids = {attributes.get("id") for _, attributes in found}
    links = {attributes["href"] or "" for _, attributes in found if "href" in attributes}
    assert "#method-murk" in links
    assert {link[1:] for link in links if link.startswith("#method")} <= ids
    assert all(link.startswith(("#", "data:")) for link in links)


def test_without_pages_names_do_not_link(folder: Path, tmp_path: Path) -> None:
    path = write(folder, tmp_path, {"capability": REPORTS["capability"]}).path
    assert 'class="page"' not in path.read_text(encoding="utf-8")


def test_figures_say_how_to_cite_them(page: Path) -> None:
    text = words(page)
    assert "oitbench report RESULTS --figure images" in text
    assert "@software{oitbench," in text
