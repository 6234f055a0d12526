"""The comparison of a timed picture with accurate renderings."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from oitbench.gl.frame import Image
from oitbench.measure.agreement import difference

PICTURE: Image = np.random.default_rng(3).random((6, 8, 3), dtype=np.float32)


def noisy(scale: float, seed: int = 5) -> Callable[[], Image]:
    """Return a function that returns the picture with other noise at each call."""
    generator = np.random.default_rng(seed)

    def render() -> Image:
        noise = scale * generator.standard_normal(PICTURE.shape)
        return (PICTURE + noise).astype(np.float32)

    return render


def test_equal_pictures_agree_and_are_rendered_once() -> None:
    calls: list[int] = []

    def render() -> Image:
        calls.append(1)
        return PICTURE.copy()

    assert difference(PICTURE, render) == ""
    assert len(calls) == 1


def test_one_bit_of_one_pixel_is_a_difference() -> None:
    timed = PICTURE.copy()
    timed[2, 3, 1] = np.nextafter(timed[2, 3, 1], np.float32(2))
    assert "differs from the scored one by an RMSE of" in difference(timed, lambda: PICTURE)


def test_a_picture_may_differ_as_much_as_accurate_ones_do() -> None:
    assert difference(noisy(0.01, seed=6)(), noisy(0.01)) == ""
    assert "an RMSE of 0.04" in difference(noisy(0.04, seed=6)(), noisy(0.01))


def test_pixels_that_are_not_finite_must_be_the_same() -> None:
    timed = PICTURE.copy()
    timed[0, 0, 0] = np.nan
    assert difference(timed, timed.copy) == ""
    assert "an RMSE of inf" in difference(timed, noisy(0.01))
