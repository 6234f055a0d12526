"""The viewer on the page of a comparison."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import oitbench
from oitbench.report.comparing import page
from tests.report.made_up import SIDE, finished, store
from tests.report.viewer.browser import Viewer
from tests.report.viewer.expected import levels


def test_the_viewer_flips_between_before_and_after(driver: Any, tmp_path: Path) -> None:
    before, after = tmp_path / "before", tmp_path / "after"
    store(before, finished(before, "panes", "murk", 0.0, outcome={"exposure": 1.0}))
    store(after, finished(after, "panes", "murk", 0.02, outcome={"exposure": 1.0}))
    made = page.write(oitbench.compare(after, before), after, before, tmp_path / "page")
    viewer = Viewer(driver, made).open("view=001-panes")
    assert viewer.labels()[0].startswith("after · change of levels ")
    assert (viewer.picture(SIDE) == levels(0.02)).all()
    viewer.press("shift+1")
    assert viewer.labels() == ["before"]
    assert (viewer.picture(SIDE) == levels(0.0)).all()
    viewer.open("view=001-panes&map=signed")
    steps = levels(0.02).astype(int) - levels()
    assert (np.abs(viewer.picture(SIDE) - np.clip(128 + 8 * steps, 0, 255)) <= 1).all()
    assert not viewer.complaints()
