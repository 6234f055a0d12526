from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import quote

import pytest

from oitbench.filenames import file_name
from oitbench.plugins import Collection
from oitbench.report import write
from tests.report.made_up import finished, store, unfinished, unstable
from tests.report.viewer.browser import Viewer, chromium

IMAGES = {"images": Collection.load().places.reports["images"]}
HOSTILE = '<img src=x onerror="document.title=1">'
OTHER = "<i>other</i>"
"""A scene with a hostile name, and the name of its stack in the address."""
OTHER_VIEW = quote(f"02-{file_name(OTHER)}")
METHODS = ("a", "b", "c", "d", "e", "f", "g", "h", "i", "j")
"""Methods with errors of 0, 0.01, 0.02 and so on."""
CROPS = {"panes": {"middle": (0.25, 0.25, 0.5, 0.5), "edge@above": (0.0, 0.0, 0.5, 0.5)}}


@pytest.fixture(scope="session")
def driver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    with chromium(tmp_path_factory.mktemp("downloads")) as made:
        yield made


@pytest.fixture(scope="session")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Ten methods, one without a picture, one with a NaN, one with a hostile name; two scenes."""
    folder = tmp_path_factory.mktemp("results")
    cells = [
        finished(folder, "panes", method, 0.01 * place, outcome={"exposure": 1.0})
        for place, method in enumerate(METHODS)
    ]
    return store(
        folder,
        *cells,
        unfinished("panes", "dead", reason="no <b>shader</b>"),
        unstable(folder, OTHER, "nan"),
        finished(folder, OTHER, HOSTILE, 0.2, traced=False),
    )


@pytest.fixture(scope="session")
def page(results: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(results, tmp_path_factory.mktemp("a page"), IMAGES, crops=CROPS).path


@pytest.fixture(scope="session")
def hdr_page(results: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One file alone, with linear radiance."""
    made = write(results, tmp_path_factory.mktemp("hdr"), IMAGES, hdr=True, single_file=True).path
    alone = tmp_path_factory.mktemp("alone") / "copy.html"
    return made.rename(alone)


@pytest.fixture
def viewer(driver: Any, page: Path) -> Iterator[Viewer]:
    """The viewer at its first state; the test fails if the page logs an error."""
    made = Viewer(driver, page).open("view=01-panes")
    yield made
    assert not made.complaints()
