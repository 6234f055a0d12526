"""Noise floors and ties against references of several noisy parts."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.image.files import Image
from oitbench.image.metrics import rmse
from oitbench.image.ties import PARTS, Errors, clear_difference, means_without, noise_floor

NOISE = 0.1
SHAPE = (32, 32, 3)
TRUTH = np.full(SHAPE, 0.5, dtype=np.float32)


def _metric(image: Image, truth: Image) -> float:
    found = rmse(image, truth)
    assert found is not None
    return found


def _difference(one: Image, other: Image, parts: list[Image]) -> float:
    mean = np.mean(parts, axis=0).astype(np.float32)
    left = means_without(parts)
    errors = [
        Errors(_metric(image, mean), [_metric(image, truth) for truth in left])
        for image in (one, other)
    ]
    return clear_difference(*errors)


def _parts(seed: int = 0) -> list[Image]:
    random = np.random.default_rng(seed)
    return [(TRUTH + random.normal(0, NOISE, SHAPE)).astype(np.float32) for _ in range(PARTS)]


def _off(seed: int, amount: float) -> Image:
    random = np.random.default_rng(1000 + seed)
    return (TRUTH + random.normal(0, amount, SHAPE)).astype(np.float32)


def _differences(one: Image, other: Image) -> list[float]:
    """Return the paired difference against many references."""
    means = [np.mean(_parts(seed), axis=0).astype(np.float32) for seed in range(40)]
    return [_metric(one, mean) - _metric(other, mean) for mean in means]


def test_the_floor_is_the_noise_of_the_mean() -> None:
    assert noise_floor(_parts(), _metric) == pytest.approx(NOISE / PARTS**0.5, rel=0.05)
    assert noise_floor([TRUTH], _metric) == 0


def test_a_difference_below_noise_is_a_tie() -> None:
    ties = 0
    for seed in range(40):
        one, other = _off(2 * seed, 0.05), _off(2 * seed + 1, 0.05)
        # Equal errors against the truth: any difference is noise of the reference.
        other = TRUTH + (other - TRUTH) * (_metric(one, TRUTH) / _metric(other, TRUTH))
        ties += _difference(one, other, _parts(seed)) == 0
    assert ties >= 34


def test_a_difference_of_three_times_its_noise_is_clear() -> None:
    one, other = _off(1, 0.05), _off(2, 0.05)

    def worse(scale: float) -> Image:
        return (TRUTH + (one - TRUTH) * scale).astype(np.float32)

    low, high = 1.0, 2.0
    for _ in range(20):
        scale = (low + high) / 2
        found = _differences(worse(scale), other)
        above = np.mean(found) > 3 * np.std(found)
        low, high = (low, scale) if above else (scale, high)
    clear = 0
    for seed in range(40):
        found_one = _difference(worse(high), other, _parts(seed))
        assert _difference(other, worse(high), _parts(seed)) == -found_one
        assert found_one >= 0
        clear += found_one > 0
    assert clear >= 24


def test_without_noise_any_difference_is_clear() -> None:
    found = _difference(_off(1, 0.051), _off(1, 0.05), [TRUTH])
    assert found == pytest.approx(0.001, rel=0.1)
