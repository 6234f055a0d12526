"""Maps of absorbance and wavelets against their models, and their published memory.

Published sizes are those of Salvi et al. 2011, "Adaptive Transparency", for 1280×720 pixels.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from oitbench.gl.device import Device
from oitbench.measure import accounting
from oitbench.measure.oracle import composite, transmittances
from oitbench.modeling.mesh import quad
from oitbench.scene import Camera, FragmentLists, Material, Object, Scene
from oitbench.scene.vectors import Floats
from tests.helpers import (
    BACKGROUND,
    NOTHING,
    Layer,
    bits_per_pixel,
    opened,
    random_lists,
    render,
    scene_of,
    stack,
    takes_any_order,
)
from tests.models import absorbance as model

MEMORIES = ("node=precise", "memory=fixed")
CURVES = {
    "opacity_map[slices=4": model.opacity_map(4),
    "opacity_map[slices=16": model.opacity_map(16),
    "opacity_map[slices=32": model.opacity_map(32),
    "fourier_map[coefficients=7": model.fourier_map(7, False),
    "fourier_map[coefficients=15": model.fourier_map(15, False),
    "fourier_map[coefficients=31,lanczos=true": model.fourier_map(31, True),
}
WAVELETS = {
    "wavelet[rank=1": model.wavelet(1),
    "wavelet[rank=2,correction=false": model.wavelet(2, False),
    "wavelet[rank=3": model.wavelet(3),
}
MARGINS = (1e-5, 1e-2)
DEFAULTS = ("opacity_map[slices=16", "fourier_map[coefficients=15")
PIXELS_720P = 1280 * 720
MIB = 2**20


def expected(drawn: FragmentLists, curve: str, tinted: bool, normalized: bool = False) -> Floats:
    factors = transmittances(drawn)
    wavelet = curve in WAVELETS
    return model.composite(
        drawn.z.astype(np.float64),
        drawn.coverage[..., None].astype(np.float64) * drawn.radiance,
        factors if tinted else factors.mean(axis=-1, keepdims=True),
        BACKGROUND,
        (WAVELETS if wavelet else CURVES)[curve],
        normalized,
        MARGINS if wavelet else (0.0, 0.0),
    )


@settings(max_examples=16, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 2**32 - 1),
    layers=st.integers(1, 20),
    curve=st.sampled_from(sorted({**CURVES, **WAVELETS})),
    channels=st.sampled_from(["gray", "rgb"]),
    memory=st.sampled_from(["memory=variable,node=precise", "memory=fixed"]),
    normalized=st.booleans(),
)
def test_pictures_follow_the_model(
    device: Device,
    seed: int,
    layers: int,
    curve: str,
    channels: str,
    memory: str,
    normalized: bool,
) -> None:
    random = np.random.default_rng(seed)
    drawn = random_lists(layers, tinted=True, seed=seed, side=8)
    # Random distances keep layers away from the edges of slices. Some layers are clear or opaque.
    drawn.z[:] = random.uniform(1, 9, drawn.z.shape)
    drawn.coverage[random.random(drawn.z.shape) < 0.1] = 0.0
    opaque = random.random(drawn.z.shape) < 0.05
    drawn.coverage[opaque], drawn.transmission[opaque] = 1.0, 0.0
    name = f"{curve},channels={channels},{memory},normalized={str(normalized).lower()}]"
    found = render(device, drawn, name)
    truth = expected(drawn, curve, channels == "rgb", normalized)
    # The error of relative depths, 2^-22, grows with 31 coefficients and absorbances up to 12.
    np.testing.assert_allclose(found, truth, rtol=2e-5, atol=2e-5)


@pytest.mark.parametrize("curve", CURVES)
@pytest.mark.parametrize("memory", MEMORIES)
def test_total_transmittance_is_exact(device: Device, curve: str, memory: str) -> None:
    drawn = random_lists(30, side=4)
    black = np.zeros_like(drawn.radiance)
    drawn = replace(drawn, coverage=drawn.coverage / np.float32(20), radiance=black)
    found = render(device, drawn, f"{curve},{memory}]")
    np.testing.assert_allclose(found, composite(drawn, BACKGROUND), rtol=0, atol=1e-6)


@pytest.mark.parametrize("curve", CURVES)
@pytest.mark.parametrize("memory", MEMORIES)
def test_visibility_is_between_0_and_1_and_falls_in_opacity_maps(
    device: Device, curve: str, memory: str
) -> None:
    side = 64
    dark = [
        Layer(z, o, NOTHING) for z, o in ((2, 0.9), (2.1, 0.5), (3.7, 0.95), (4.5, 0.2), (6, 0.3))
    ]
    probe = Layer(1.0, 1.0, (1.0, 1.0, 1.0), (1.0, 1.0, 1.0))
    drawn = stack([probe, *dark], side)
    drawn.z[0] = np.linspace(1.0, 7.0, side, dtype=np.float32)[:, None]
    found = render(device, scene_of(drawn, NOTHING), f"{curve},{memory}]")[:, 0, 0]
    assert ((found >= 0) & (found <= 1)).all()
    assert found[0] == 1.0
    assert found[-1] == pytest.approx(0.1 * 0.5 * 0.05 * 0.8 * 0.7, rel=1e-4)
    if curve.startswith("opacity_map"):
        # Each pixel may sum its list in another order.
        several = takes_any_order(device, f"{curve},{memory}]")
        assert (np.diff(found) <= (5 * 2.0**-24 if several else 0.0)).all()


@pytest.mark.parametrize("curve", DEFAULTS)
@pytest.mark.parametrize("memory", MEMORIES)
def test_layers_that_absorb_nothing_do_not_change_the_bounds(
    device: Device, curve: str, memory: str
) -> None:
    dark = [Layer(3.0, 0.5, (0.2, 0.4, 0.6)), Layer(4.0, 0.3, (0.9, 0.1, 0.5))]
    clear = [Layer(0.5, 0.0), Layer(300.0, 0.0)]
    name = f"{curve},{memory}]"
    alone = render(device, stack(dark, 2), name)
    np.testing.assert_array_equal(render(device, stack([*clear, *dark], 2), name), alone)
    # A clear layer with radiance is attenuated by the layer in front of it.
    shining = Layer(300.0, 1.0, (1.0, 1.0, 1.0), (1.0, 1.0, 1.0))
    added = render(device, stack([shining, dark[0]], 2), name) - render(
        device, stack([dark[0]], 2), name
    )
    np.testing.assert_allclose(added, 0.5, atol=1e-6)


@pytest.mark.parametrize("curve", DEFAULTS)
def test_lists_and_fixed_memory_give_the_same_picture(device: Device, curve: str) -> None:
    drawn = random_lists(40, tinted=True, side=8)
    pictures = [render(device, drawn, f"{curve},channels=rgb,{m}]") for m in MEMORIES]
    np.testing.assert_allclose(pictures[0], pictures[1], rtol=0, atol=1e-5)


def test_lanczos_factors_reduce_ringing(device: Device) -> None:
    side = 64
    drawn = stack(
        [
            Layer(1.0, 1.0, (1.0, 1.0, 1.0), (1.0, 1.0, 1.0)),
            *[Layer(z, 0.99, NOTHING) for z in (2.0, 4.0, 6.0)],
        ],
        side,
    )
    drawn.z[0] = np.linspace(2.0, 6.0, side, dtype=np.float32)[:, None]
    rises = []
    for lanczos in ("false", "true"):
        name = f"fourier_map[lanczos={lanczos},node=precise]"
        shown = -np.log(render(device, scene_of(drawn, NOTHING), name)[:, 0, 0])
        rises.append(float(np.maximum(-np.diff(shown), 0).sum()))
    assert rises[1] < rises[0] / 2, rises


@pytest.mark.parametrize(
    ("name", "mebibytes"),
    [
        ("opacity_map[memory=fixed]", 63.3),
        ("fourier_map[memory=fixed]", 63.3),
        ("opacity_map[memory=fixed,msaa=4]", 253.1),
        ("fourier_map[memory=fixed,msaa=4]", 253.1),
    ],
)
def test_maps_have_the_published_memory(device: Device, name: str, mebibytes: float) -> None:
    bits = bits_per_pixel(device, scene_of(random_lists(1)), name)
    assert round(bits / 8 * PIXELS_720P / MIB, 1) == mebibytes


def bytes_of_lists(device: Device, name: str) -> tuple[float, float]:
    """Return bytes per pixel and bytes per fragment, from lists of two lengths."""
    totals = []
    for layers in (1, 3):
        with opened(device, scene_of(random_lists(layers)), name) as frame:
            facts = accounting.memory(frame)
            totals.append(
                sum(term.bytes for term in facts.terms if "allocator" not in term.resource)
            )
    pixels = 16 * 16
    record = (totals[1] - totals[0]) / (2 * pixels)
    return totals[0] / pixels - record, record


@pytest.mark.parametrize(
    "name", ["a_buffer[node=compact]", "adaptive", "opacity_map", "fourier_map"]
)
@pytest.mark.parametrize(
    ("millions", "published", "heads"),
    [
        (10.6, 125.4, True),
        (15.0, 174.6, True),
        (6.0, 72.6, True),
        # The published size of these scenes does not include the heads.
        (2.69, 30.8, False),
        (3.47, 39.7, False),
    ],
)
def test_lists_have_the_published_memory(
    device: Device, name: str, millions: float, published: float, heads: bool
) -> None:
    pixel, record = bytes_of_lists(device, name)
    assert (pixel, record) == (4, 12)
    # Published numbers of fragments are rounded to one or two decimals.
    half_digit = 0.5 * 10.0 ** -(2 if millions < 6 else 1)
    base = pixel * PIXELS_720P * heads
    low, high = ((base + record * (millions + sign * half_digit) * 1e6) / MIB for sign in (-1, 1))
    assert low - 0.05 <= published <= high + 0.05
    if not heads:
        assert published < (pixel * PIXELS_720P + record * (millions - half_digit) * 1e6) / MIB - 3


@pytest.mark.parametrize(
    ("name", "record"), [("adaptive[channels=rgb]", 16), ("opacity_map[node=precise]", 32)]
)
def test_colored_and_precise_records_are_larger(device: Device, name: str, record: int) -> None:
    assert bytes_of_lists(device, name) == (4, record)


@pytest.mark.parametrize("name", ["opacity_map", "fourier_map"])
def test_every_sample_of_a_steep_sheet_lies_within_its_own_bounds(
    device: Device, name: str
) -> None:
    # A single layer hides nothing of itself, so the curve of a sample must begin at its own depth.
    steep = quad((0, 0, -2), (0.5, 0, 1.2), (0, 0.5, 0))
    material = Material(coverage=0.8, emission=(1.0, 0.5, 0.25))
    scene = Scene("steep", Camera((0, 0, 0), (0, 0, -1)), (Object("sheet", steep, material),))
    image = render(device, scene, f"{name}[memory=fixed,msaa=4]", size=(16, 16))
    exact = render(device, scene, "weighted_blended[msaa=4,precision=float]", size=(16, 16))
    np.testing.assert_allclose(image, exact, atol=1e-6)
