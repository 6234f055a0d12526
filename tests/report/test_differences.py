"""The report of differences from exact compositing."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from oitbench.papers.plates import difference
from oitbench.plugins import Collection
from oitbench.report import Figure, Note
from tests.report.made_up import context, finished, unfinished


def test_differences_of_displayed_colors_are_enhanced_and_clipped() -> None:
    exact = np.full((2, 2, 3), 0.5, np.float32)
    np.testing.assert_array_equal(difference(exact, exact), 0)
    near = difference(np.full((2, 2, 3), 0.48, np.float32), exact)
    np.testing.assert_allclose(near, 0.16, atol=1e-6)
    far = difference(np.zeros((2, 2, 3), np.float32), exact)
    np.testing.assert_array_equal(far, 1)


def test_five_scenes_take_two_figures_that_tolerate_missing_cells(tmp_path: Path) -> None:
    cells = [finished(tmp_path, f"scene{number}", "glow", 0.1) for number in range(5)]
    cells.append(finished(tmp_path, "scene0", "murk", 0.3))
    cells.append(unfinished("scene1", "murk"))
    artifacts = Collection.load().reports["differences"].build(context(tmp_path, cells, tmp_path))
    assert len(artifacts) == 2
    for number, figure in enumerate(artifacts, 1):
        assert isinstance(figure, Figure)
        assert "times 8" in figure.caption
        assert (tmp_path / f"differences-{number}.png").stat().st_size > 1000


def test_of_many_settings_of_a_method_one_is_drawn(tmp_path: Path) -> None:
    report = Collection.load().reports["differences"]
    glows = [f"glow[k={k}]" for k in range(report.MOST)]
    labels = [*glows[:2], "glow", "murk[k=2]", "murk[k=1]", *glows[2:]]
    cells = [finished(tmp_path, "calm", label, 0.1) for label in labels]
    known = context(tmp_path, cells, tmp_path)
    assert report.columns(known, labels) == ["glow", "murk[k=2]"]
    assert report.columns(known, labels[: report.MOST]) == labels[: report.MOST]


def test_without_exact_pictures_there_is_a_note(tmp_path: Path) -> None:
    cells = [unfinished("scene", "glow")]
    (note,) = Collection.load().reports["differences"].build(context(tmp_path, cells, tmp_path))
    assert isinstance(note, Note)
