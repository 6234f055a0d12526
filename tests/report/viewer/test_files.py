"""The files of the viewer: pixels beside the page, inside of it, and missing; hostile names."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
from PIL import Image

from tests.report.made_up import SIDE
from tests.report.viewer.browser import Viewer
from tests.report.viewer.conftest import HOSTILE, OTHER, OTHER_VIEW
from tests.report.viewer.expected import levels


def test_a_page_without_its_pixels_shows_previews_and_says_so(
    driver: Any, page: Path, tmp_path: Path
) -> None:
    shutil.copy(page, tmp_path / "index.html")
    viewer = Viewer(driver, tmp_path / "index.html").open("view=01-panes&method=i")
    viewer.wait(lambda: viewer.text(".warning-text"))
    assert "pixels/01-panes.js is missing, so these are previews" in viewer.text(".warning-text")
    viewer.settle()
    # Lossy, but of the right picture.
    assert np.abs(viewer.picture(SIDE) - levels(0.08)).mean() < 60
    viewer.press("m")
    assert "no error map: previews are not exact" in viewer.labels()


def test_a_page_in_one_file_needs_no_other(driver: Any, hdr_page: Path) -> None:
    assert [path.name for path in hdr_page.parent.iterdir()] == [hdr_page.name]
    viewer = Viewer(driver, hdr_page).open("view=01-panes&method=i&map=signed")
    assert viewer.labels()[0].startswith("i · HDR-FLIP 0.")
    assert not viewer.complaints()
    broken = viewer.script("return [...document.images].filter(e => !e.naturalWidth).length")
    assert broken == 0


def test_names_from_plugins_stay_text(driver: Any, page: Path) -> None:
    viewer = Viewer(driver, page).open(f"view={OTHER_VIEW}&method={quote(HOSTILE)}")
    assert viewer.labels() == [f"{HOSTILE} · FLIP 0.2838"]
    assert HOSTILE in viewer.text(".side tbody")
    scenes = viewer.driver.find_elements("css selector", "#viewer .scenes option")
    assert [scene.get_attribute("textContent") for scene in scenes] == ["panes", OTHER]
    viewer.press("p", "m", "?")
    assert viewer.driver.title == "oitbench report"
    assert viewer.address("method") == HOSTILE
    assert not viewer.complaints()


def test_d_saves_what_is_shown(viewer: Viewer, tmp_path: Path) -> None:
    viewer.driver.execute_cdp_cmd(
        "Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(tmp_path)}
    )
    viewer.press("5", "d")
    saved = tmp_path / "01-panes e.png"
    viewer.wait(saved.is_file)
    assert (np.asarray(Image.open(saved).convert("RGB")) == levels(0.04)).all()
