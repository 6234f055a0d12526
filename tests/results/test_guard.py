"""The methods reproduce the committed baseline, and a broken method is a regression.

After an intended change of a metric or a count, rewrite the baseline with `python -m tests.guard`.
"""

from __future__ import annotations

import shutil
from pathlib import Path

from oitbench.places import own_folder
from oitbench.results import baseline
from oitbench.results import comparison as regression
from oitbench.results.baseline import Snapshot
from oitbench.results.store import CELLS, read_cells
from tests import guard


def test_every_method_reproduces_the_baseline(tmp_path: Path) -> None:
    guard.run(tmp_path)
    comparison = regression.compare(tmp_path, guard.BASELINE)
    assert comparison.passed, "\n".join(map(str, comparison.regressions))


def test_the_baseline_names_no_machine() -> None:
    text = guard.BASELINE.read_text(encoding="utf-8")
    assert "method_ms" not in text
    assert ".exr" not in text
    assert str(Path.home()) not in text
    assert str(own_folder()) not in text


def test_a_broken_shader_is_a_regression(tmp_path: Path) -> None:
    """The broken resolve loses a twentieth of the coverage."""
    method = tmp_path / "broken"
    shutil.copytree(own_folder() / "methods" / "weighted_blended", method)
    resolve = method / "resolve.glsl"
    text = resolve.read_text(encoding="utf-8")
    broken = text.replace("1.0 - read_reveal()", "0.95 - read_reveal()")
    assert broken != text
    resolve.write_text(broken, encoding="utf-8")
    scenes = ("layer_stack", "smoke_ball[detail=0.1]")
    guard.run(tmp_path / "results", scenes, [str(method)])
    for record in read_cells(tmp_path / "results" / CELLS).values():
        assert record.time is None
        assert record.outcome is not None
        assert record.outcome.scores["path_traced"].reason == "left out of this run"
    now = baseline.read(tmp_path / "results")
    assert len(now.rows) == len(scenes)
    every = baseline.read(guard.BASELINE)
    sound = {cell: every.rows[cell.replace("broken", "weighted_blended")] for cell in now.rows}
    before = Snapshot(every.renderer, sound)
    comparison = regression.compare_snapshots(now, before)
    assert {item.cell for item in comparison.regressions} == set(now.rows)
    worse = {item.field for item in comparison.regressions if item.verdict == "worse"}
    assert {"exact.flip_ldr@67ppd", "exact.rmse_lin", "exact.rmse_transmittance"} <= worse
