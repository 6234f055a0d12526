"""Depth-layered weighted blending against its model, its identities and its failures."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from oitbench.gl.device import Device
from oitbench.measure.oracle import composite
from tests.helpers import (
    BACKGROUND,
    BLUE,
    GREEN,
    NOTHING,
    RED,
    WHITE,
    Layer,
    bits_per_pixel,
    keeps_promises,
    method,
    random_lists,
    render,
    scene_of,
    stack,
)
from tests.models import layered as model
from tests.models.commutative import layers_of

SLABS = (1, 2, 4, 8)


def variant(slabs: int, precision: str = "float") -> str:
    return f"depth_layered[layers={slabs},precision={precision}]"


@settings(max_examples=16, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 2**32 - 1),
    layers=st.integers(1, 20),
    slabs=st.sampled_from(SLABS),
    precision=st.sampled_from(["half", "float"]),
)
def test_pictures_follow_the_model(
    device: Device, seed: int, layers: int, slabs: int, precision: str
) -> None:
    random = np.random.default_rng(seed)
    drawn = random_lists(layers, tinted=True, seed=seed, side=8)
    drawn.z[:] = random.uniform(1, 9, drawn.z.shape)
    drawn.coverage[random.random(drawn.z.shape) < 0.1] = 0.0
    opaque = random.random(drawn.z.shape) < 0.05
    drawn.coverage[opaque], drawn.transmission[opaque] = 1.0, 0.0
    found = render(device, drawn, variant(slabs, precision))
    # A place is off by 1e-6, and with it the shares of both slabs; half floats round each sum.
    allowed = 3e-5 if precision == "float" else (2 * layers + 4) * 2.0**-10
    expected = model.depth_layered(drawn, BACKGROUND, slabs)
    np.testing.assert_allclose(found, expected, rtol=0, atol=allowed)


def test_one_slab_is_the_weighted_average_over_the_exact_transmittance(device: Device) -> None:
    lists = random_lists(12, tinted=True)
    color, opacity = layers_of(lists)
    passed = (1 - opacity).prod(axis=0)[..., None]
    mean = color.sum(axis=0) / opacity.sum(axis=0)[..., None]
    expected = mean * (1 - passed) + np.asarray(BACKGROUND) * passed
    np.testing.assert_allclose(render(device, lists, variant(1)), expected, rtol=0, atol=3e-6)


@pytest.mark.parametrize("slabs", SLABS)
def test_the_total_transmittance_is_exact(device: Device, slabs: int) -> None:
    lists = random_lists(30, side=8)
    lists = replace(
        lists, coverage=lists.coverage / np.float32(10), radiance=np.zeros_like(lists.radiance)
    )
    found = render(device, scene_of(lists, WHITE), variant(slabs))
    np.testing.assert_allclose(found, composite(lists, WHITE), rtol=0, atol=2e-6)


@pytest.mark.parametrize("slabs", SLABS)
@pytest.mark.parametrize("precision", ["half", "float"])
def test_all_variants_keep_their_promises(device: Device, slabs: int, precision: str) -> None:
    keeps_promises(device, variant(slabs, precision))


@pytest.mark.parametrize("coverage", [0.001, 0.3, 0.999, 1.0])
def test_a_single_layer_is_exact_at_every_coverage(device: Device, coverage: float) -> None:
    lists = stack([Layer(3, coverage, (0.9, 0.5, 30.0))], 2)
    found = render(device, lists, variant(8))
    np.testing.assert_allclose(found, composite(lists, BACKGROUND), rtol=1e-5, atol=1e-6)


def test_layers_in_slabs_of_their_own_are_exact(device: Device) -> None:
    lists = random_lists(4)
    exact = composite(lists, BACKGROUND)
    assert np.diff(np.sort(model.places(lists, 8)[:, 0, 0])).min() > 1
    np.testing.assert_allclose(render(device, lists, variant(8)), exact, rtol=0, atol=2e-6)
    assert abs(render(device, lists, variant(2)) - exact).max() > 0.05


def test_more_slabs_have_a_smaller_error(device: Device) -> None:
    lists = random_lists(20)
    exact = composite(lists, BACKGROUND)
    errors = [abs(render(device, lists, variant(slabs)) - exact).mean() for slabs in SLABS]
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < errors[0] / 2


def test_clear_glass_keeps_its_highlight_and_changes_no_bounds(device: Device) -> None:
    dark = [Layer(3, 0.5, GREEN), Layer(4, 0.5, BLUE)]
    glass = Layer(300, 1.0, WHITE, WHITE)
    alone = render(device, stack(dark, 2), variant(8))
    shown = render(device, stack([glass, *dark], 2), variant(8))
    # The last slab holds the glass beside the second layer, which does not hide it.
    np.testing.assert_allclose(shown - alone, 0.5, rtol=0, atol=1e-6)
    only = render(device, stack([glass], 2), variant(8))
    np.testing.assert_allclose(only[0, 0], np.add(BACKGROUND, 1), rtol=0, atol=1e-6)


def test_an_opaque_layer_shows_what_is_behind_it_in_its_slab(device: Device) -> None:
    front, close, far = Layer(2, 1.0, RED), Layer(2.01, 1.0, GREEN), Layer(8, 1.0, BLUE)
    assert "opaque_front_hides" not in method("depth_layered").promised
    found = render(device, scene_of(stack([far, close, front]), NOTHING), variant(8))[0, 0]
    assert found == pytest.approx([0.5, 0.5, 0.0], abs=1e-5)


def test_a_far_layer_stretches_all_slabs(device: Device) -> None:
    near = [Layer(1, 0.5, RED), Layer(2, 0.5, GREEN)]
    exact = render(device, scene_of(stack(near), NOTHING), variant(4))[0, 0]
    assert exact == pytest.approx([0.5, 0.25, 0], abs=1e-6)
    with_far = [*near, Layer(1e6, 0.01, NOTHING)]
    found = render(device, scene_of(stack(with_far), NOTHING), variant(4))[0, 0]
    assert found == pytest.approx([0.375, 0.375, 0], abs=1e-5)


def test_half_float_sums_of_many_layers_stall(device: Device) -> None:
    layers = [Layer(2, 1.0, RED)] * 1 + [Layer(2, 0.01, NOTHING)] * 5000
    white = scene_of(stack(layers, 1), NOTHING)
    half, single = (
        render(device, white, variant(1, precision))[0, 0, 0] for precision in ("half", "float")
    )
    assert single == pytest.approx(1 / 51, rel=1e-3)
    assert half > 1.2 * single


@pytest.mark.parametrize("slabs", SLABS)
def test_a_slab_has_ten_bytes_and_a_pixel_eight_for_bounds(device: Device, slabs: int) -> None:
    scene = scene_of(random_lists(1))
    assert bits_per_pixel(device, scene, variant(slabs, "half")) == 8 * (10 * slabs + 8)
    assert bits_per_pixel(device, scene, variant(slabs)) == 8 * (20 * slabs + 8)
