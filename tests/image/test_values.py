"""Pictures of values that need not be light, and their files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenEXR
import pytest

from oitbench.image.values import Show, Values, picture, write_values


def values(*numbers: float, components: int = 1) -> Values:
    return np.asarray(numbers, dtype=np.float32).reshape(1, -1, components)


def gray(shown: Values, show: Show, exposure: float = 0.0) -> list[float]:
    """Return the levels of the red channel, after a check that they are gray."""
    srgb = picture(shown, show, exposure).srgb
    assert (srgb == srgb[..., :1]).all()
    return [round(float(level), 4) for level in srgb[0, :, 0]]


def test_light_is_shown_at_the_exposure_and_fractions_are_not() -> None:
    assert gray(values(0.25), Show.LIGHT, 2.0) == [1.0]
    assert gray(values(0.25), Show.FRACTION, 2.0) == [0.5371]
    assert picture(values(0.25), Show.LIGHT, -1.5).text == "exposure -1.5 stops"


def test_amounts_and_sums_reach_from_zero_to_the_largest() -> None:
    assert gray(values(0, 1, 4), Show.AMOUNT) == [0, 0.25, 1]
    assert gray(values(0, 1, 4), Show.SUM) == [0, 0.5371, 1]
    assert picture(values(0, 1, 4), Show.AMOUNT, unit="px").text.startswith("black 0, white 4 px")


def test_few_huge_values_do_not_darken_the_others() -> None:
    many = np.ones((100, 10, 1), np.float32)
    many[0, 0] = 1e6
    assert picture(many, Show.AMOUNT).srgb.min() == 1


@pytest.mark.parametrize("show", [Show.SIGNED, Show.AMOUNT])
def test_values_of_both_signs_lie_around_middle_gray(show: Show) -> None:
    assert gray(values(-2, 0, 1, 2), show) == [0, 0.5, 0.75, 1]
    assert picture(values(-2, 2), show, unit="px").text == "gray 0, black −2 px, white +2 px"


def test_the_absent_third_component_is_zero() -> None:
    assert picture(values(-1, 1, components=2), Show.SIGNED).srgb.tolist() == [[[0, 1, 0.5]]]
    assert picture(values(0, 1, components=2), Show.AMOUNT).srgb.tolist() == [[[0, 1, 0]]]


def test_depths_reach_from_dark_gray_to_white_and_nothing_is_black() -> None:
    assert gray(values(0, 0.1, 0.3), Show.DEPTH) == [0, 0.2, 1]
    assert gray(values(0, 0), Show.DEPTH) == [0, 0]
    assert "0.1 to white 0.3" in picture(values(0, 0.1, 0.3), Show.DEPTH).text


def test_moments_show_their_first_component() -> None:
    assert gray(values(1, 100, 2, 400, components=2), Show.MOMENTS) == [0.5, 1]


@pytest.mark.parametrize("show", Show)
def test_nan_is_magenta_and_zeros_have_a_picture(show: Show) -> None:
    assert picture(values(0, np.nan), show).srgb[0, 1].tolist() == [1, 0, 1]
    assert np.isfinite(picture(values(0, 0, 0, 0), show).srgb).all()


@pytest.mark.parametrize(("components", "names"), [(1, "Y"), (2, "RG"), (3, "RGB"), (4, "RGBA")])
def test_files_hold_the_values_themselves(tmp_path: Path, components: int, names: str) -> None:
    numbers = np.linspace(-1, 2, 24, dtype=np.float32).reshape(2, -1, components)
    write_values(tmp_path / "x.exr", numbers)
    with OpenEXR.File(str(tmp_path / "x.exr"), separate_channels=True) as file:
        for place, name in enumerate(names):
            np.testing.assert_array_equal(file.channels()[name].pixels, numbers[..., place])


def test_files_hold_integers_and_depths(tmp_path: Path) -> None:
    write_values(tmp_path / "x.exr", np.full((2, 3, 1), 4_000_000_001, np.uint32))
    with OpenEXR.File(str(tmp_path / "x.exr")) as file:
        assert file.channels()["Y"].pixels.dtype == np.uint32
        assert (file.channels()["Y"].pixels == 4_000_000_001).all()
    write_values(tmp_path / "z.exr", values(0.5), depth=True)
    with OpenEXR.File(str(tmp_path / "z.exr")) as file:
        assert list(file.channels()) == ["Z"]
