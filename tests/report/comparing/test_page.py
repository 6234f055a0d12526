"""The page of a comparison: pictures that changed, tables of changes, added and removed cells."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path
from urllib.parse import unquote

import msgspec
import pytest

import oitbench
from oitbench.report.comparing import page
from oitbench.results.baseline import save
from oitbench.results.records import Results
from oitbench.results.schema import Renderer
from tests.made_up import timed
from tests.report.made_up import FACTS, finished, store

HOSTILE = "<img src=x onerror=alert(1)>"


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Two runs: murk changes, glow invisibly, a hostile method is new, and old is gone."""
    before, after = (tmp_path_factory.mktemp(name) for name in ("before", "after"))
    store(
        before,
        finished(before, "panes", "murk", 0.3),
        finished(before, "panes", "glow", 0.1),
        finished(before, HOSTILE, "murk", 0.1),
        finished(before, "panes", "old", 0.1),
    )
    slow = finished(after, "panes", "murk", 0.2, time=timed(30.0))
    assert slow.outcome is not None
    memory = msgspec.structs.replace(slow.outcome.memory, bytes=4096)
    outcome = msgspec.structs.replace(slow.outcome, memory=memory)
    store(
        after,
        msgspec.structs.replace(slow, outcome=outcome),
        finished(after, "panes", "glow", 0.1 + 1e-6),
        finished(after, HOSTILE, "murk", 0.15),
        finished(after, "panes", HOSTILE, 0.1),
    )
    return before, after


