"""Baseline files: their content and its layout."""

from __future__ import annotations

import json
from pathlib import Path

import oitbench
from oitbench.image import metrics
from oitbench.results import baseline
from oitbench.results.store import Store
from tests.made_up import write
from tests.results.helpers import BETA, exact, slower, write_changed


def test_a_baseline_file_equals_its_folder_except_for_times(before: Path, tmp_path: Path) -> None:
    file = tmp_path / "baseline.json"
    baseline.save(before, file)
    assert baseline.read(file).rows == baseline.read(before).rows
    assert oitbench.compare(before, file).differences == ()
    assert oitbench.compare(write_changed(before, slower), file).differences == ()


def test_a_baseline_file_is_sorted_and_rounded_and_names_no_machine(
    before: Path, tmp_path: Path
) -> None:
    first, second = tmp_path / "a.json", tmp_path / "b.json"
    baseline.save(before, first)
    noisy = Store.open(write_changed(before, exact(metrics.RMSE, 0.05 + 1e-9)))
    baseline.save(write(tmp_path / "reversed", noisy.records()[::-1]), second)
    assert first.read_bytes() == second.read_bytes()
    text = first.read_text()
    content = json.loads(text)
    assert text == json.dumps(content, indent=1, sort_keys=True, ensure_ascii=False) + "\n"
    assert content["renderer"] == "softly"
    assert content["cells"][BETA]["passes"] == "peel × 8, resolve"
    for word in ("/home", ".exr", "method_ms", "samples", str(tmp_path)):
        assert word not in text
