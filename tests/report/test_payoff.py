"""The report of the benefit of expressing more effects."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from oitbench.plugins import Collection
from oitbench.results.schema import Record
from tests.report.made_up import context, with_effects

PAYOFF = Collection.load().reports["payoff"]


def notes(folder: Path, *cells: Record) -> list[str]:
    _, *found = PAYOFF.build(context(folder, cells, folder))
    return [note.text for note in found]


def test_expressing_more_can_be_better(tmp_path: Path) -> None:
    full = with_effects(tmp_path, "full", 0.1)
    plain = with_effects(tmp_path, "plain", 0.4, missing=["DIFFUSION"])
    summary, sentence = notes(tmp_path, full, plain)
    assert "in every scene" in summary
    assert "panes: lower error with more effects" in sentence
    assert "for plain (misses diffusion)" in sentence
    rows = pd.read_csv(tmp_path / "payoff.csv", keep_default_na=False)
    assert rows["mark"].to_list() == ["best", ""]


def test_expressing_more_can_be_worse(tmp_path: Path) -> None:
    full = with_effects(tmp_path, "full", 0.4)
    plain = with_effects(tmp_path, "plain", 0.1, missing=["DIFFUSION"])
    summary, sentence = notes(tmp_path, full, plain)
    assert summary.endswith("do not have the lower FLIP in panes.")
    assert "no lower error with more effects" in sentence


def test_errors_can_be_tied(tmp_path: Path) -> None:
    full = with_effects(tmp_path, "full", 0.4)
    plain = with_effects(tmp_path, "plain", 0.4, missing=["DIFFUSION"])
    summary, sentence = notes(tmp_path, full, plain)
    assert summary.endswith("in panes (tied).")
    assert "panes: a tie: " in sentence
    rows = pd.read_csv(tmp_path / "payoff.csv", keep_default_na=False)
    assert rows["mark"].to_list() == ["best", "tied with the best"]


def test_methods_with_equal_effects_are_not_compared(tmp_path: Path) -> None:
    (summary,) = notes(tmp_path, with_effects(tmp_path, "full", 0.4))
    assert "nothing to compare" in summary
