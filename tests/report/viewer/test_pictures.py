"""What each key does to the pixels on the canvas."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pytest

from oitbench.image import metrics
from oitbench.image.files import to_srgb
from tests.report.made_up import SIDE
from tests.report.viewer.browser import Levels, Viewer
from tests.report.viewer.conftest import OTHER_VIEW
from tests.report.viewer.expected import EXPOSURE, Floats, levels, linear, radiance


def same(found: Levels, expected: Floats, within: float = 0.51) -> bool:
    """Whether levels are equal, but for rounding."""
    return bool((np.abs(found - np.clip(expected, 0, 255)) <= within).all())


def test_the_first_method_is_shown_without_loss(viewer: Viewer) -> None:
    assert viewer.labels() == ["a · FLIP 0.0000"]
    assert (viewer.picture(SIDE) == levels()).all()


def test_a_digit_shows_a_method(viewer: Viewer) -> None:
    viewer.press("9")
    assert viewer.labels() == ["i · FLIP 0.1435"]
    assert (viewer.picture(SIDE) == levels(0.08)).all()
    viewer.press("2")
    assert (viewer.picture(SIDE) == levels(0.01)).all()


def test_shift_and_a_digit_show_a_reference_and_go_back(viewer: Viewer) -> None:
    viewer.press("5", "shift+2")
    assert viewer.labels() == ["matched tracing"]
    assert (viewer.picture(SIDE) == levels()).all()
    assert (viewer.address("truth"), viewer.address("against")) == ("matched", "matched")
    viewer.press("shift+2")
    assert (viewer.picture(SIDE) == levels(0.04)).all()


def test_arrows_flip_through_all_pictures(viewer: Viewer) -> None:
    seen = []
    for _ in range(13):
        seen.append(viewer.labels()[0].partition(" ·")[0])
        viewer.press("right")
    truths = ["exact compositing", "matched tracing", "full path tracing"]
    assert seen == ["a", "b", "c", "d", "e", "f", "g", "h", "i", "j", *truths]
    assert viewer.labels()[0].startswith("a ")
    viewer.press("left", "left")
    assert viewer.labels() == ["matched tracing"]


def test_exposure_acts_on_display_levels_and_says_so(viewer: Viewer) -> None:
    assert viewer.text(".warning-text") == ""
    viewer.press("e")
    expected = 255.0 * to_srgb(linear(levels()), -1)
    assert same(viewer.picture(SIDE), expected)
    assert "light above white is lost" in viewer.text(".warning-text")
    assert "exposure −1 stop" in viewer.text(".facts")
    viewer.press("E", "E")
    assert same(viewer.picture(SIDE), 255.0 * to_srgb(linear(levels()), 1))


def test_half_floats_keep_light_above_white(driver: Any, hdr_page: Path) -> None:
    viewer = Viewer(driver, hdr_page).open("view=01-panes")
    halves = radiance().astype(np.float16)
    assert same(viewer.picture(SIDE), 255.0 * to_srgb(halves, EXPOSURE))
    assert viewer.labels() == ["a · HDR-FLIP 0.0000"]
    viewer.press("e")
    below = 255.0 * to_srgb(halves, EXPOSURE - 1)
    assert same(viewer.picture(SIDE), below)
    # The levels of the other page are white there.
    clipped = 255.0 * to_srgb(linear(levels()), -1)
    assert (below - clipped).max() > 50
    assert viewer.text(".warning-text") == ""
    assert not viewer.complaints()


def test_g_lifts_shadows_and_then_shows_false_colors(viewer: Viewer) -> None:
    viewer.press("g")
    shown = linear(levels())
    assert same(viewer.picture(SIDE), 255 * shown**0.25)
    viewer.press("g")
    luminance = shown @ [0.2126, 0.7152, 0.0722]
    places = np.clip(1 + np.log2(luminance) / 8, 0, 1)
    colors = 255.0 * matplotlib.colormaps["viridis"](np.rint(255 * places).astype(int))[..., :3]
    # A place of the color map beside the right one is at most some levels away.
    assert same(viewer.picture(SIDE), colors, 4)
    assert "luminance" in viewer.text(".facts")
    viewer.press("g")
    assert (viewer.picture(SIDE) == levels()).all()


def error_map(error: float) -> Floats:
    """Return the FLIP map of a method, as the viewer has it."""
    truth, picture = (radiance(value).astype(np.float32) for value in (0.0, error))
    found = metrics.compare(truth, picture, 0.0).maps[metrics.FLIP_LDR]
    rounded: Floats = (np.rint(255 * np.sqrt(found.astype(np.float64))) / 255) ** 2
    return rounded


def test_m_shows_flip_signed_and_absolute_differences(viewer: Viewer) -> None:
    viewer.press("9", "m")
    magma = matplotlib.colormaps["magma"]
    errors = error_map(0.08)
    expected = 255.0 * magma(np.rint(255 * errors).astype(int))[..., :3]
    assert same(viewer.picture(SIDE), expected, 4)
    assert viewer.text(".high") == "1"
    viewer.press("E", "E")
    brighter = 255.0 * magma(np.rint(255 * np.clip(4 * errors, 0, 1)).astype(int))[..., :3]
    assert same(viewer.picture(SIDE), brighter, 8)
    assert viewer.text(".high") == "0.25"
    viewer.press("e", "e", "m")
    difference = levels(0.08) - levels()
    assert same(viewer.picture(SIDE), 128 + 8 * difference)
    assert (viewer.text(".low"), viewer.text(".high")) == ("−16", "+16")
    viewer.press("m")
    assert same(viewer.picture(SIDE), 8 * np.abs(difference))
    viewer.press("m")
    assert (viewer.picture(SIDE) == levels(0.08)).all()


def test_a_digit_and_shift_choose_the_reference_of_a_map(viewer: Viewer) -> None:
    viewer.press("4", "m", "shift+3")
    assert viewer.labels()[0].startswith("d ")
    assert "against full path tracing" in viewer.text(".facts")
    assert viewer.address("against") == "full"


def test_s_splits_and_the_divider_moves(viewer: Viewer) -> None:
    viewer.press("9", "s")
    assert viewer.labels() == ["i · FLIP 0.1435", "exact compositing"]
    width = viewer.box()[2]
    half = SIDE // 2
    whole = viewer.canvas()[..., :3].astype(float)
    rows, columns = centers(viewer)
    shown = whole[np.ix_(rows, columns)]
    assert (shown[:, : half - 1] == levels(0.08)[:, : half - 1]).all()
    assert (shown[:, half + 1 :] == levels()[:, half + 1 :]).all()
    viewer.drag((0.5, 0.5), (0.7, 0.5))
    assert float(viewer.address("divider")) == pytest.approx(0.7, abs=0.01)
    assert viewer.address("at") == ""
    moved = viewer.canvas()[..., :3][np.ix_(rows, columns)]
    beyond = columns < 0.7 * width - 3
    assert (moved[:, beyond] == levels(0.08)[:, beyond]).all()
    assert (moved[:, -1] == levels()[:, -1]).all()


def centers(viewer: Viewer) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows and columns of the canvas at the middles of the picture's pixels."""
    _, _, width, height = viewer.box()
    scale = min(width, height) // SIDE
    middles = (np.arange(SIDE) - SIDE / 2 + 0.5) * scale
    return (height / 2 + middles).astype(int), (width / 2 + middles).astype(int)


def test_pixels_that_are_not_finite_are_magenta(driver: Any, hdr_page: Path) -> None:
    viewer = Viewer(driver, hdr_page).open(f"view={OTHER_VIEW}&method=nan")
    assert viewer.picture(SIDE)[3, 3].tolist() == [255, 0, 255]
    viewer.press("m", "m")
    assert viewer.picture(SIDE)[3, 3].tolist() == [255, 0, 255]
