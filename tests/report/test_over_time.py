"""The report of errors over frames."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from oitbench.plugins import Collection
from oitbench.report import Figure, Note
from oitbench.results.schema import Record
from tests.report.made_up import context, finished, unfinished

OVER_TIME = Collection.load().reports["over_time"]


def cell(folder: Path, method: str, frames: int, error: float, ssaa: int = 1) -> Record:
    return finished(
        folder, "panes", method, error, ssaa=ssaa, outcome={"parameters": {"frames": frames}}
    )


def test_a_curve_joins_cells_that_differ_in_frames_alone(tmp_path: Path) -> None:
    cells = [
        cell(tmp_path, "murk[frames=4]", 4, 0.1),
        cell(tmp_path, "murk", 1, 0.2),
        cell(tmp_path, "murk[frames=16]", 16, 0.05),
        cell(tmp_path, "murk[noise=blue]", 1, 0.2),
        cell(tmp_path, "murk[noise=blue,frames=16]", 16, 0.2),
        cell(tmp_path, "murk", 1, 0.1, ssaa=2),
        cell(tmp_path, "murk[frames=4]", 4, 0.1, ssaa=2),
        cell(tmp_path, "glow[frames=4]", 4, 0.1),
        finished(tmp_path, "panes", "smooth", 0.3),
        unfinished("panes", "murk[frames=64]"),
    ]
    figure, _ = OVER_TIME.build(context(tmp_path, cells, tmp_path))
    assert isinstance(figure, Figure)
    assert figure.png.exists()
    rows = pd.read_csv(tmp_path / "over-time.csv")
    assert list(zip(rows["ssaa"], rows["frames"], strict=True)) == [
        (1, 1), (1, 4), (1, 16), (2, 1), (2, 4), (1, 1), (1, 16)
    ]  # fmt: skip
    assert rows["method"].to_list()[:3] == ["murk", "murk[frames=4]", "murk[frames=16]"]
    # The errors of 1, 4 and 16 frames are halved each time.
    slopes = dict(zip(zip(rows["method"], rows["ssaa"], strict=True), rows["slope"], strict=True))
    assert slopes["murk", 1] == pytest.approx(-0.5, abs=0.02)
    assert slopes["murk", 2] == pytest.approx(0, abs=1e-6)
    assert slopes["murk[noise=blue]", 1] == pytest.approx(0, abs=1e-6)


def test_scenes_have_plots_of_their_own(tmp_path: Path) -> None:
    cells = [
        finished(tmp_path, scene, f"murk[frames={n}]", 0.1, outcome={"parameters": {"frames": n}})
        for scene in ("panes", "glass")
        for n in (2, 4)
    ]
    OVER_TIME.build(context(tmp_path, cells, tmp_path))
    rows = pd.read_csv(tmp_path / "over-time.csv")
    assert set(rows["scene"]) == {"panes", "glass"}


def test_one_number_of_frames_is_no_curve(tmp_path: Path) -> None:
    cells = [cell(tmp_path, "murk[frames=4]", 4, 0.1), cell(tmp_path, "glow", 1, 0.1)]
    (note,) = OVER_TIME.build(context(tmp_path, cells, tmp_path))
    assert isinstance(note, Note)
    assert "--preset noise" in note.text
