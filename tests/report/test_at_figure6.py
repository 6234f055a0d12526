"""The report of differences from exact compositing."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np

from oitbench.plugins import Collection
from oitbench.report import Figure, Note
from tests.report.made_up import context, finished, unfinished


def test_differences_of_displayed_colors_are_enhanced_and_clipped() -> None:
    path = Path(__file__).parents[2] / "reports" / "at_figure6.py"
    difference = runpy.run_path(str(path), run_name="at_figure6")["difference"]
    exact = np.full((2, 2, 3), 0.5, np.float32)
    same = difference(exact, exact, 0.0)
    np.testing.assert_array_equal(same, 0)
    # 0.5 is displayed as 0.7354, and 0.52 as 0.7484.
    near = difference(np.full((2, 2, 3), 0.52, np.float32), exact, 0.0)
    np.testing.assert_allclose(near, 8 * (0.74840 - 0.73536), atol=2e-4)
    far = difference(np.zeros((2, 2, 3), np.float32), exact, 0.0)
    np.testing.assert_array_equal(far, 1)


def test_five_scenes_take_two_figures_that_tolerate_missing_cells(tmp_path: Path) -> None:
    cells = [finished(tmp_path, f"scene{number}", "glow", 0.1) for number in range(5)]
    cells.append(finished(tmp_path, "scene0", "murk", 0.3))
    cells.append(unfinished("scene1", "murk"))
    artifacts = Collection.load().reports["at_figure6"].build(context(tmp_path, cells, tmp_path))
    assert len(artifacts) == 2
    for number, figure in enumerate(artifacts, 1):
        assert isinstance(figure, Figure)
        assert "times 8" in figure.caption
        assert (tmp_path / f"differences-{number}.png").stat().st_size > 1000


def test_without_exact_pictures_there_is_a_note(tmp_path: Path) -> None:
    cells = [unfinished("scene", "glow")]
    (note,) = Collection.load().reports["at_figure6"].build(context(tmp_path, cells, tmp_path))
    assert isinstance(note, Note)
