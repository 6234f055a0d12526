"""The report: from a made-up results folder to figures, tables and a page that needs no net."""

from __future__ import annotations

import csv
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from oitbench.cli.report import command
from oitbench.errors import UsageError
from oitbench.image import files as images
from oitbench.image import metrics
from oitbench.plugins import Collection
from oitbench.report import Column, labels, palette, write, write_table
from oitbench.results.records import Results
from oitbench.results.store import CellKey, Record, Store, image_path

SIDE = 16
FACTS = {
    "gl": {"renderer": "llvmpipe (test)", "version": "4.5", "software": True},
    "methods": ["glow", "murk"],
    "seed": 1,
}


def finished(folder: Path, scene: str, method: str, error: float, *, traced: bool = True) -> Record:
    """Return a record with pictures that differ from the truth by `error`."""
    truth = np.random.default_rng(5).random((SIDE, SIDE, 3), dtype=np.float32)
    picture = truth * np.float32(1 - error)
    record: Record = {
        "scene": scene,
        "method": method,
        "name": method.partition("[")[0],
        "variant": {"ssaa": 2},
        "size": [SIDE, SIDE],
        "status": "ok",
        "reason": "",
        "effects": {"called": ["COVERAGE"], "expressed": [], "missing": ["COVERAGE"]},
        "fragments": 100,
        "exposure": 0.0,
        "time": {"frame_ms": {"median": 2 - error, "low": 1.9 - error, "high": 2.2 - error}},
        "memory": {
            "bytes": 3072,
            "bits_per_pixel": 96,
            "terms": [{"resource": "a", "bytes": 2048}, {"resource": "b", "bytes": 1024}],
        },
        "traffic": {
            "bytes": 400,
            "terms": [
                {
                    "pass": "gather",
                    "resource": "a",
                    "kind": "write",
                    "items": 100,
                    "bytes_per_item": 4,
                    "bytes": 400,
                }
            ],
        },
        "nonfinite": {"nan": 0, "inf": 0, "negative": 0},
        "metrics": {"exact": metrics.compare(truth, picture, 0.0).values},
    }
    kinds = {"color": picture, "exact": truth}
    if traced:
        scores: dict[str, Any] = dict(metrics.compare(truth, picture, 0.0).values)
        scores["noise_floor"] = {metrics.FLIP_LDR: 0.01, metrics.RMSE: 0.01}
        record["metrics"]["path_traced"] = scores
        kinds["path_traced"] = truth
    else:
        record["metrics"]["path_traced"] = {"reason": "fragments have no geometry"}
    key = CellKey.of(record)
    record["images"] = {kind: image_path(key, kind) for kind in kinds}
    for kind, pixels in kinds.items():
        images.write_exr(folder / record["images"][kind], pixels)
    return record


def unfinished(scene: str, method: str, status: str, reason: str) -> Record:
    return {
        "scene": scene,
        "method": method,
        "variant": {"ssaa": 2},
        "size": [SIDE, SIDE],
        "status": status,
        "reason": reason,
    }


def unstable(folder: Path) -> Record:
    """Return a record whose picture has a NaN, and therefore no metric."""
    record = finished(folder, "panes", "glow[n=16]", 0.2)
    picture = images.read_exr(folder / record["images"]["color"])
    picture[3, 3] = np.nan
    images.write_exr(folder / record["images"]["color"], picture)
    nothing = dict.fromkeys(metrics.NAMES)
    return record | {
        "status": "unstable",
        "reason": "1 NaN pixel",
        "nonfinite": metrics.count_nonfinite(picture),
        "metrics": {"exact": nothing, "path_traced": nothing},
    }


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("results")
    store = Store.open(path)
    store.append(finished(path, "panes", "murk", 0.3))
    store.append(finished(path, "panes", "glow[n=8]", 0.0))
    store.append(unstable(path))
    store.append(unfinished("panes", "<b>bold</b>", "failed", "shader & 'nodes' <undeclared>"))
    store.append(finished(path, "lists", "murk", 0.1, traced=False))
    store.append(unfinished("lists", "glow[n=8]", "timeout", "no end within 9 s"))
    store.write_run(FACTS)
    return path


