"""The page: from a made-up results folder to figures, tables and a page that works offline."""

from __future__ import annotations

import base64
import csv
import json
import re
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import parse_qs, unquote

import numpy as np
import pandas as pd
import pytest

from oitbench.papers.listing import figures_of, read_papers
from oitbench.plugins import Collection
from oitbench.report import write
from oitbench.results.records import Results
from oitbench.results.schema import Record
from tests.damage import flip_bit
from tests.report.made_up import finished, store, unfinished, unstable

PLACES = Collection.load().places
APART = figures_of(read_papers(PLACES.folders).values())
REPORTS = {name: path for name, path in PLACES.reports.items() if name not in APART}
"""Those of the page of all results."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("results")
    return store(
        path,
        finished(path, "panes", "murk", 0.3),
        finished(path, "panes", "glow[n=8]", 0.0),
        unstable(path, "panes", "glow[n=16]"),
        unfinished("panes", "<b>bold</b>", "failed", "shader & 'nodes' <undeclared>"),
        finished(path, "lists", "murk", 0.1, traced=False),
        unfinished("lists", "glow[n=8]", "timeout", "no end within 9 s"),
    )


@pytest.fixture(scope="module")
def page(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(folder, tmp_path_factory.mktemp("a report"), REPORTS).path


class Links(HTMLParser):
    """Collects all references of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found += [value or "" for name, value in attrs if name in ("src", "href")]


def links(page: Path) -> list[str]:
    parser = Links()
    parser.feed(page.read_text(encoding="utf-8"))
    return parser.found


