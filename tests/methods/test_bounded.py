"""Methods with k nodes per pixel against their models, in both ways of blending."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from oitbench.errors import CapabilityError
from oitbench.gl.device import Device
from oitbench.gl.plan import FramePlan
from oitbench.measure.oracle import composite, transmittances
from oitbench.method.kits.bounded_nodes import STEPS
from oitbench.scene import Floats, FragmentLists
from tests.helpers import (
    BACKGROUND,
    BLUE,
    GREEN,
    NOTHING,
    RED,
    WHITE,
    Layer,
    assert_order_independent,
    assert_same,
    bits_per_pixel,
    keeps_promises,
    method,
    opened,
    planned_bits,
    random_lists,
    render,
    rounding,
    scene_of,
    stack,
    tolerance,
)
from tests.models import bounded as model

MODELS: dict[str, Callable[..., Floats]] = {
    "k_buffer": model.k_buffer,
    "multilayer_alpha": model.multilayer_alpha,
    "multilayer_alpha_buckets": model.multilayer_alpha_buckets,
    "hybrid": model.hybrid,
}
"""Models take lists, the background, and the parameters of their methods."""
MOST = {"8-bit": 16, "16f": 8, "32f": 4}
"""Nodes of each format that fit into eight targets."""
VARIANTS = [
    f"{name}[k={k},node={node}]"
    for name in MODELS
    for node, most in MOST.items()
    for k in (1, 2, 4, 8, 16)
    if k <= most
    if name in ("k_buffer", "hybrid") or k > 1
    if name != "hybrid" or (k < 16 and node != "32f")
]
ADMITTING = (
    "hybrid[k=1,transmittance=exact]",
    "hybrid[k=2,node=16f,transmittance=exact,admission=0.4]",
    "hybrid[k=4,admission=0.3]",
    "multilayer_alpha_buckets[k=4,node=16f,lower=0.5,opaque=0.7]",
)
"""Variants with other rules of which layers a node may hold."""
LOCK, FILL_COUNT = 32, 32
"""Bits per pixel of the spin lock, and of the node count of the published k+-buffer."""


@dataclass(frozen=True)
class Shown:
    """Lists with a short representation for failing tests."""

    lists: FragmentLists

    def __repr__(self) -> str:
        return f"{len(self.lists.z)} layers"


def mixed(count: int, seed: int, tinted: bool, ties: bool, gaps: bool) -> FragmentLists:
    """Return lists with a different order in each pixel, optionally with ties or missing layers."""
    lists = random_lists(count, tinted=tinted, seed=seed)
    random = np.random.default_rng(seed)
    z = random.permuted(lists.z, axis=0)
    shown = random.random(z.shape) < (0.7 if gaps else 1.0)
    coverage = np.where(shown, lists.coverage, 0).astype(np.float32)
    return replace(lists, z=np.ceil(z) if ties else z, coverage=coverage)


drawn = st.builds(
    mixed,
    count=st.integers(1, 20),
    seed=st.integers(0, 2**32 - 1),
    tinted=st.booleans(),
    ties=st.booleans(),
    gaps=st.booleans(),
).map(Shown)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(shown=drawn, variant=st.sampled_from([*VARIANTS, *ADMITTING]))
def test_pictures_follow_the_model(device: Device, shown: Shown, variant: str) -> None:
    chosen = method(variant)
    node = str(chosen.values["node"])
    values = {name: value for name, value in chosen.values.items() if name != "msaa"}
    expected = MODELS[chosen.name](shown.lists, BACKGROUND, **values)
    error = abs(render(device, shown.lists, variant) - expected)
    # Half floats round the background, its product and the sum. Near half a step of a node, single
    # precision may round to the other step.
    allowed = 2e-6 if node == "32f" else 3 * 2.0**-11
    assert (error <= allowed).mean() > 0.99
    assert error.max() <= allowed + 2 * STEPS[node]


@pytest.mark.parametrize("variant", VARIANTS)
def test_a_spin_lock_gives_the_same_picture_as_the_best_mechanism(
    device: Device, variant: str
) -> None:
    chosen, lists = method(variant), random_lists(20, tinted=True)
    written = FramePlan.of(chosen, (1, 1), chosen.shows, mechanism="spin lock").targets
    if len(written) > device.max_images:
        with pytest.raises(CapabilityError, match=r"writes \d+ targets; .* allows"):
            render(device, lists, chosen, mechanism="spin lock")
        return
    best = render(device, lists, chosen)
    locked = render(device, lists, chosen, mechanism="spin lock")
    if device.software or "order_independent" in chosen.promised:
        assert_same(device, locked, best, variant, 20)


@pytest.mark.parametrize("variant", VARIANTS)
def test_up_to_k_layers_are_exact_in_any_order(device: Device, variant: str) -> None:
    chosen = method(variant)
    # Of the nodes with a bucket, one is kept for faint layers, and here none is faint.
    count = int(chosen.values["k"]) - (chosen.name == "multilayer_alpha_buckets")
    lists = random_lists(count)
    with opened(device, scene_of(lists), variant) as frame:
        assert_order_independent(frame, 3)
        error = abs(frame.image() - composite(lists, BACKGROUND))
        assert error.max() <= tolerance(chosen, count, 1.0)


@pytest.mark.parametrize("variant", ["k_buffer[k=4]", "k_buffer[k=8,node=16f]"])
def test_a_k_buffer_shows_the_nearest_layers_in_any_order(device: Device, variant: str) -> None:
    chosen, lists = method(variant), random_lists(30)
    k = int(chosen.values["k"])
    rank = lists.z.argsort(axis=0).argsort(axis=0)
    nearest = replace(lists, coverage=np.where(rank < k, lists.coverage, 0))
    expected = composite(nearest, BACKGROUND)
    assert abs(expected - composite(lists, BACKGROUND)).max() > 0.01
    with opened(device, scene_of(lists), variant) as frame:
        assert_order_independent(frame, 5)
        assert abs(frame.image() - expected).max() <= tolerance(chosen, k, 1.0)


@pytest.mark.parametrize("variant", ["hybrid", "hybrid[k=2,node=16f]"])
def test_the_order_changes_a_tail_by_at_most_its_rounding(device: Device, variant: str) -> None:
    lists = random_lists(30)
    pictures = [render(device, lists, variant, permutation=seed) for seed in range(5)]
    assert np.ptp(pictures, axis=0).max() <= rounding(method(variant), 30, 0.1)


def test_variants_with_few_nodes_keep_their_promises(device: Device) -> None:
    keeps_promises(
        device,
        "k_buffer[k=1]",
        "k_buffer[k=2,node=16f]",
        "k_buffer[k=4,node=32f]",
        "multilayer_alpha[k=2]",
        "multilayer_alpha[k=2,node=16f]",
        "multilayer_alpha_buckets[k=2]",
        "multilayer_alpha_buckets[k=2,node=16f]",
        "hybrid[k=1]",
        "hybrid[k=2]",
        "hybrid[k=2,node=16f]",
        "hybrid[transmittance=exact]",
        "hybrid[k=2,node=16f,transmittance=exact,admission=0.05]",
    )


def spread(device: Device, lists: FragmentLists, variant: str) -> float:
    pictures = [render(device, lists, variant, permutation=seed) for seed in range(8)]
    return float(np.ptp(pictures, axis=0).mean())


def test_more_nodes_reduce_the_dependence_of_merging_on_the_order(device: Device) -> None:
    lists = random_lists(24)
    found = [spread(device, lists, f"multilayer_alpha[k={k},node=8-bit]") for k in (2, 4, 8, 16)]
    assert found == sorted(found, reverse=True)
    assert found[0] > 0.05
    assert found[-1] < 0.01


@pytest.mark.parametrize(("node", "allowed"), [("32f", 1e-6), ("16f", 2e-3), ("8-bit", 8e-3)])
def test_a_layer_that_is_merged_late_does_not_hide_farther_layers(
    device: Device, node: str, allowed: float
) -> None:
    variant = f"multilayer_alpha[k=2,node={node}]"
    early = [Layer(1, 0.1, RED), Layer(3, 0.1, RED)]
    green, blue = Layer(4, 0.9, GREEN), Layer(5, 0.9, BLUE)
    wrong, right = (0.19, 0.073, 0.729), (0.19, 0.729, 0.073)
    for layers, expected in (
        ([*early, blue, green], wrong),
        ([*early, green, blue], right),
        ([blue, green, *early[::-1]], right),
    ):
        found = render(device, scene_of(stack(layers), NOTHING), variant)[0, 0]
        assert found == pytest.approx(expected, abs=allowed + 5e-4)


def test_a_merged_layer_shows_through_a_nearer_opaque_one(device: Device) -> None:
    layers = [
        Layer(1.0, 0.5, NOTHING),
        Layer(10.0, 0.5, WHITE),
        Layer(2.0, 0.5, NOTHING),
        Layer(5.0, 1.0, NOTHING),
    ]
    scene = scene_of(stack(layers), NOTHING)
    assert "opaque_front_hides" not in method("multilayer_alpha").promised
    leak = render(device, scene, "multilayer_alpha[k=2,node=32f]")[0, 0]
    assert leak == pytest.approx([0.125] * 3, abs=1e-6)
    for variant in ("multilayer_alpha", "k_buffer[k=2]", "hybrid[k=4]", "k_buffer[k=4,node=16f]"):
        assert not render(device, scene, variant).any()


@pytest.mark.parametrize("k", [2, 4])
def test_the_total_transmittance_of_merged_layers_is_exact(device: Device, k: int) -> None:
    lists = random_lists(40)
    lists = replace(lists, coverage=lists.coverage * np.float32(0.2))
    found = []
    with opened(device, scene_of(lists, WHITE), f"multilayer_alpha[k={k},node=32f]") as frame:
        for seed in (None, 1, 2):
            frame.render(transmittance=True, permutation=seed)
            found.append(frame.image())
    expected = transmittances(lists).prod(axis=0)
    for picture in found:
        np.testing.assert_allclose(picture, expected, rtol=0, atol=2e-6)


@pytest.mark.parametrize("k", [2, 4])
def test_merging_is_exact_for_white_furnaces_and_for_copies(device: Device, k: int) -> None:
    variant = f"multilayer_alpha[k={k},node=32f]"
    lists = random_lists(20)
    white = replace(lists, radiance=np.ones_like(lists.radiance))
    np.testing.assert_allclose(render(device, scene_of(white, WHITE), variant), 1, atol=2e-6)
    copies = render(device, scene_of(stack([Layer(3.0, 0.1, RED)] * 20), NOTHING), variant)
    assert copies[0, 0] == pytest.approx([1 - 0.9**20, 0, 0], abs=2e-6)


@pytest.mark.parametrize("far_first", [True, False])
@pytest.mark.parametrize(
    ("node", "total"), [("8-bit", (0.49, 0.49)), ("16f", (0.547, 0.549)), ("32f", (0.548, 0.5484))]
)
def test_merging_two_hundred_faint_layers_is_inaccurate_in_bytes(
    device: Device, node: str, total: tuple[float, float], far_first: bool
) -> None:
    layers = [Layer(float(z), 0.003, NOTHING) for z in np.linspace(2, 9, 200)]
    lists = stack(layers[::-1] if far_first else layers, side=4)
    variant = f"multilayer_alpha[k=4,node={node}]"
    found = render(device, scene_of(lists, WHITE), variant)[0, 0, 0]
    assert found == pytest.approx(
        model.multilayer_alpha(lists, WHITE, 4, node)[0, 0, 0], abs=2.0**-10
    )
    assert total[0] - 5e-3 <= found <= total[1] + 5e-3


def test_layers_below_half_a_step_of_a_byte_are_lost(device: Device) -> None:
    thin = stack([Layer(2.0, 0.9 / 510, WHITE)])
    for name in MODELS:
        assert not render(device, scene_of(thin, NOTHING), f"{name}[k=4,node=8-bit]").any()
        assert render(device, scene_of(thin, NOTHING), f"{name}[k=4,node=16f]").all()


def test_the_tail_of_hybrid_transparency_transmits_too_much(device: Device) -> None:
    layers = [Layer(1.0, 0.5, NOTHING), Layer(2.0, 0.5, NOTHING)]
    tail = [Layer(3.0, 0.8, NOTHING), Layer(4.0, 0.2, NOTHING)]
    found = render(device, scene_of(stack([*tail, *layers]), WHITE), "hybrid[k=2,node=16f]")[0, 0]
    assert found == pytest.approx([0.25 * 0.5**2] * 3, abs=1e-3)
    assert found[0] > 0.25 * 0.2 * 0.8 + 0.02


@pytest.mark.parametrize("variant", VARIANTS)
def test_each_node_has_a_depth_and_a_color(variant: str) -> None:
    chosen = method(variant)
    color = {"8-bit": 32, "16f": 64, "32f": 128}[str(chosen.values["node"])]
    beside = {"hybrid": 64 + 16, "multilayer_alpha_buckets": 64}.get(chosen.name, 0)
    expected = int(chosen.values["k"]) * (32 + color) + beside
    assert planned_bits(variant, "framebuffer fetch") == expected
    assert planned_bits(variant, "interlock") == expected
    assert planned_bits(variant, "spin lock") == expected + LOCK


@pytest.mark.parametrize("name", MODELS)
def test_frames_have_the_planned_bits(device: Device, name: str) -> None:
    expected = planned_bits(name, device.mechanism(1))
    assert bits_per_pixel(device, scene_of(random_lists(1)), name) == expected


def test_pixels_have_the_published_bits() -> None:
    """McGuire & Mara 2017, section 8.1: 256 for multi-layer alpha, 128 to 320 for the k+-buffer."""
    assert planned_bits("multilayer_alpha[k=4]", "framebuffer fetch") == 256
    published = [planned_bits(f"k_buffer[k={k}]", "spin lock") + FILL_COUNT for k in (1, 4)]
    assert published == [128, 320]


def test_more_nodes_than_targets_are_refused(device: Device) -> None:
    refused = pytest.raises(CapabilityError, match=r"insert\.glsl writes 12 targets; .* allows 8")
    with refused, opened(device, scene_of(random_lists(1)), "k_buffer[k=16,node=16f]"):
        pass
