"""Moments against their model, where they are exact, and where they degenerate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest

from oitbench.gl.capabilities import SPIN_LOCK
from oitbench.gl.device import Device
from oitbench.measure.oracle import composite
from oitbench.modeling.mesh import quad
from oitbench.scene import Camera, Floats, FragmentLists, Material, Object, Scene
from oitbench.stability.cases import cases
from oitbench.stability.result import BREAKS
from tests.helpers import (
    BACKGROUND,
    BLUE,
    GREEN,
    RED,
    WHITE,
    Layer,
    bits_per_pixel,
    method,
    opened,
    random_lists,
    render,
    run_checks,
    scene_of,
    stack,
)
from tests.models import moments as model

BASES = ("power", "trigonometric")
COUNTS = (4, 6, 8)
STORAGES = ("float", "unorm16")
NEAR = 0.9
"""Near plane, meters: just before the nearest layer, so that window depth spreads the others."""


def places(z: npt.NDArray[np.float32], depth: str) -> Floats:
    """Return places in [-1, 1] of distances of lists, (n, h, w)."""
    exact = z.astype(np.float64)
    low, high = exact.min(axis=0), exact.max(axis=0)
    if depth == "log":
        return np.asarray(2 * np.log(exact / low.min()) / np.log(high.max() / low.min()) - 1)
    if depth == "linear":
        return np.asarray(2 * (exact - low) / (high - low) - 1)
    return np.asarray(2 * (1 - NEAR / exact) - 1)


def scattered(layers: int, side: int = 6) -> FragmentLists:
    drawn = random_lists(layers, side=side, seed=layers)
    drawn.z[:] = np.random.default_rng(layers).uniform(1, 9, drawn.z.shape)
    return drawn


@pytest.mark.parametrize("layers", [4, 12])
@pytest.mark.parametrize("depth", ["log", "linear", "window"])
@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("basis", BASES)
def test_pictures_follow_the_model(
    device: Device, basis: str, count: int, depth: str, layers: int
) -> None:
    drawn = scattered(layers)
    alpha = drawn.coverage.astype(np.float64)
    name = f"moments[basis={basis},count={count},depth={depth},overestimation=0.1]"
    where = places(drawn.z, depth)
    colors = alpha[..., None] * drawn.radiance
    expected = model.composite(where, colors, alpha, BACKGROUND, basis, count, overestimation=0.1)
    found = render(device, scene_of(drawn, BACKGROUND, NEAR), name)
    error = abs(found - expected).max(axis=-1)
    # Single precision only matters where layers are close to each other.
    assert np.median(error) < 1e-4
    assert error.max() < 1e-2


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("basis", BASES)
def test_sixteen_bits_follow_the_model_with_their_own_bias(
    device: Device, basis: str, count: int
) -> None:
    drawn = scattered(12)
    alpha = drawn.coverage.astype(np.float64)
    colors = alpha[..., None] * drawn.radiance
    where = places(drawn.z, "log")
    found = render(device, drawn, f"moments[basis={basis},count={count},storage=unorm16]")
    own, other = (
        np.median(abs(found - model.composite(where, colors, alpha, BACKGROUND, basis, count, s)))
        for s in ("unorm16", "float")
    )
    assert own < 1e-4
    assert other > 1.5 * own


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("basis", BASES)
def test_stored_moments_fill_the_unit_interval(basis: str, count: int) -> None:
    stored = model.quantized(np.linspace(-1, 1, 200_001), basis, count)
    np.testing.assert_allclose(stored.min(axis=0), 0, rtol=0, atol=2e-8)
    # Angles leave a gap, in which the highest sine would have its greatest value.
    np.testing.assert_allclose(stored.max(axis=0), 1, rtol=0, atol=2e-8)


def sixteen_bits(
    device: Device, drawn: FragmentLists, basis: str, count: int, mechanism: str | None = None
) -> Floats:
    """Return the stored moments of each pixel, shape (h, w, count), in [0, 1]."""
    name = f"moments[basis={basis},count={count},storage=unorm16]"
    scene = scene_of(drawn, BACKGROUND, NEAR)
    with opened(device, scene, name, mechanism=mechanism) as frame:
        frame.render()
        words = np.concatenate([frame.texels(f"words{i}") for i in range(count // 2)], axis=-1)
    stored = np.stack([words & 0xFFFF, words >> 16], axis=-1)
    return np.asarray(stored.reshape(*words.shape[:2], count) / 65535)


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("basis", BASES)
def test_sixteen_bits_hold_the_mean_moments(device: Device, basis: str, count: int) -> None:
    drawn = scattered(5, side=16)
    absorbance = -np.log1p(-drawn.coverage.astype(np.float64))[..., None]
    each = model.quantized(places(drawn.z, "log"), basis, count)
    mean = (each * absorbance).sum(axis=0) / absorbance.sum(axis=0)
    stored = sixteen_bits(device, drawn, basis, count)
    # Every fragment rounds once.
    np.testing.assert_allclose(stored, mean, rtol=0, atol=5 / 65535)


@pytest.mark.parametrize("basis", BASES)
def test_a_spin_lock_gives_the_same_moments(device: Device, basis: str) -> None:
    layers, count = 8, 6
    drawn = scattered(layers, side=16)
    best = sixteen_bits(device, drawn, basis, count)
    locked = sixteen_bits(device, drawn, basis, count, SPIN_LOCK)
    # GPUs take the fragments of a pixel in another order, and each rounds once, in both.
    allowed = 0.0 if device.software else layers / 65535
    np.testing.assert_allclose(locked, best, rtol=0, atol=allowed)


ALLOWED = {("power", 4): 1e-4, ("power", 6): 1e-2, ("power", 8): 1e-2}


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("basis", BASES)
def test_half_as_many_layers_as_moments_are_exact(device: Device, basis: str, count: int) -> None:
    for layers in range(1, count // 2 + 1):
        drawn = random_lists(layers, side=16)
        drawn.z[:] = np.linspace(1.2, 8, layers)[:, None, None]
        # The scene's range is wider than that of the pixels.
        drawn.z[0, 0, 0], drawn.z[-1, 1, 1] = 1.0, 9.0
        found = render(device, drawn, f"moments[basis={basis},count={count},overestimation=0]")
        error = abs(found - composite(drawn, BACKGROUND)).max()
        assert error < ALLOWED.get((basis, count), 1e-4), layers


@pytest.mark.parametrize("storage", STORAGES)
@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("basis", BASES)
def test_layers_at_one_place_are_averaged_by_their_opacity(
    device: Device, basis: str, count: int, storage: str
) -> None:
    # The moments of one place are degenerate: pivots are zero but for rounding.
    name = f"moments[basis={basis},count={count},storage={storage},overestimation=0]"
    random = np.random.default_rng(count)
    for layers in (1, 2, 3):
        drawn = random_lists(layers, side=48)
        drawn.z[:] = np.geomspace(0.2, 200, 48 * 48).reshape(48, 48)[random.permutation(48)]
        alpha = drawn.coverage[..., None].astype(np.float64)
        mean = (alpha * drawn.radiance).sum(axis=0) / alpha.sum(axis=0)
        passed = np.prod(1 - alpha, axis=0)
        found = render(device, drawn, name)
        np.testing.assert_allclose(
            found, mean * (1 - passed) + passed * np.asarray(BACKGROUND), rtol=0, atol=2e-6
        )


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("basis", BASES)
def test_a_decal_and_its_wall_hide_layers_behind_them(
    device: Device, basis: str, count: int
) -> None:
    # Three layers at two places.
    drawn = random_lists(3, side=48)
    drawn.z[:2] = np.geomspace(1, 3, 48 * 48).reshape(48, 48)
    drawn.z[2] = 2.5 * drawn.z[0]
    drawn.radiance[:2] = 0
    found = render(device, drawn, f"moments[basis={basis},count={count},overestimation=0]")
    exact = composite(drawn, BACKGROUND)
    # The far layer's part depends on the weights of all; coplanar layers keep theirs.
    alpha = drawn.coverage.astype(np.float64)
    passed = (1 - alpha[0]) * (1 - alpha[1])
    weight = alpha[0] + alpha[1] + alpha[2] * passed
    hidden = 1 - passed * (1 - alpha[2])
    part = (alpha[2] * passed / weight * hidden)[..., None] * drawn.radiance[2]
    expected = part + (1 - hidden)[..., None] * np.asarray(BACKGROUND)
    np.testing.assert_allclose(found, expected, rtol=0, atol=5e-3)
    assert abs(exact - expected).max() < 0.3


@pytest.mark.parametrize("depth", ["log", "window"])
@pytest.mark.parametrize("storage", STORAGES)
@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("basis", BASES)
def test_clusters_of_any_width_and_strength_give_finite_pixels(
    device: Device, basis: str, count: int, storage: str, depth: str
) -> None:
    random = np.random.default_rng(count)
    drawn = random_lists(6, side=64)
    centers = random.uniform(1, 9, (2, 1, 64, 64))
    centers = np.where(random.random((6, 64, 64)) < 0.5, centers[0], centers[1])
    width = 10 ** random.uniform(-9, -1, (64, 64)) * (random.random((64, 64)) < 0.8)
    drawn.z[:] = centers * (1 + width * random.standard_normal((6, 64, 64)))
    drawn.coverage[:] = np.minimum(10 ** random.uniform(-6, 0.2, drawn.z.shape), 1)
    drawn.radiance[:] = 1
    name = f"moments[basis={basis},count={count},storage={storage},depth={depth}]"
    found = render(device, scene_of(drawn, WHITE), name)
    # The picture is white only if all weights are numbers.
    np.testing.assert_allclose(found, 1, rtol=0, atol=2e-4)


def test_overestimation_adds_a_part_of_the_own_weight(device: Device) -> None:
    layers = [Layer(1.0, 0.5, WHITE), Layer(3.0, 0.5, RED), Layer(9.0, 0.5, BLUE)]
    pictures = [
        render(device, stack(layers, 2), f"moments[overestimation={part}]")[0, 0]
        for part in (0.0, 0.5, 1.0)
    ]
    # With the whole weight, every layer is hidden by itself: 1/2, 1/4 and 1/8.
    for picture, part in zip(pictures, (0.0, 0.5, 1.0), strict=True):
        seen = 0.5 ** (np.arange(3) + part)
        light = (seen[:, None] * [WHITE, RED, BLUE]).sum(axis=0) / seen.sum()
        np.testing.assert_allclose(
            picture, light * 7 / 8 + np.asarray(BACKGROUND) / 8, rtol=0, atol=1e-3
        )


def test_weights_of_many_opaque_layers_do_not_vanish(device: Device) -> None:
    # Every layer is hidden by an absorbance of 575, whose transmittance no float holds; opaque
    # ones count as transmitting 1e-5.
    walls = stack([Layer(2.0, 1.0, WHITE)] * 50, 2)
    found = render(device, walls, "moments[overestimation=1]")
    np.testing.assert_allclose(found, 1, rtol=0, atol=2e-5)


HARD = ("1 mm to 1000 km", "3000 white walls", "coincident colors", "swept layer", "α = 0")


@pytest.mark.parametrize("depth", ["log", "linear", "window"])
@pytest.mark.parametrize("storage", STORAGES)
@pytest.mark.parametrize("basis", BASES)
def test_no_pixel_of_the_hard_cases_is_nan(
    device: Device, basis: str, storage: str, depth: str
) -> None:
    methods = [
        method(f"moments[basis={basis},count={count},storage={storage},depth={depth}]")
        for count in COUNTS
    ]
    chosen = [replace(check, repeat=False) for check in cases() if check.name in HARD]
    found = run_checks(device, methods, chosen)
    assert len(found) == len(methods) * len(HARD)
    assert [(item.method, item.check) for item in found if item.failed] == []


def test_the_range_is_that_of_transparent_geometry(device: Device) -> None:
    # An opaque wall far behind must not change the places of layers; one more pane must.
    panes = [
        Object(f"pane {z}", quad((0, 0, -z), (9, 0, 0), (0, 9, 0)), Material(0.5, emission=color))
        for z, color in ((1.0, RED), (2.0, GREEN), (3.0, WHITE), (3.5, BLUE), (4.0, RED))
    ]
    wall = Object("wall", quad((0, 0, -900), (9e3, 0, 0), (0, 9e3, 0)), Material(emission=GREEN))
    aside = Object("aside", quad((0, 90, -400), (1, 0, 0), (0, 1, 0)), Material(0.5))
    pictures = [
        render(
            device,
            Scene("panes", Camera((0, 0, 0), (0, 0, -1)), tuple(items), background=GREEN),
            "moments[basis=trigonometric]",
            size=(8, 8),
        )
        for items in (panes, [*panes, wall], [*panes, aside])
    ]
    np.testing.assert_allclose(pictures[1], pictures[0], atol=1e-6)
    assert abs(pictures[2] - pictures[0]).max() > 1e-3


def test_clear_layers_stretch_the_scene_s_range_but_not_a_pixel_s(device: Device) -> None:
    drawn = [Layer(2.0 + i, 0.4, RED if i % 2 else WHITE) for i in range(6)]
    clear = [Layer(0.2, 0.0), Layer(300.0, 0.0)]
    for depth, promised in (("log", False), ("linear", True), ("window", True)):
        name = f"moments[depth={depth}]"
        assert ("zero_coverage_ignored" in method(name).promised) is promised
        alone, stretched = (render(device, stack(item, 2), name) for item in (drawn, drawn + clear))
        assert np.array_equal(alone, stretched) is promised


def test_layers_beyond_half_the_moments_show_through(device: Device) -> None:
    drawn = stack([Layer(z, 0.6, c) for z, c in ((1, RED), (2, GREEN), (4, BLUE), (8, WHITE))], 2)
    few, many = (
        abs(render(device, drawn, f"moments[count={count}]") - composite(drawn, BACKGROUND)).max()
        for count in (4, 8)
    )
    assert few > 0.02 > many


@pytest.mark.parametrize("basis", BASES)
@pytest.mark.parametrize(
    ("count", "storage", "moments"),
    [
        (4, "float", 20),
        (6, "float", 28),
        (8, "float", 36),
        (4, "unorm16", 12),
        (6, "unorm16", 16),
        (8, "unorm16", 20),
    ],
)
def test_moments_have_the_published_memory(
    device: Device, basis: str, count: int, storage: str, moments: int
) -> None:
    scene = scene_of(random_lists(1))
    name = f"moments[basis={basis},count={count},storage={storage}"
    bits = bits_per_pixel(device, scene, f"{name}]")
    lock = 32 if storage == "unorm16" and device.mechanism(1) == SPIN_LOCK else 0
    assert bits - lock == 8 * (moments + 16)
    assert bits_per_pixel(device, scene, f"{name},depth=linear]") == bits + 64


FAILURES = {
    # More places than half the moments, and the layers' own weight, of which a part hides them.
    "moments": {
        "near opaque",
        "1 mm to 1000 km",
        "middle layer from 0 to 1",
        "late arrival",
        "64 layers",
        "strong before many",
        "crossing boxes",
    }
}
FAILURES["moments[storage=unorm16]"] = FAILURES["moments"] | {"two halves"}


@pytest.mark.parametrize("name", FAILURES)
def test_the_hard_cases_that_break_are_known(device: Device, name: str) -> None:
    found = run_checks(device, [method(name)], [replace(check, repeat=False) for check in cases()])
    assert {item.check for item in found if item.status == BREAKS} == FAILURES[name]
