"""Image metrics: known values, and images without a score."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import Any

import flip_evaluator
import numpy as np
import pytest

from oitbench.image import files as images
from oitbench.image import metrics
from oitbench.image.files import Image
from oitbench.scene import Floats
from tests.image.helpers import constant


def flip_of_constants(one: Floats, other: Floats) -> float:
    """Return FLIP of two constant images of linear color (Andersson et al. 2020).

    Filters and features have no influence; the Hunt-adjusted HyAB distance is remapped.
    """
    to_xyz = np.array(
        [
            [10135552 / 24577794, 8788810 / 24577794, 4435075 / 24577794],
            [2613072 / 12288897, 8788810 / 12288897, 887015 / 12288897],
            [1425312 / 73733382, 8788810 / 73733382, 70074185 / 73733382],
        ]
    )

    def hunt_lab(rgb: Floats) -> Floats:
        ratio = to_xyz @ rgb / (to_xyz @ np.ones(3))
        delta = 6 / 29
        f = np.where(ratio > delta**3, np.cbrt(ratio), ratio / (3 * delta**2) + 4 / 29)
        light = 116 * f[1] - 16
        hunt = 0.01 * light
        return np.array([light, hunt * 500 * (f[0] - f[1]), hunt * 200 * (f[1] - f[2])])

    def distance(a: Floats, b: Floats) -> float:
        change = hunt_lab(a) - hunt_lab(b)
        return float((abs(change[0]) + math.hypot(change[1], change[2])) ** 0.7)

    largest = distance(np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0]))
    error, knee = distance(one, other), 0.4 * largest
    if error < knee:
        return 0.95 * error / knee
    return 0.95 + 0.05 * (error - knee) / (largest - knee)


def test_invalid_pixels_are_counted_once_for_all_channels() -> None:
    picture = constant((1, 1, 1))
    picture[0, 0] = np.nan
    picture[0, 1] = (np.inf, 0, 0)
    picture[0, 2] = (-np.inf, 0, 0)
    picture[0, 3] = (-1e-6, -1, 0)
    picture[0, 4] = -0.0
    assert metrics.count_nonfinite(picture) == {"nan": 1, "inf": 2, "negative": 1}


def test_flip_matches_the_published_equations() -> None:
    pairs = [((0.25, 0.25, 0.25), (0.5, 0.5, 0.5)), ((0, 0, 0), (1, 1, 1)), ((0.3, 0.1, 0.6),) * 2]
    pairs.append(((0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    for one, other in pairs:
        expected = flip_of_constants(np.array(one, float), np.array(other, float))
        measured = metrics.flip_ldr(constant(one), constant(other), 0.0)
        assert measured == pytest.approx(expected, abs=2e-4), (one, other)


def test_flip_depends_on_the_exposed_image(picture: images.Image) -> None:
    other = picture[::-1]
    direct = metrics.flip_ldr(picture, other, 0.0)
    assert direct is not None
    assert direct > 0.1
    assert metrics.flip_ldr(picture / 4, other / 4, 2.0) == pytest.approx(direct, abs=1e-6)


def test_flip_is_the_mean_of_its_map(picture: images.Image) -> None:
    scores = metrics.compare(picture, picture[::-1], 0.5)
    assert set(scores.maps) == {metrics.FLIP_LDR, metrics.FLIP_HDR}
    for name, errors in scores.maps.items():
        assert errors.shape == (24, 32)
        assert errors.dtype == np.float32
        assert float(errors.mean()) == pytest.approx(scores.values[name], abs=1e-6)
    assert scores.values[metrics.FLIP_LDR] == metrics.flip_ldr(picture, picture[::-1], 0.5)
    assert scores.values[metrics.RMSE] == metrics.rmse(picture, picture[::-1])


def test_equal_images_have_no_error() -> None:
    picture = constant((0.2, 0.5, 0.8))
    values = metrics.compare(picture, picture, 0.0).values
    assert tuple(values) == metrics.NAMES
    assert values[metrics.PSNR] is None
    assert values[metrics.SSIM] == pytest.approx(1)
    assert [values[name] for name in (metrics.FLIP_LDR, metrics.FLIP_HDR, metrics.RMSE)] == [0] * 3
    json.dumps(values, allow_nan=False)


def test_errors_of_constant_images_have_their_closed_form() -> None:
    truth, guess = constant((0.5, 0.5, 0.5)), constant((0.75, 0.5, 0.5))
    values = metrics.compare(truth, guess, 0.0).values
    assert values[metrics.RMSE] == pytest.approx(0.25 / math.sqrt(3))
    assert values[metrics.RELMSE] == pytest.approx(0.0625 / 0.26 / 3)
    shown = images.to_srgb(np.array([0.5, 0.75]), 0.0)
    expected = -10 * math.log10((shown[1] - shown[0]) ** 2 / 3)
    assert values[metrics.PSNR] == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_pixels_that_are_not_finite_have_no_score(picture: images.Image, bad: float) -> None:
    broken = picture.copy()
    broken[5, 5, 1] = bad
    for pair in ((picture, broken), (broken, picture)):
        scores = metrics.compare(*pair, 0.0)
        assert scores.values == dict.fromkeys(metrics.NAMES)
        assert scores.maps == {}


def test_hdr_flip_accepts_a_black_reference(picture: images.Image) -> None:
    # With automatic exposures, the evaluator would exit the process.
    black = np.zeros_like(picture)
    assert metrics.compare(black, black, 0.0).values[metrics.FLIP_HDR] == 0
    error = metrics.compare(black, picture, 0.0).values[metrics.FLIP_HDR]
    assert error is not None
    assert 0.5 < error <= 1


def test_hdr_flip_detects_differences_that_the_display_clips() -> None:
    bright, brighter = constant((2, 2, 2)), constant((6, 6, 6))
    values = metrics.compare(bright, brighter, 0.0).values
    assert values[metrics.FLIP_LDR] == 0
    assert (values[metrics.FLIP_HDR] or 0) > 0.05


def test_wrong_types_and_shapes_are_refused(picture: images.Image) -> None:
    with pytest.raises(TypeError, match="uint8"):
        metrics.flip_ldr((picture * 255).astype(np.uint8), picture, 0.0)
    with pytest.raises(ValueError, match=r"\(height, width, 3\)"):
        metrics.compare(np.dstack([picture, picture[..., :1]]), picture, 0.0)
    with pytest.raises(ValueError, match="but the test image is"):
        metrics.compare(picture, picture[:-1], 0.0)


def test_small_images_have_no_ssim() -> None:
    small = constant((0.5, 0.5, 0.5), side=10)
    values = metrics.compare(small, small, 0.0).values
    assert values[metrics.SSIM] is None
    assert values[metrics.RMSE] == 0


def test_the_error_of_transmittance_is_the_rmse_of_its_mean(picture: images.Image) -> None:
    gray = picture.mean(axis=-1)
    assert metrics.rmse_transmittance(picture, gray) == pytest.approx(0, abs=1e-7)
    assert metrics.rmse_transmittance(gray, gray + 0.5) == pytest.approx(0.5)
    assert metrics.rmse_transmittance(gray, gray * np.nan) is None
    with pytest.raises(ValueError, match="have shapes"):
        metrics.rmse_transmittance(gray, gray[1:])


def test_order_spread_is_the_range_of_each_channel(picture: images.Image) -> None:
    brighter, darker = picture.copy(), picture.copy()
    brighter[0, 0, 0] += np.float32(0.25)
    darker[0, 0, 0] -= np.float32(0.125)
    found = metrics.order_spread([picture, brighter, darker])
    assert found[metrics.ORDER_SPREAD_MAX] == pytest.approx(0.375)
    assert found[metrics.ORDER_SPREAD_MEAN] == pytest.approx(0.375 / picture.size)
    nothing = {metrics.ORDER_SPREAD_MAX: None, metrics.ORDER_SPREAD_MEAN: None}
    assert metrics.order_spread([]) == metrics.order_spread([picture]) == nothing
    assert metrics.order_spread([picture, picture * np.nan]) == nothing
    endless = np.full_like(picture, np.inf)
    assert metrics.order_spread([endless, endless]) == nothing


@pytest.mark.parametrize("place", [(40, 60), (0, 0), (95, 0), (12, 119)])
@pytest.mark.parametrize("kind", [metrics.flip_ldr, metrics.flip_hdr])
def test_flip_around_differing_pixels_is_that_of_whole_images(
    kind: Callable[..., float | None], place: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    random = np.random.default_rng(5)
    reference = random.random((96, 120, 3)).astype(np.float32) * np.float32(1.5)
    test = reference.copy()
    test[place] += np.float32(0.3)
    evaluated: list[tuple[int, ...]] = []
    maps: list[Image] = []
    evaluate = flip_evaluator.evaluate

    def watched(one: Image, other: Image, *arguments: Any, **named: Any) -> Any:
        evaluated.append(one.shape)
        return evaluate(one, other, *arguments, **named)

    monkeypatch.setattr(flip_evaluator, "evaluate", watched)
    mean = metrics._mean

    def kept(errors: Image) -> float | None:
        maps.append(errors)
        return mean(errors)

    monkeypatch.setattr(metrics, "_mean", kept)
    kind(reference, test, 0.0)
    monkeypatch.setattr(metrics, "_around", lambda differs: slice(None))
    kind(reference, test, 0.0)
    part, whole = maps
    assert np.array_equal(part, whole)
    assert whole.any()
    assert evaluated[1] == reference.shape
    assert evaluated[0][0] < 96
    assert evaluated[0][1] < 120
    assert kind(reference, reference, 0.0) == 0
    assert len(evaluated) == 2
