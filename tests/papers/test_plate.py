"""Plates: rows of pictures, parts with frames, differences and empty places."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from oitbench.image.files import Image
from oitbench.papers import Album, Picture, Row, needs_of, plate
from oitbench.truths import EXACT, MATCHED
from tests.papers.made_up import context, made
from tests.report.made_up import unfinished

GLOW, MURK = Picture("fog", "glow", "Glow"), Picture("fog", "murk", "Murk")
NEEDS = needs_of([GLOW, MURK])
CROPS = {"fog": {"low": (0.5, 0.5, 0.5, 0.25)}}


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[Image]:
    """The pictures that plates draw, which are not drawn."""
    found: list[Image] = []

    def keep(canvas: object, image: Image, left: float, top: float, width: float) -> None:
        found.append(image)

    monkeypatch.setattr("oitbench.papers.plates.draw_picture", keep)
    return found


def album_of(folder: Path) -> Album:
    records = [made(folder, NEEDS[0], 0.0), made(folder, NEEDS[1], 0.5)]
    return Album(context(folder, records, CROPS), NEEDS)


def test_rows_become_one_figure_in_two_files(tmp_path: Path) -> None:
    album = album_of(tmp_path)
    rows = (
        Row((GLOW, MURK), "fog", score=EXACT, marks=("low",)),
        Row((None, replace(MURK, label="")), against=GLOW),
        Row((GLOW.part("low"), MURK.part("low"))),
    )
    figure = plate(album, rows, "fogs", title="Fogs", caption="Two.")
    assert (figure.title, figure.caption) == ("Fogs", "Two.")
    assert figure.png == tmp_path / "out" / "fogs.png"
    assert figure.png.stat().st_size > 1000
    assert figure.pdf.is_file()


def test_differences_are_from_another_picture(tmp_path: Path, drawn: list[Image]) -> None:
    album = album_of(tmp_path)
    rows = [Row((GLOW, None, MURK), against=GLOW), Row([GLOW, replace(GLOW, truth=MATCHED)])]
    plate(album, rows, "fogs", title="", caption="")
    same, apart, shown, truth = drawn
    np.testing.assert_array_equal(same, 0)
    assert apart.max() == 1
    np.testing.assert_allclose(shown, truth, atol=1e-2)


def test_differences_of_parts_are_from_the_same_part(tmp_path: Path, drawn: list[Image]) -> None:
    rows = [Row([GLOW.part("low")], against=GLOW.part("low"))]
    plate(album_of(tmp_path), rows, "fogs", title="", caption="")
    assert drawn[0].shape == (4, 8, 3)
    np.testing.assert_array_equal(drawn[0], 0)


def test_an_empty_place_says_why(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written: list[str] = []
    monkeypatch.setattr(
        "oitbench.papers.plates.write", lambda canvas, text, *rest, **named: written.append(text)
    )
    records = [made(tmp_path, NEEDS[0]), unfinished("fog", "murk", "failed", "no shader")]
    album = Album(context(tmp_path, records), NEEDS)
    plate(album, [Row((GLOW, MURK), score=EXACT)], "fogs", title="", caption="")
    error = album.error(GLOW, EXACT)
    assert written == ["Glow", f"FLIP {error:.4f}", "Murk", "failed: no shader"]
