"""`oitbench score` and `oitbench run --metric`: what they print, and what they refuse."""

from __future__ import annotations

from pathlib import Path

import pytest

from oitbench.results.records import Results
from tests.cli.helpers import SMALL, Call
from tests.scoring.helpers import MAE, read, write_metric, write_results

FAILING = MAE.replace("return", "return 1 / 0 +")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return write_results(tmp_path / "results")


def test_cells_are_scored_by_the_suite_or_by_a_file(
    call: Call, folder: Path, tmp_path: Path
) -> None:
    answer = call("score", folder)
    assert (answer.code, answer.out, answer.err) == (0, f"{folder}: 2 cells scored\n", "")
    answer = call("score", folder, "--metric", write_metric(tmp_path))
    assert (answer.code, answer.out) == (0, f"{folder}: 2 cells scored by mae_lin\n")
    assert list(Results.load(folder).custom) == ["mae_lin"]


def test_faults_are_named_and_change_the_exit_code(
    call: Call, folder: Path, tmp_path: Path
) -> None:
    path = write_metric(tmp_path, FAILING)
    answer = call("score", folder, "--metric", path)
    assert answer.code == 1
    assert answer.err.startswith(f"mae_lin: {path}:12: ZeroDivisionError: division by zero; no")
    outcome = read(folder)[0].outcome
    assert outcome is not None
    (folder / outcome.images["color"].path).unlink()
    answer = call("score", folder)
    assert (answer.code, answer.out) == (1, f"{folder}: 1 cell scored\n")
    assert "cannot be read (No such file or directory); glass[count=4] mean keeps" in answer.err


def test_what_cannot_be_scored_is_refused(call: Call, folder: Path, tmp_path: Path) -> None:
    path = write_metric(tmp_path, MAE.replace("name", "nam"))
    call("score", folder, "--metric", path).assert_refused("defines no 'name'")
    call("score", tmp_path / "none").assert_refused("holds no cells.jsonl")


def test_a_run_scores_by_a_file_and_renders_nothing_when_it_changes(
    call: Call, tmp_path: Path
) -> None:
    out, path = tmp_path / "out", write_metric(tmp_path)
    chosen = ("--scene", "layer_stack", "--method", "alpha_blend", "--preset", "guard", *SMALL)
    arguments = ("run", *chosen, "--out", out, "--metric", path)
    assert call(*arguments).code == 0
    (first,) = read(out)
    assert first.metric("exact", "mae_lin")
    answer = call(*arguments)
    assert "1 kept from before" in answer.out
    assert read(out) == [first]
    write_metric(tmp_path, MAE.replace("return", "return 2 *"))
    answer = call(*arguments)
    assert "nothing to do; 1 kept from before" in answer.out
    (second,) = read(out)
    assert second.metric("exact", "mae_lin") == 2 * (first.metric("exact", "mae_lin") or 0)
    assert second.seconds == first.seconds
    write_metric(tmp_path, FAILING)
    answer = call(*arguments)
    assert answer.code == 1
    assert f"metric: mae_lin: {path}:12: ZeroDivisionError" in answer.err
    (third,) = read(out)
    assert (third.status, third.metric("exact", "mae_lin")) == ("ok", None)


def test_a_run_with_a_broken_metric_renders_nothing(call: Call, tmp_path: Path) -> None:
    path = write_metric(tmp_path, "1 / 0")
    out = tmp_path / "out"
    arguments = ("--scene", "layer_stack", "--method", "alpha_blend", *SMALL, "--out", out)
    call("run", *arguments, "--metric", path).assert_refused("metric.py:1: ZeroDivisionError")
    assert not out.exists()
