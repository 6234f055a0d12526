"""`oitbench report`: refused folders, and chosen sections."""

from __future__ import annotations

from pathlib import Path

from tests.cli.helpers import Call
from tests.report.made_up import finished, store


def test_a_folder_without_results_is_refused(call: Call, tmp_path: Path) -> None:
    call("report", tmp_path / "none").assert_refused("none holds no cells.jsonl")


def test_only_chosen_sections_are_written(call: Call, tmp_path: Path) -> None:
    folder = store(tmp_path / "results", finished(tmp_path / "results", "panes", "murk", 0.1))
    assert call("report", folder, "--section", "traffic", "--section", "memory").code == 0
    page = (folder / "report" / "index.html").read_text(encoding="utf-8")
    assert [name for name in ("memory", "traffic", "pareto") if f'id="{name}"' in page] == [
        "memory",
        "traffic",
    ]
    call("report", folder, "--section", "traffik").assert_refused("traffik")


def test_a_page_in_one_file_has_the_crops_of_the_scene(call: Call, tmp_path: Path) -> None:
    folder = store(tmp_path / "results", finished(tmp_path / "results", "glass_bars", "murk", 0.1))
    assert call("report", folder, "--section", "images", "--single-file", "--hdr").code == 0
    page = (folder / "report" / "index.html").read_text(encoding="utf-8")
    assert '"crops": {"crossings": [0.38, 0.26, 0.26, 0.26]}' in page
    assert '"radiance": true' in page
    assert 'data-pixels="01-glass_bars"' in page