def test_the_page_needs_no_network(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for word in ("http:", "https:", "//cdn", "@import", "url("):
        assert word not in text


def test_every_link_has_a_target(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    found = links(page)
    assert len([link for link in found if link.endswith(".png")]) > 20
    names = re.findall('data-stack="([^"]*)"', text)
    for link in found:
        if link.startswith("data:"):
            continue
        if link.startswith("#view="):
            assert parse_qs(link[1:])["view"][0] in names
        elif link.startswith("#"):
            assert f'id="{link[1:]}"' in text
        else:
            target = page.parent / unquote(link)
            assert target.is_file(), link
            assert target.stat().st_size > 0


def test_figures_are_png_and_pdf_and_tables_csv(page: Path) -> None:
    made = {path.name for path in page.parent.iterdir()}
    for name in ("pareto", "memory", "traffic"):
        assert {f"{name}-01-panes.png", f"{name}-01-panes.pdf"} <= made
    assert {"table.csv", "pareto.csv", "memory.csv", "traffic.csv"} <= made


def test_sheets_of_pictures_are_drawn_on_request(page: Path) -> None:
    assert not list(page.parent.glob("images-*"))
    assert "oitbench report RESULTS --figure images" in page.read_text(encoding="utf-8")


def test_no_cell_and_no_reason_is_left_out(page: Path, folder: Path) -> None:
    table = pd.read_csv(page.parent / "table.csv")
    assert len(table) == len(Results.load(folder).records) == 6
    failed = table[table["status"] == "failed"].iloc[0]
    assert failed["reason"] == "shader & 'nodes' <undeclared>"
    assert np.isnan(failed["frame_ms"])
    assert np.isnan(failed["unstable_pixels"])
    text = page.read_text(encoding="utf-8")
    # Labels are escaped, so that they are text and not markup.
    assert "&lt;undeclared&gt;" in text
    assert "<b>bold</b>" not in text
    assert "no end within 9 s" in text
    assert "no geometry" in text
    assert "software renderer" in text


def test_tables_contain_the_numbers(page: Path) -> None:
    with (page.parent / "table.csv").open(encoding="utf-8", newline="") as file:
        rows = {(row["scene"], row["method"]): row for row in csv.DictReader(file)}
    exact = rows["panes", "glow[n=8]"]
    assert float(exact["exact.flip_ldr@67ppd"]) == 0
    assert float(exact["method_ms"]) == 2
    assert float(exact["frame_ms"]) == 3
    assert float(exact["memory_mib"]) == pytest.approx(3072 / 2**20)
    assert exact["rank"] == "1"
    assert rows["panes", "glow[n=16]"]["unstable_pixels"] == "1"
    assert rows["panes", "glow[n=16]"]["exact.flip_ldr@67ppd"] == ""
    traffic = pd.read_csv(page.parent / "traffic.csv")
    assert (traffic["items"] * traffic["bytes_per_item"] == traffic["bytes"]).all()


@pytest.mark.parametrize(
    "records",
    [
        lambda folder: [finished(folder, "panes", "murk", 0.2, traced=False)],
        lambda folder: [unfinished("panes", "murk")],
        lambda folder: [],
    ],
    ids=["one method", "nothing finished", "no cell"],
)
def test_few_cells_are_enough(tmp_path: Path, records: Callable[[Path], list[Record]]) -> None:
    page = write(store(tmp_path, *records(tmp_path)), None, REPORTS).path
    assert page == tmp_path / "report" / "index.html"
    for link in links(page):
        assert link.startswith(("#", "data:")) or (page.parent / unquote(link)).is_file()


@pytest.mark.parametrize("fault", ["is damaged", "cannot be read"])
@pytest.mark.parametrize("kind", ["color", "exact", "flip_exact"])
def test_a_bad_image_is_one_line_and_affects_no_other(
    tmp_path: Path, kind: str, fault: str
) -> None:
    murk = finished(tmp_path, "panes", "murk", 0.2)
    store(tmp_path, murk, finished(tmp_path, "panes", "glow", 0.1))
    assert murk.outcome is not None
    image = murk.outcome.images[kind]
    if fault == "is damaged":
        flip_bit(tmp_path / image.path, 8 * image.bytes // 2)
    else:
        (tmp_path / image.path).unlink()
    page = write(tmp_path, tmp_path / "out", {"images": REPORTS["images"]}).path
    text = page.read_text(encoding="utf-8")
    assert text.count(f"<li>{tmp_path / image.path} {fault}") == 1
    # The truth is a file that all cells share, so it cannot be shown at all.
    shown = re.findall('<img [^>]*alt="([^"]*)"', text)
    assert sum("glow" in name for name in shown) == 2
    assert sum("murk" in name for name in shown) == {"color": 0, "exact": 2, "flip_exact": 1}[kind]


def test_labels_that_look_alike_have_pictures_of_their_own(tmp_path: Path) -> None:
    labels = ["my-method", "my_method", "my method", "m[x=1e-15]", "m[x=1e+15]", "y" * 250]
    cells = [finished(tmp_path, "s" * 250, label, 0.1 * i) for i, label in enumerate(labels)]
    reports = {"images": REPORTS["images"]}
    page = write(store(tmp_path, *cells), tmp_path / "out", reports).path
    text = page.read_text(encoding="utf-8")
    stack = json.loads(re.findall('<script type="application/json">(.*)</script>', text)[0])
    keys = [layer["key"] for layer in stack["layers"]]
    assert len(set(keys)) == len(labels) + 3
    script = (page.parent / unquote(stack["pixels"])).read_text(encoding="utf-8")
    assert all(f'"{key}": {{"width"' in script for key in keys)


def test_equal_results_give_equal_bytes(page: Path, folder: Path, tmp_path: Path) -> None:
    made = [page.parent, write(folder, tmp_path / "again", REPORTS).path.parent]
    files = [sorted(p.relative_to(out) for p in out.rglob("*") if p.is_file()) for out in made]
    assert files[0] == files[1]
    assert Path("pixels/01-panes.js") in files[0]
    for file in files[0]:
        assert (made[0] / file).read_bytes() == (made[1] / file).read_bytes(), file


def test_a_page_in_one_file_links_to_no_other(folder: Path, tmp_path: Path) -> None:
    reports = {name: REPORTS[name] for name in ("images", "pareto", "table")}
    page = write(folder, tmp_path / "out", reports, single_file=True).path
    text = page.read_text(encoding="utf-8")
    for link in links(page):
        assert link.startswith(("#", "data:")), link
    for name in ("01-panes", "02-lists"):
        assert f'<script type="text/plain" data-pixels="{name}">oitbenchPixels("{name}"' in text
    # A figure is shown, and not linked to as well.
    figure = base64.b64encode((page.parent / "pareto-01-panes.png").read_bytes()).decode()
    assert text.count(figure) == 1
    table = re.findall('href="data:text/csv;base64,([^"]*)" download="table.csv"', text)
    assert base64.b64decode(table[0]) == (tmp_path / "out" / "table.csv").read_bytes()


def test_the_renderer_is_known_without_run_facts(tmp_path: Path) -> None:
    store(tmp_path, finished(tmp_path, "panes", "murk", 0.2))
    (tmp_path / "run.json").write_text("{")
    page = write(tmp_path, None, {}).path
    assert "Rendered on <strong>llvmpipe (test)</strong>" in page.read_text(encoding="utf-8")