@pytest.fixture(scope="module")
def out(runs: tuple[Path, Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    before, after = runs
    folder = tmp_path_factory.mktemp("page")
    made = page.write(oitbench.compare(after, before), after, before, folder)
    assert made == folder / "index.html"
    return folder


def text(out: Path) -> str:
    return (out / "index.html").read_text(encoding="utf-8")


def words(out: Path) -> str:
    body = re.sub(r"<(script|style).*?</\1>", "", text(out), flags=re.DOTALL)
    return " ".join(re.sub(r"<[^>]*>", "", body).split())


def rows(out: Path, name: str) -> list[dict[str, str]]:
    with (out / f"changes-{name}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_pictures_that_changed_are_shown_and_no_others(out: Path) -> None:
    stacks = [json.loads(s) for s in re.findall('json">({"against.*?)</script>', text(out))]
    # The largest change is first.
    assert [stack["title"] for stack in stacks] == ["panes, murk", f"{HOSTILE}, murk"]
    assert "Of 3 cells, 2 changed by a level of the display or more" in words(out)
    for stack in stacks:
        assert [layer["label"] for layer in stack["layers"]] == ["before", "after"]
        script = (out / unquote(stack["pixels"])).read_text(encoding="utf-8")
        assert '"before": {"width": 16' in script
        assert '"after": {"width": 16' in script
    assert text(out).count("data-preview src=") == 4
    assert text(out).count("signed × 8") == 2 * 2


def test_changes_that_no_display_shows_are_no_changes(runs: tuple[Path, Path]) -> None:
    digests = [
        record.outcome.images["color"].sha256
        for run in runs
        for record in Results.load(run).records
        if record.method == "glow" and record.outcome is not None
    ]
    assert len(set(digests)) == 2


def test_metrics_have_their_change_and_tolerance(out: Path) -> None:
    found = {(r["scene"], r["field"]): r for r in rows(out, "metrics")}
    flip = found["panes", "exact.rmse_lin"]
    assert flip["verdict"] == "better"
    before, after = float(flip["before"]), float(flip["after"])
    assert float(flip["change"]) == pytest.approx(after - before)
    assert float(flip["allowed"]) == pytest.approx(5e-4 + 1e-2 * before)
    assert {r["method"] for r in rows(out, "metrics")} == {"murk"}
    assert (out / "changes-metrics.tex").is_file()


def test_counts_and_times_have_tables_of_their_own(out: Path) -> None:
    (count,) = rows(out, "counts")
    assert (count["field"], count["before"], count["after"]) == ("memory.bytes", "3072", "4096")
    assert (count["change"], count["allowed"], count["verdict"]) == ("1024", "0.0", "changed")
    (time,) = [row for row in rows(out, "times") if row["scene"] == "panes"]
    assert (time["field"], time["after"], time["verdict"]) == ("method_ms", "30.0", "slower")


def test_new_methods_are_additions_and_old_ones_are_listed(out: Path) -> None:
    (added,), (removed,) = rows(out, "added"), rows(out, "removed")
    assert (added["method"], added["cells"], added["scenes"]) == (HOSTILE, "1", "panes")
    assert (removed["method"], removed["scenes"]) == ("old", "panes")
    assert "cells added: 1, removed: 1" in words(out)


def test_nothing_from_results_is_markup(out: Path) -> None:
    assert HOSTILE not in text(out)
    assert "&lt;img src=x onerror=alert(1)&gt;, murk" in text(out)
    assert '"title": "\\u003cimg src=x onerror=alert(1)\\u003e, murk"' in text(out)


def test_the_page_needs_no_other_folder(out: Path) -> None:
    for link in re.findall(r' (?:src|href)="([^"#]+)"', text(out)):
        assert link.startswith("data:") or (out / unquote(link)).is_file(), link
    for word in ("http:", "https:", "@import", "url("):
        assert word not in text(out)


def test_equal_runs_give_equal_bytes(out: Path, runs: tuple[Path, Path], tmp_path: Path) -> None:
    before, after = runs
    page.write(oitbench.compare(after, before), after, before, tmp_path)
    files = sorted(path.relative_to(out) for path in out.rglob("*") if path.is_file())
    for file in files:
        assert (out / file).read_bytes() == (tmp_path / file).read_bytes(), file


def test_runs_without_changes_say_so(runs: tuple[Path, Path], tmp_path: Path) -> None:
    before, _ = runs
    page.write(oitbench.compare(before, before), before, before, tmp_path)
    assert "4 cells compared; values: none changed; cells added: 0, removed: 0." in words(tmp_path)
    assert "No metric moved by more than its tolerance, and no count changed." in words(tmp_path)
    assert not list(tmp_path.glob("changes-*"))


def test_a_baseline_file_has_no_pictures(runs: tuple[Path, Path], tmp_path: Path) -> None:
    before, after = runs
    file = tmp_path / "baseline.json"
    save(before, file)
    page.write(oitbench.compare(after, file), after, file, tmp_path / "out")
    assert "There are no pictures to compare." in words(tmp_path / "out")
    assert rows(tmp_path / "out", "counts")[0]["scene"] == "panes"
    assert rows(tmp_path / "out", "removed")[0]["method"].startswith("panes old ")


def test_other_renderers_compare_no_times(runs: tuple[Path, Path], tmp_path: Path) -> None:
    before, _ = runs
    gl = Renderer("another (test)")
    other = finished(tmp_path / "other", "panes", "murk", 0.3, gl=gl, time=timed(90.0))
    store(tmp_path / "other", other)
    facts = msgspec.structs.replace(FACTS, gl=gl)
    assert facts.renderer == "another (test)"
    page.write(
        oitbench.compare(tmp_path / "other", before), tmp_path / "other", before, tmp_path / "out"
    )
    assert "The renderers differ, so times are not compared" in words(tmp_path / "out")
    assert not (tmp_path / "out" / "changes-times.csv").exists()


def test_a_picture_that_cannot_be_read_is_noted(runs: tuple[Path, Path], tmp_path: Path) -> None:
    before, _ = runs
    murk = finished(tmp_path, "panes", "murk", 0.2)
    store(tmp_path, murk)
    assert murk.outcome is not None
    lost = tmp_path / murk.outcome.images["color"].path
    lost.unlink()
    page.write(oitbench.compare(tmp_path, before), tmp_path, before, tmp_path / "out")
    assert f"{lost} cannot be read" in words(tmp_path / "out")
