"""The double-precision oracle against hand examples, a closed form and a direct product."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.measure.oracle import composite, transmittances
from oitbench.scene import RGB, Floats, FragmentLists
from tests.helpers import BLUE, GREEN, NOTHING, RED, WHITE, Layer, random_lists, stack


def one(layers: list[Layer], background: RGB = NOTHING) -> list[float]:
    found = composite(stack(layers, side=1), background)
    assert found.shape == (1, 1, 3)
    return [float(value) for value in found[0, 0]]


def direct_product(lists: FragmentLists, background: RGB) -> Floats:
    """Return Σ αL Π τ + C0 Π τ, with a separate product for each fragment."""
    factor = transmittances(lists)
    total = np.asarray(background) * factor.prod(axis=0)
    for i in range(len(lists.z)):
        nearer = (lists.z < lists.z[i])[..., None]
        visible = np.where(nearer, factor, 1.0).prod(axis=0)
        total = total + lists.coverage[i, ..., None].astype(float) * lists.radiance[i] * visible
    return np.asarray(total)


def test_two_layers_over_a_background_equal_a_hand_example() -> None:
    layers = [Layer(1, 0.45, RED), Layer(2, 0.45, GREEN)]
    assert one(layers, BLUE) == pytest.approx([0.45, 0.2475, 0.3025], abs=1e-7)


def test_the_order_of_the_list_does_not_matter() -> None:
    layers = [Layer(3, 0.5, RED), Layer(1, 0.25, GREEN), Layer(2, 0.75, WHITE)]
    assert one(layers, BLUE) == one(layers[::-1], BLUE)


def test_glass_tints_the_background() -> None:
    glass = Layer(1, 1.0, NOTHING, transmission=(0.5, 0.25, 0.0))
    assert one([glass], WHITE) == pytest.approx([0.5, 0.25, 0.0])


def test_coverage_mixes_tinted_and_untinted_light() -> None:
    glass = Layer(1, 0.5, (0.2, 0.0, 0.0), transmission=(1.0, 0.5, 0.0))
    assert one([glass], WHITE) == pytest.approx([0.1 + 1.0, 0.75, 0.5])


def test_identical_layers_follow_the_geometric_sum() -> None:
    count, alpha = 9, 0.25
    passed = (1 - alpha) ** count
    expected = [radiance * (1 - passed) + 0.5 * passed for radiance in (1.0, 0.5, 0.25)]
    layers = [Layer(1, alpha, (1.0, 0.5, 0.25))] * count
    assert one(layers, (0.5, 0.5, 0.5)) == pytest.approx(expected, rel=1e-12)


def test_random_lists_equal_the_direct_product() -> None:
    for seed in range(4):
        lists = random_lists(12, tinted=True, seed=seed)
        background = (0.35, 0.6, 0.85)
        np.testing.assert_allclose(
            composite(lists, background), direct_product(lists, background), rtol=0, atol=1e-13
        )


def test_fragments_of_equal_distance_are_ordered_by_color() -> None:
    bright, dark = Layer(1, 1.0, WHITE), Layer(1, 0.5, NOTHING)
    # The darker one counts as nearer.
    assert one([bright, dark]) == one([dark, bright]) == pytest.approx([0.5, 0.5, 0.5])