@pytest.fixture(scope="module")
def page(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(folder, tmp_path_factory.mktemp("a report"), Collection.load().reports)


class Links(HTMLParser):
    """Collects everything that a page refers to."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found += [value or "" for name, value in attrs if name in ("src", "href")]


def links(page: Path) -> list[str]:
    parser = Links()
    parser.feed(page.read_text(encoding="utf-8"))
    return parser.found


def test_page_needs_no_network(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for word in ("http:", "https:", "//cdn", "@import", "url("):
        assert word not in text


def test_every_link_leads_somewhere(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    found = links(page)
    assert len([link for link in found if link.endswith(".png")]) > 20
    for link in found:
        if link.startswith("#"):
            assert f'id="{link[1:]}"' in text
        else:
            target = page.parent / unquote(link)
            assert target.is_file(), link
            assert target.stat().st_size > 0


def test_figures_come_as_png_and_pdf_and_tables_as_csv(page: Path) -> None:
    made = {path.name for path in page.parent.iterdir()}
    for name in ("pareto", "images", "memory", "traffic"):
        assert {f"{name}-01-panes.png", f"{name}-01-panes.pdf"} <= made
    assert {"table.csv", "pareto.csv", "memory.csv", "traffic.csv"} <= made


def test_no_cell_is_dropped_and_reasons_are_told(page: Path, folder: Path) -> None:
    table = pd.read_csv(page.parent / "table.csv")
    assert len(table) == len(Results.load(folder).records) == 6
    failed = table[table["status"] == "failed"].iloc[0]
    assert failed["reason"] == "shader & 'nodes' <undeclared>"
    assert np.isnan(failed["frame_ms"])
    text = page.read_text(encoding="utf-8")
    # Escaped: a label is text, never markup.
    assert "&lt;undeclared&gt;" in text
    assert "<b>bold</b>" not in text
    assert "no end within 9 s" in text
    assert "fragments have no geometry" in text
    assert "software renderer" in text


def test_table_holds_the_numbers(page: Path) -> None:
    with (page.parent / "table.csv").open(encoding="utf-8", newline="") as file:
        rows = {(row["scene"], row["method"]): row for row in csv.DictReader(file)}
    exact = rows["panes", "glow[n=8]"]
    assert float(exact["exact.flip_ldr@67ppd"]) == 0
    assert float(exact["frame_ms"]) == 2
    assert float(exact["memory_mib"]) == pytest.approx(3072 / 2**20)
    assert exact["path_traced.rank"] == "1"
    assert rows["panes", "glow[n=16]"]["unstable_pixels"] == "1"
    assert rows["panes", "glow[n=16]"]["exact.flip_ldr@67ppd"] == ""
    traffic = pd.read_csv(page.parent / "traffic.csv")
    assert (traffic["items"] * traffic["bytes_per_item"] == traffic["bytes"]).all()


def test_frame_is_flat(folder: Path) -> None:
    frame = Results.load(folder).frame()
    assert len(frame) == 6
    assert frame["path_traced.flip_ldr@67ppd"].notna().sum() == 2
    assert set(frame["name"]) == {"murk", "glow", "<b>bold</b>"}
    assert not frame.map(lambda value: isinstance(value, list | dict)).any(axis=None)


def test_methods_keep_order_and_look(folder: Path) -> None:
    results = Results.load(folder)
    assert results.scenes == ("panes", "lists")
    assert results.methods == ("<b>bold</b>", "glow[n=8]", "glow[n=16]", "murk")
    small, large = results.style("glow[n=8]"), results.style("glow[n=16]")
    assert small.color == large.color != results.style("murk").color
    assert small.marker != large.marker
    # The color belongs to the name, not to what happens to be shown.
    alone = palette.styles({"murk": "murk"}, known=["glow", "murk"])
    both = palette.styles({"murk": "murk", "glow": "glow"}, known=["glow", "murk"])
    assert alone["murk"] == both["murk"]
    murk = unfinished("panes", "murk", "failed", "no")
    glow = unfinished("panes", "glow", "failed", "no")
    shown = [Results(folder, records, FACTS).style("murk") for records in ((murk,), (glow, murk))]
    assert shown[0] == shown[1]


def test_twenty_four_methods_have_distinct_colors() -> None:
    found = palette.styles({f"m{place:02d}": f"m{place:02d}" for place in range(24)})
    assert len({style.color for style in found.values()}) == 24


@pytest.mark.parametrize(
    "records",
    [
        lambda folder: [finished(folder, "panes", "murk", 0.2, traced=False)],
        lambda folder: [unfinished("panes", "murk", "failed", "no")],
        lambda folder: [],
    ],
    ids=["one method", "nothing finished", "no cell"],
)
def test_little_is_reported_too(tmp_path: Path, records: Callable[[Path], list[Record]]) -> None:
    store = Store.open(tmp_path)
    for record in records(tmp_path):
        store.append(record)
    store.compact()
    page = write(tmp_path, None, Collection.load().reports)
    assert page == tmp_path / "report" / "index.html"
    for link in links(page):
        assert link.startswith("#") or (page.parent / unquote(link)).is_file()


def test_missing_picture_costs_only_itself(tmp_path: Path) -> None:
    store = Store.open(tmp_path)
    record = finished(tmp_path, "panes", "murk", 0.2)
    store.append(record)
    store.append(finished(tmp_path, "panes", "glow", 0.1))
    (tmp_path / record["images"]["color"]).unlink()
    page = write(tmp_path, tmp_path / "out", {"images": Collection.load().reports["images"]})
    assert sum(link.endswith("glow.png") for link in links(page)) == 2
    assert not any(link.endswith("murk.png") for link in links(page))


def test_sizes_are_told_apart(tmp_path: Path) -> None:
    record = unfinished("panes", "murk", "failed", "no")
    results = Results(tmp_path, (record, {**record, "size": [8, 4]}), {})
    assert [panel.title for panel in results.panels()] == ["panes · 8 × 4", "panes · 16 × 16"]
    assert len({panel.slug for panel in results.panels()}) == 2


def test_folders_without_results_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"holds no cells\.jsonl"):
        Results.load(tmp_path)
    answer = CliRunner().invoke(command, [str(tmp_path / "no")])
    assert isinstance(answer.exception, UsageError)


def test_front_and_ties() -> None:
    reports = Collection.load().reports
    points = {"slow": (9.0, 0.0), "fast": (1.0, 0.5), "beaten": (2.0, 0.6), "same": (9.5, 0.0)}
    assert reports["pareto"].front(points) == ["fast", "slow"]
    errors = [("a", 0.10), ("b", 0.105), ("c", 0.12), ("d", 0.128), ("e", 0.2)]
    ranks = reports["table"].ties(errors, 0.01)
    assert ranks == {"a": "1=", "b": "1=", "c": "3=", "d": "3=", "e": "5"}
    assert reports["table"].ties([("a", 0.1), ("b", 0.1)], 0.0) == {"a": "1=", "b": "1="}


def test_labels_do_not_overlap() -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6, 4))
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    axes.set_xlim(0, 10)
    axes.set_ylim(0, 10)
    random = np.random.default_rng(2)
    crowd = [
        labels.Label(x, y, f"method {place}", "#000000", x, x)
        for place, (x, y) in enumerate(random.normal(5, 0.8, (14, 2)))
    ]
    labels.place(axes, crowd)
    boxes = [text.get_window_extent() for text in axes.texts]
    assert len(boxes) == 14
    for place, box in enumerate(boxes):
        assert axes.bbox.contains(*box.min)
        for other in boxes[:place]:
            width = min(box.x1, other.x1) - max(box.x0, other.x0)
            height = min(box.y1, other.y1) - max(box.y0, other.y0)
            assert width <= 0 or height <= 0


def test_table_text_keeps_zero_apart_from_small(tmp_path: Path) -> None:
    column = Column("e", "E", decimals=4)
    assert [column.text(value) for value in (0.0, 1e-9, 0.25, None)] == [
        "0",
        "<0.0001",
        "0.2500",
        "–",
    ]
    assert Column("n", "N").text(12345) == "12,345"
    assert Column("t", "T").text(0.012345) == "0.0123"
    table = write_table(
        tmp_path / "t.csv", (column, Column("x", "X")), [(0.1, None)], title="", caption=""
    )
    assert table.visible == [0]
    assert pd.read_csv(table.csv).columns.tolist() == ["e", "x"]
