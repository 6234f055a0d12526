"""Deep stacks of layers stall, drift or overflow in 8 and 16 bits."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from oitbench.gl.device import Device
from oitbench.measure.oracle import composite
from oitbench.modeling.mesh import quad
from oitbench.scene import Camera, EnvironmentLight, Material, Object, Scene
from tests.helpers import (
    BACKGROUND,
    NOTHING,
    WHITE,
    Layer,
    collection,
    random_lists,
    render,
    scene_of,
    stack,
)

THIN = [Layer(1.0 + index / 100, 1 / 512, NOTHING) for index in range(1000)]
PASSED = (1 - 1 / 512) ** 1000
"""The transmittance of `THIN`."""


def in_halves(rounded: Callable[[float], float]) -> float:
    """Return it as the product of half floats."""
    product = 1.0
    for _ in THIN:
        product = rounded(product * (1 - 1 / 512))
    return product


def truncated(number: float) -> float:
    """Return a half float, rounded toward zero."""
    mantissa, exponent = math.frexp(number)
    return math.ldexp(math.floor(mantissa * 2**11), exponent - 11)


def passed(device: Device, name: str) -> float:
    """Return the transmittance of 1000 layers of coverage 1/512; the exact one is 0.1416."""
    return float(render(device, scene_of(stack(THIN, 4), WHITE), name)[0, 0, 0])


def test_eight_bits_of_transmittance_stall_at_one(device: Device) -> None:
    assert passed(device, "weighted_blended") == 1.0


@pytest.mark.parametrize(
    "name",
    [
        "alpha_blend",
        "sorted_over",
        "sorted_two_pass[sort=triangle]",
        "weighted_blended",
        "stochastic",
    ],
)
def test_floats_are_accurate_for_1000_faint_layers(device: Device, name: str) -> None:
    base, _, body = name.removesuffix("]").partition("[")
    full = f"{base}[{body + ',' if body else ''}precision=float]"
    assert passed(device, full) == pytest.approx(PASSED, abs=1e-4)


@pytest.mark.parametrize(
    "name", ["alpha_blend", "sorted_over", "weighted_blended[precision=half]", "stochastic"]
)
def test_half_floats_drift_over_1000_faint_layers(device: Device, name: str) -> None:
    found = passed(device, name)
    # llvmpipe truncates, GPUs round to nearest.
    assert found == in_halves(truncated if device.software else lambda x: float(np.float16(x)))
    assert abs(found - PASSED) > 1 / 255


def test_only_half_floats_overflow_in_the_sum_of_bright_near_layers(device: Device) -> None:
    # With w = 3000 and L = 2, the sum of colors exceeds 65504 after eleven layers, the sum of
    # weights does not.
    layers = [Layer(0.1001, 1.0, (2.0, 2.0, 2.0))] * 16
    for precision in ("paper", "half"):
        found = render(device, stack(layers, 4), f"weighted_blended[precision={precision}]")
        assert found.max() == pytest.approx(65504 / (16 * 3e3), rel=0.01)
    found = render(device, stack(layers, 4), "weighted_blended[precision=float]")
    assert found == pytest.approx(np.full_like(found, 2.0), rel=1e-5)


def test_a_count_of_half_floats_stalls_at_2048(device: Device) -> None:
    count, alpha = 3000, 1e-3
    lists = scene_of(stack([Layer(2.0, alpha, NOTHING)] * count, 4), WHITE)
    right = render(device, lists, "weighted_average[count=r32f,precision=float]")[0, 0, 0]
    assert right == pytest.approx((1 - alpha) ** count, abs=1e-4)
    stalled = render(device, lists, "weighted_average[precision=float]")[0, 0, 0]
    assert stalled == pytest.approx((1 - alpha * count / 2048) ** 2048, abs=1e-4)


@pytest.mark.parametrize("name", ["weighted_sum", "weighted_average[count=r32f]"])
def test_a_sum_of_half_floats_stalls_after_2048_equal_terms(device: Device, name: str) -> None:
    lists = scene_of(stack([Layer(2.0, 2.0**-10, WHITE)] * 4096, 4), NOTHING)
    separator = "," if "[" in name else "["
    full = f"{name.removesuffix(']')}{separator}precision=float]"
    expected = {"weighted_sum": 4.0}.get(name, 1 - (1 - 2.0**-10) ** 4096)
    assert render(device, lists, full)[0, 0] == pytest.approx([expected] * 3, rel=1e-4)
    assert render(device, lists, name)[0, 0, 0] < 0.95 * expected


@pytest.mark.parametrize("name", ["alpha_blend", "sorted_over", "depth_peeling", "stochastic"])
def test_floats_and_half_floats_differ_by_a_few_steps_for_six_layers(
    device: Device, name: str
) -> None:
    lists = scene_of(random_lists(6), BACKGROUND)
    half, full = (render(device, lists, f"{name}[precision={p}]") for p in ("half", "float"))
    assert 0 < abs(half - full).max() < 8 * 2.0**-10


def test_peeling_in_floats_is_exact(device: Device) -> None:
    lists = random_lists(12, tinted=True)
    found = render(device, lists, "depth_peeling[precision=float]")
    assert abs(found - composite(lists, BACKGROUND)).max() < 1e-6


@pytest.mark.parametrize("radiance", [6e4, 7e4, 1e6, 1.6e9])
@pytest.mark.parametrize("lamp", ["surface", "background", "environment"])
def test_the_truth_clips_no_radiance(device: Device, radiance: float, lamp: str) -> None:
    light = (radiance, radiance / 2, radiance / 4)
    pane = Object("pane", quad((0, 0, -2), (9, 0, 0), (0, 9, 0)), Material(coverage=0.5))
    wall = Object("lamp", quad((0, 0, -4), (9, 0, 0), (0, 9, 0)), Material(emission=light))
    scene = Scene(
        "lamp",
        Camera((0, 0, 0), (0, 0, -1)),
        (pane, wall) if lamp == "surface" else (pane,),
        background=light if lamp == "background" else NOTHING,
        lights=(EnvironmentLight(light),) if lamp == "environment" else (),
    )
    expected = np.broadcast_to(np.multiply(light, 0.5), (8, 8, 3))
    image = render(device, scene, collection().truth(), size=(8, 8))
    np.testing.assert_allclose(image, expected, rtol=1e-5)
    # A half-float frame shows its own clipping, and never agrees with a clipped truth.
    half = render(device, scene, "sorted_over", size=(8, 8))
    if radiance > 65504:
        assert not np.allclose(half[..., 0], expected[..., 0], rtol=0.05)
    else:
        np.testing.assert_allclose(half, expected, rtol=2e-3)
