"""`oitbench report`: refused folders."""

from __future__ import annotations

from pathlib import Path

from tests.cli.helpers import Call


def test_a_folder_without_results_is_refused(call: Call, tmp_path: Path) -> None:
    call("report", tmp_path / "none").assert_refused("none holds no cells.jsonl")
