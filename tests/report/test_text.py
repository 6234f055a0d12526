"""Names and reasons are text: in figures, in pages, and in tables for spreadsheets."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest
from PIL import Image

from oitbench.image import files, stored
from oitbench.plugins import Collection
from oitbench.report import Stack, figures, write
from oitbench.report.artifacts import write_csv
from oitbench.report.markdown import tables
from oitbench.report.plates import fitted
from oitbench.results.records import Results
from oitbench.results.schema import Record
from tests.report.made_up import context, finished, store, unfinished

REPORTS = Collection.load().places.reports
ODD = ("$x^{", "<script>alert(1)</script>", "a|b & 'c'", r"\frac{$$")


def test_names_and_reasons_with_markup_are_shown_as_they_are(tmp_path: Path) -> None:
    cells = [finished(tmp_path, "panes $^{", name, 0.1 * place) for place, name in enumerate(ODD)]
    lost = unfinished("panes $^{", "=1+1", reason="no $\\alpha^{ <b>")
    paths = {name: REPORTS[name] for name in ("ablation", "images", "memory", "pareto", "table")}
    page = write(store(tmp_path, *cells, lost), tmp_path / "out", paths)
    assert page.missing == ()
    text = page.path.read_text(encoding="utf-8")
    assert "<script>alert" not in text
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in text
    assert "no $\\alpha^{ &lt;b&gt;" in text
    with (tmp_path / "out" / "table.csv").open(encoding="utf-8", newline="") as file:
        names = [row["method"] for row in csv.DictReader(file)]
    assert sorted(names) == sorted([*ODD, "'=1+1"])


@pytest.mark.parametrize("text", ["=1", "+1", "-1", "−1", "@x", "\t=1", " =1"])
def test_no_text_is_a_formula_in_a_spreadsheet(tmp_path: Path, text: str) -> None:
    path = tmp_path / "x.csv"
    write_csv(path, ["a", "b", "c", "d"], [[text, -1.5, None, "1-2"]])
    with path.open(encoding="utf-8", newline="") as file:
        assert list(csv.reader(file))[1] == [f"'{text}", "-1.5", "", "1-2"]


def test_bars_in_names_add_no_columns_to_markdown(tmp_path: Path) -> None:
    folder = store(tmp_path, finished(tmp_path, "panes", "a|b", 0.1))
    lines = tables(Results.load(folder)).splitlines()
    assert "| scene | truth | noise floor | `a\\|b` |" in lines


def narrow(folder: Path, size: tuple[int, int]) -> Record:
    """Return a record whose pictures have that size."""
    made = finished(folder, "panes", "murk", 0.2, traced=False, size=size)
    assert made.outcome is not None
    image = np.full((size[1], size[0], 3), 0.5, np.float32)
    maps = files.flip_channels(image[..., 0], image[..., 0])
    images = {
        kind: stored.store(
            folder,
            f"images/{kind}",
            maps if kind.startswith("flip") else files.image_channels(image),
        )
        for kind in made.outcome.images
    }
    outcome = msgspec.structs.replace(made.outcome, images=images)
    return msgspec.structs.replace(made, outcome=outcome)


@pytest.mark.parametrize("size", [(1, 700), (700, 1)])
def test_narrow_pictures_make_no_huge_figure(tmp_path: Path, size: tuple[int, int]) -> None:
    known = replace(context(tmp_path, [narrow(tmp_path, size)], tmp_path), sheets=True)
    grids = Collection.load().reports["images"].build(known)
    (grid,) = [item for item in grids if isinstance(item, Stack)]
    assert grid.sheet is not None
    with Image.open(grid.sheet.png) as figure:
        assert max(figure.size) < 15 * figures.DOTS_PER_INCH


def test_only_very_tall_pictures_are_drawn_narrower() -> None:
    assert fitted((640, 360), 2.0) == (2.0, 1.125)
    assert fitted((1, 3), 2.0) == (2.0, 6.0)
    assert fitted((1, 6), 2.0) == (1.0, 6.0)
