"""A bucket for faint front layers, and the rules of hybrid splats: where they help and fail."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from oitbench.gl.device import Device
from oitbench.measure.oracle import composite, transmittances
from oitbench.scene import FragmentLists
from tests.helpers import (
    BACKGROUND,
    BLUE,
    GREEN,
    NOTHING,
    RED,
    WHITE,
    Layer,
    assert_order_independent,
    method,
    opened,
    planned_bits,
    random_lists,
    render,
    scene_of,
    stack,
    tolerance,
)
from tests.models import bounded as model
from tests.models import commutative

BUCKETS = "multilayer_alpha_buckets"


def faded(lists: FragmentLists, factor: float) -> FragmentLists:
    return replace(lists, coverage=lists.coverage * np.float32(factor))


def test_among_strong_layers_a_bucket_is_a_node_less(device: Device) -> None:
    lists = random_lists(30)
    found = render(device, lists, f"{BUCKETS}[node=32f]")
    expected = model.multilayer_alpha(lists, BACKGROUND, 3, "32f")
    assert abs(expected - composite(lists, BACKGROUND)).max() > 0.05
    np.testing.assert_allclose(found, expected, rtol=0, atol=2e-6)


def test_two_faint_front_layers_take_no_other_node(device: Device) -> None:
    layers = [Layer(1, 0.1, RED), Layer(2, 0.1, BLUE), *[Layer(3 + i, 0.5, GREEN) for i in (0, 1)]]
    layers.append(Layer(5, 0.5, RED))
    lists, variant = stack(layers), f"{BUCKETS}[node=32f]"
    with opened(device, scene_of(lists), variant) as frame:
        frame.render(permutation=3)
        found = frame.image()
    np.testing.assert_allclose(found, composite(lists, BACKGROUND), rtol=0, atol=2e-6)


def test_the_depths_of_a_bucket_do_not_depend_on_the_order(device: Device) -> None:
    hidden = [Layer(6 + i, 0.5, BLUE) for i in range(6)]
    seen = [Layer(1, 0.1, RED), Layer(2, 0.5, GREEN), Layer(3, 0.1, BLUE), Layer(5, 1.0, WHITE)]
    lists = stack([*hidden, *seen[::-1]])
    with opened(device, scene_of(lists), f"{BUCKETS}[node=16f]") as frame:
        assert_order_independent(frame, 6)
        allowed = tolerance(method(f"{BUCKETS}[node=16f]"), 4, 1.0)
        assert abs(frame.image() - composite(lists, BACKGROUND)).max() <= allowed


def test_faint_layers_alone_merge_in_the_order_of_the_draws(device: Device) -> None:
    layers = [Layer(1, 0.1, RED), Layer(3, 0.1, GREEN), Layer(2, 0.1, BLUE)]
    scene = scene_of(stack(layers), NOTHING)
    found = render(device, scene, f"{BUCKETS}[node=32f]")[0, 0]
    assert found == pytest.approx([0.1, 0.09, 0.081], abs=1e-6)
    right = render(device, scene, "multilayer_alpha[node=32f]")[0, 0]
    assert right == pytest.approx([0.1, 0.081, 0.09], abs=1e-6)


def test_a_bucket_is_worse_than_no_bucket_on_smoke(device: Device) -> None:
    lists = faded(random_lists(40), 0.2)
    exact = composite(lists, BACKGROUND)
    errors, spreads = {}, {}
    for name in ("multilayer_alpha", BUCKETS):
        variant = f"{name}[k=4,node=32f]"
        pictures = [render(device, lists, variant, permutation=seed) for seed in range(6)]
        errors[name] = np.sqrt(np.mean((np.array(pictures) - exact) ** 2))
        spreads[name] = np.ptp(pictures, axis=0).mean()
    assert errors[BUCKETS] > 1.3 * errors["multilayer_alpha"]
    assert spreads[BUCKETS] > 1.3 * spreads["multilayer_alpha"]
    assert "order_independent" not in method(BUCKETS).promised


def test_layers_behind_a_nearly_opaque_one_do_not_attenuate(device: Device) -> None:
    scene = scene_of(stack([Layer(2, 0.5, NOTHING), Layer(1, 0.98, NOTHING)]), WHITE)
    assert "total_transmittance_exact" not in method(BUCKETS).promised
    found = render(device, scene, f"{BUCKETS}[node=32f]")[0, 0]
    assert found == pytest.approx([0.02] * 3, abs=1e-6)
    kept = render(device, scene, f"{BUCKETS}[node=32f,opaque=1]")[0, 0]
    assert kept == pytest.approx([0.01] * 3, abs=1e-6)


@pytest.mark.parametrize("rule", ["", ",admission=0.05"])
@pytest.mark.parametrize("k", [1, 4])
def test_the_transmittance_of_an_exact_tail_is_exact(device: Device, k: int, rule: str) -> None:
    lists = random_lists(40)
    strong = np.arange(40)[:, None, None] < 3
    coverage = np.broadcast_to(np.where(strong, 0.5, 0.01), lists.z.shape)
    lists = replace(lists, coverage=coverage.astype(np.float32))
    variant = f"hybrid[k={k},node=16f,transmittance=exact{rule}]"
    assert "total_transmittance_exact" in method(variant).promised
    with opened(device, scene_of(lists, WHITE), variant) as frame:
        frame.render(transmittance=True)
        found = frame.image()
    # Opacities are rounded when they are stored; the product itself is in single precision. But
    # blending rounds the opacity of all layers, and the color, to half floats.
    stored = (1 - model.stored_layers(lists, "16f")[..., 3:]).prod(axis=0)
    allowed = 2.0**-11 + 2.0**-13
    np.testing.assert_allclose(found, np.broadcast_to(stored, found.shape), rtol=0, atol=allowed)
    exact = transmittances(lists).prod(axis=0)
    np.testing.assert_allclose(found, exact, rtol=0, atol=allowed + 2.0**-13)
    black = replace(lists, radiance=np.zeros_like(lists.radiance))
    mean = render(device, scene_of(black, WHITE), f"hybrid[k={k},node=16f]")
    assert (mean > 1.02 * found).mean() > 0.5


def test_hybrid_with_one_node_is_an_exact_front_layer_and_a_weighted_tail(device: Device) -> None:
    lists = random_lists(12)
    near = lists.z == lists.z.min(axis=0)
    front = replace(lists, coverage=np.where(near, lists.coverage, 0))
    behind = replace(lists, coverage=np.where(near, 0, lists.coverage))
    tail = commutative.weighted_average(behind, BACKGROUND)
    expected = composite(front, tail)
    found = render(device, lists, "hybrid[k=1,node=16f]")
    np.testing.assert_allclose(found, expected, rtol=0, atol=6e-3)


def test_a_layer_that_is_not_admitted_lies_behind_the_core(device: Device) -> None:
    scene = scene_of(stack([Layer(2, 0.5, RED), Layer(1, 0.04, BLUE)]), NOTHING)
    found = render(device, scene, "hybrid[node=16f,admission=0.05]")[0, 0]
    assert found == pytest.approx([0.5, 0, 0.02], abs=1e-3)
    assert "two_layers_ordered" not in method("hybrid[admission=0.05]").promised
    all_admitted = render(device, scene, "hybrid[node=16f]")[0, 0]
    assert all_admitted == pytest.approx([0.48, 0, 0.04], abs=1e-3)


def test_an_exact_tail_has_a_wider_transmittance() -> None:
    sizes = [
        planned_bits(f"hybrid[k=4{rule}]", "framebuffer fetch")
        for rule in ("", ",transmittance=exact", ",transmittance=exact,admission=0.05")
    ]
    assert sizes == [64 * 4 + 80, 64 * 4 + 96, 64 * 4 + 96]
