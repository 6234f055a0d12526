"""Masks of blue noise, and what they do to the noise of methods."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from scipy.ndimage import gaussian_filter

from oitbench.gl.device import Device
from oitbench.measure import accounting
from oitbench.method.blue_noise import SIDE, thresholds, void_and_cluster
from oitbench.scene import Floats
from tests.helpers import NOTHING, RED, WHITE, Layer, opened, render, scene_of, stack

# Parts of the power of white noise, per frequency of at most 0.1 and 0.2 cycles per texel.
LOWEST, LOW = 1 / 1000, 1 / 100


def spectrum(values: npt.ArrayLike) -> tuple[Floats, Floats]:
    """Return the frequency in cycles per texel, and the power; white noise has a mean of one."""
    offsets = np.asarray(values, np.float64)
    offsets = offsets - offsets.mean()
    power = abs(np.fft.fft2(offsets)) ** 2
    axis = np.fft.fftfreq(len(offsets))
    radius = np.hypot(axis[:, None], axis)
    inside = radius > 0
    return radius[inside], power[inside] / power[inside].mean()


@pytest.mark.parametrize(("side", "seed"), [(4, 1), (8, 5), (31, 2), (64, 1)])
def test_every_rank_occurs_once(side: int, seed: int) -> None:
    ranks = void_and_cluster(side, seed)
    np.testing.assert_array_equal(np.sort(ranks, axis=None), np.arange(side * side))


def test_equal_seeds_give_equal_masks() -> None:
    first, again = (void_and_cluster.__wrapped__(16, 3) for _ in range(2))
    np.testing.assert_array_equal(first, again)
    assert (first != void_and_cluster(16, 4)).mean() > 0.9


def test_a_mask_has_hardly_any_low_frequencies() -> None:
    radius, power = spectrum(thresholds())
    assert power[radius <= 0.1].mean() < LOWEST
    assert power[radius <= 0.2].mean() < LOW
    white = np.random.default_rng(1).permutation(SIDE * SIDE).reshape(SIDE, SIDE)
    radius, power = spectrum(white)
    assert power[radius <= 0.1].mean() > 0.5


@pytest.mark.parametrize("part", [1 / 16, 1 / 4, 1 / 2, 7 / 8])
def test_the_texels_below_any_threshold_have_few_low_frequencies(part: float) -> None:
    radius, power = spectrum(thresholds() < part)
    assert power[radius <= 0.1].mean() < 0.1


def test_points_keep_their_distance_across_the_border() -> None:
    count = 256
    rows, columns = np.nonzero(void_and_cluster(SIDE, 1) < count)
    distances = []
    for wrap in (False, True):
        apart = [abs(axis[:, None] - axis) for axis in (rows, columns)]
        if wrap:
            apart = [np.minimum(part, SIDE - part) for part in apart]
        lengths = np.hypot(*apart) + SIDE * np.eye(count)
        distances.append(lengths.min())
    # In a square of 4 x 4 texels each, points at random would touch.
    assert distances[1] == distances[0] > 2


def rough(device: Device, name: str, layers: int, opacity: float = 0.37) -> float:
    """Return the error of a smoothed picture: a white background behind some black layers."""
    lists = stack([Layer(1.0 + k, opacity, NOTHING) for k in range(layers)], SIDE)
    found = render(device, scene_of(lists, WHITE), name)[..., 0].astype(np.float64)
    error = found - (1 - opacity) ** layers
    smooth = gaussian_filter(error, 1.5, mode="wrap")
    return float(np.sqrt((smooth**2).mean()))


@pytest.mark.parametrize(
    ("name", "layers", "left"),
    [
        ("hashed_alpha[scale=0.25,noise={}]", 1, 0.25),
        ("hashed_alpha[scale=0.25,noise={}]", 3, 0.85),
        ("stochastic[correction=none,precision=float,noise={}]", 1, 0.4),
    ],
)
def test_blue_noise_is_smoother_once_it_is_filtered(
    device: Device, name: str, layers: int, left: float
) -> None:
    white, blue = (rough(device, name.format(noise), layers) for noise in ("white", "blue"))
    assert 0 < blue < left * white


@pytest.mark.parametrize(
    "name",
    [
        "hashed_alpha[scale=0.25,frames=16,noise={}]",
        "stochastic[correction=none,precision=float,frames=16,noise={}]",
        "stochastic[correction=alpha,precision=float,frames=16,noise={}]",
        "stochastic[correction=depth,precision=float,frames=16,noise={}]",
    ],
)
def test_blue_noise_has_the_mean_of_white_noise(device: Device, name: str) -> None:
    layers = [Layer(1.5, 0.3, RED), Layer(3.0, 0.55, (0.2, 0.1, 0.7)), Layer(5.0, 0.2, WHITE)]
    white, blue = (
        render(device, stack(layers, SIDE), name.format(noise)).reshape(-1, 3).astype(np.float64)
        for noise in ("white", "blue")
    )
    # Four standard errors of the difference; colors of hashed alpha are half floats.
    allowed = 4 * np.hypot(white.std(axis=0), blue.std(axis=0)) / SIDE + 2.0**-12
    assert (abs(white.mean(axis=0) - blue.mean(axis=0)) <= allowed).all()
    assert abs(white - blue).max() > 1e-3


def test_two_layers_have_independent_masks(device: Device) -> None:
    lists = stack([Layer(1.0, 0.5, NOTHING), Layer(2.0, 0.5, NOTHING)], SIDE)
    for name in ("hashed_alpha[noise=blue]", "stochastic[noise=blue,correction=none]"):
        found = render(device, scene_of(lists, WHITE), name)[..., 0]
        assert found.mean() == pytest.approx(0.25, abs=0.02)


def test_the_mask_is_read_and_is_no_memory_of_the_method(device: Device) -> None:
    lists = stack([Layer(1.0, 0.5, RED)])
    for name, passes in (
        ("hashed_alpha[noise={}]", {"test"}),
        ("stochastic[noise={}]", {"cover"}),
        ("stochastic[correction=alpha,noise={}]", {"cover", "gather"}),
    ):
        sizes = []
        for noise in ("white", "blue"):
            with opened(device, scene_of(lists), name.format(noise)) as frame:
                frame.render()
                terms = accounting.traffic(frame, frame.measure()).terms
                sizes.append(accounting.memory(frame).bytes)
                read = [term for term in terms if term.resource == "blue_noise"]
                expected = passes if noise == "blue" else set()
                assert {term.pass_.split()[0] for term in read} == expected
                assert {term.bytes_per_item for term in read} <= {4}
        assert sizes[0] == sizes[1]


def test_the_mask_can_be_looked_at(device: Device) -> None:
    lists = stack([Layer(1.0, 0.5, RED)])
    with opened(device, scene_of(lists), "hashed_alpha[noise=blue]") as frame:
        frame.render()
        np.testing.assert_array_equal(frame.read("blue_noise")[::-1, :, 0], thresholds())
