"""Phenomenological transparency against its model; its published memory."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.matrix.picture import render as picture
from oitbench.measure.accounting import memory
from oitbench.measure.oracle import transmittances
from oitbench.modeling.mesh import sphere
from oitbench.scene import WHITE, Material, Object, Scene
from tests.helpers import BACKGROUND, Layer, opened, random_lists, render, scene_of, stack
from tests.methods.sheets import (
    CAMERA,
    CLEAR,
    FLOAT,
    SIZE,
    sheet_scene,
    wall,
    with_parameter,
)
from tests.models import phenomenological as model


@pytest.mark.parametrize("modulation", ["none", "i3d", "tvcg"])
@pytest.mark.parametrize("equation", ["eq5", "g3d"])
def test_lists_equal_the_model(device: Device, modulation: str, equation: str) -> None:
    lists = random_lists(8, tinted=True)
    name = with_parameter(f"modulation={modulation},depth_weight={equation}")
    expected = model.composite(lists, BACKGROUND, modulation, equation)
    np.testing.assert_allclose(render(device, lists, name), expected, rtol=0, atol=1e-4)


def test_beta_is_exact_in_any_order(device: Device) -> None:
    lists = random_lists(12, tinted=True)
    dark = replace(lists, radiance=np.zeros_like(lists.radiance))
    expected = np.asarray(BACKGROUND) * transmittances(lists).prod(axis=0)
    for seed in (None, 1, 2):
        found = render(device, dark, FLOAT, permutation=seed)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-5)


def test_equal_gray_layers_are_exact(device: Device) -> None:
    layer = Layer(3.0, 0.3, (0.9, 0.5, 0.1), (0.2, 0.2, 0.2))
    for count in (1, 7):
        lists = stack([layer] * count)
        passed = (1 - 0.3 * 0.8) ** count
        mean = np.multiply(layer.radiance, 1 / 0.8)  # the light of a layer is alpha L, not o L
        expected = mean * (1 - passed) + np.multiply(BACKGROUND, passed)
        found = render(device, lists, FLOAT)
        np.testing.assert_allclose(found, np.broadcast_to(expected, found.shape), atol=1e-5)


@pytest.mark.parametrize("depth", [0.3, 1.0])
def test_opaque_layers_keep_their_brightness_except_by_the_formula_of_2016(
    device: Device, depth: float
) -> None:
    lists = stack([Layer(depth, 1.0, (0.8, 0.4, 0.2))])
    for modulation, factor in (("none", 1.0), ("tvcg", 1.0), ("i3d", 0.5)):
        name = with_parameter(f"modulation={modulation}")
        expected = factor * np.array([0.8, 0.4, 0.2])
        np.testing.assert_allclose(render(device, lists, name)[0, 0], expected, atol=1e-5)


def test_colored_glass_tints_its_own_reflection(device: Device) -> None:
    """A known failure of the published formula: red glass with a white reflection has no red."""
    lists = stack([Layer(2.0, 1.0, (0.1, 0.1, 0.1), (1.0, 0.0, 0.0))])
    scene = scene_of(lists, (0.0, 0.0, 0.0))
    plain = render(device, scene, with_parameter("modulation=none"))
    np.testing.assert_allclose(plain[0, 0], (0, 0.15, 0.15), atol=1e-5)
    modulated = render(device, scene, with_parameter("modulation=i3d"))
    np.testing.assert_allclose(modulated[0, 0], (0, 0.075, 0.075), atol=1e-5)


def test_colored_bars_equal_sorted_two_pass_blending() -> None:
    """McGuire & Mara 2017, figure 7."""
    scene, size = "glass_bars[reflection=0]", (192, 192)
    pictures = {
        name: picture(scene, name, size, ssaa=1)[0]
        for name in ("sorted_two_pass", "phenomenological", "weighted_blended")
    }
    truth = pictures["sorted_two_pass"]
    assert abs(pictures["phenomenological"] - truth).max() <= 2 / 255
    assert abs(pictures["weighted_blended"] - truth).max() > 0.5
    assert abs(pictures["weighted_blended"] - truth).mean() > 0.02


@pytest.mark.parametrize(
    ("effects", "bits", "targets"),
    [
        (Effect.COVERAGE, 88, {"accum", "beta"}),
        (Effect.COVERAGE | Effect.DIFFUSION, 96, {"accum", "beta"}),
        (Effect.COVERAGE | Effect.REFRACTION, 104, {"accum", "beta", "delta"}),
        (
            Effect.COVERAGE | Effect.REFRACTION | Effect.DIFFUSION,
            112,
            {"accum", "beta", "delta"},
        ),
    ],
)
def test_a_pixel_has_the_published_bits(
    device: Device, effects: Effect, bits: int, targets: set[str]
) -> None:
    """McGuire & Mara 2017: 88 bits for coverage, 112 with diffusion and refraction."""
    with opened(device, sheet_scene(CLEAR), "phenomenological", SIZE, effects=effects) as frame:
        account = memory(frame)
    assert account.bits_per_pixel == bits
    assert {term.resource for term in account.terms} == targets


@pytest.mark.parametrize("precision", ["paper", "half", "float"])
@pytest.mark.parametrize(
    "material",
    [
        Material(coverage=1.0, transmission=WHITE, index=1.0, collimation=0.0),
        Material(coverage=1.0, transmission=WHITE, index=1.5, collimation=0.0, solid=True),
        Material(coverage=1e-7, transmission=WHITE, index=2.4, solid=True, roughness=0.0),
        Material(coverage=0.999, emission=(6e4, 6e4, 6e4), collimation=0.5),
    ],
)
def test_extreme_constants_stay_finite(device: Device, precision: str, material: Material) -> None:
    name = f"phenomenological[precision={precision}]"
    on_near_plane = sheet_scene(material, z=CAMERA.near * (1 + 1e-6))
    inside = Scene(
        "inside", CAMERA, (wall(), Object("ball", sphere((0, 0, 0), 1.0, 24, 12), material))
    )
    everything = Effect.COVERAGE | Effect.REFRACTION | Effect.DIFFUSION
    for scene in (on_near_plane, inside, sheet_scene(material, tilt=1.5)):
        with opened(device, scene, name, SIZE, effects=everything) as frame:
            frame.render()
            found = frame.image()
        assert np.isfinite(found).all()
        assert (found >= 0).all()
