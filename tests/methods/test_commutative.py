"""Sums, means and weighted means of all layers against their formulas."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from oitbench.gl.device import Device
from oitbench.gl.frame import Image
from oitbench.measure.oracle import composite
from oitbench.scene import Floats, FragmentLists
from tests.helpers import (
    BACKGROUND,
    BLUE,
    GREEN,
    NOTHING,
    RED,
    WHITE,
    Layer,
    bits_per_pixel,
    method,
    random_lists,
    render,
    scene_of,
    stack,
)
from tests.models import commutative as model

STEP = {"paper": 2.0**-10, "half": 2.0**-10, "float": 2.0**-22}
"""Twice the largest relative rounding error of a number; drivers may truncate."""
lists_drawn = st.builds(
    random_lists, st.integers(1, 16), tinted=st.booleans(), seed=st.integers(0, 2**32 - 1)
)
precisions = st.sampled_from(["half", "float"])
drawn = settings(max_examples=12, deadline=None, derandomize=True)


def close(found: Image, expected: Floats, allowed: float | Floats) -> None:
    assert (abs(found - expected) <= allowed).all(), abs(found - expected).max()


@drawn
@given(lists=lists_drawn, clamp=st.booleans(), precision=precisions)
def test_weighted_sum_equals_its_formula(
    device: Device, lists: FragmentLists, clamp: bool, precision: str
) -> None:
    name = f"weighted_sum[clamp={str(clamp).lower()},precision={precision}]"
    expected = model.weighted_sum(lists, BACKGROUND, clamp)
    # n + 2 rounded additions of terms whose sum is at most n + 1.
    count = len(lists.z)
    close(render(device, lists, name), expected, STEP[precision] * (count + 2) * (count + 1))


@drawn
@given(lists=lists_drawn, count=st.sampled_from(["r16f", "r32f"]), precision=precisions)
def test_weighted_average_equals_its_formula(
    device: Device, lists: FragmentLists, count: str, precision: str
) -> None:
    name = f"weighted_average[count={count},precision={precision}]"
    expected = model.weighted_average(lists, BACKGROUND)
    number, relative = len(lists.z), STEP[precision]
    total = model.layers_of(lists)[1].sum(axis=0)
    # The errors of a quotient of two sums, and of (1 - o)^n where the mean opacity o is a sum too.
    passed = number * (1 - total / number) ** (number - 1) * total * relative
    arithmetic = number * 2.0**-18
    close(
        render(device, lists, name),
        expected,
        (2 * number + 2) * relative + passed[..., None] + arithmetic,
    )


@drawn
@given(
    lists=lists_drawn,
    equation=st.sampled_from([7, 8, 9, 10]),
    precision=st.sampled_from(["paper", "half", "float"]),
)
def test_weighted_blending_equals_its_formula(
    device: Device, lists: FragmentLists, equation: int, precision: str
) -> None:
    name = f"weighted_blended[weight={equation},precision={precision}]"
    expected = model.weighted_blended(lists, BACKGROUND, equation)
    number, relative = len(lists.z), STEP[precision]
    reveal = 1 / 255 if precision == "paper" else relative
    allowed = (2 * number + 2) * relative + number * reveal + 1e-5
    close(render(device, lists, name), expected, allowed)


@pytest.mark.parametrize("powers", [(3.0, 6.0), (8.0, 0.5)])
@pytest.mark.parametrize("ranges", [(1.0, 20.0), (0.5, 0.1)])
def test_a_fitted_weight_has_the_form_of_two_equations(
    device: Device, ranges: tuple[float, float], powers: tuple[float, float]
) -> None:
    (b, c), (p, q) = ranges, powers
    lists = random_lists(8, tinted=True)
    fitted = f"weight=fitted,near_range={b},near_power={p},far_range={c},far_power={q}"
    found = render(device, lists, f"weighted_blended[{fitted},precision=float]")
    bare = model.fitted_weight(lists.z.astype(np.float64), b, p, c, q)
    close(found, model.blended(lists, BACKGROUND, bare), 2e-5)
    eighth = "weight=fitted,near_range=10,near_power=3,far_range=200,far_power=6"
    one, other = (
        render(device, lists, f"weighted_blended[{weight},precision=float]")
        for weight in (eighth, "weight=8")
    )
    np.testing.assert_allclose(one, other, rtol=0, atol=1e-6)


def test_weighted_sums_of_opaque_layers_are_negative_unless_clamped(device: Device) -> None:
    lists = scene_of(stack([Layer(1.0, 1.0, NOTHING), Layer(2.0, 0.5, NOTHING)]), WHITE)
    assert render(device, lists, "weighted_sum")[0, 0] == pytest.approx([-0.5] * 3)
    assert render(device, lists, "weighted_sum[clamp=true]")[0, 0] == pytest.approx([0.0] * 3)


@pytest.mark.parametrize("name", ["weighted_sum", "weighted_average"])
def test_methods_without_depth_ignore_the_distance(device: Device, name: str) -> None:
    near, far = Layer(2.0, 0.5, RED), Layer(4.0, 0.3, BLUE)
    swapped = [Layer(4.0, 0.5, RED), Layer(2.0, 0.3, BLUE)]
    before, after = (render(device, stack(layers), name) for layers in ([near, far], swapped))
    np.testing.assert_array_equal(before, after)
    assert "two_layers_ordered" not in method(name).promised


def test_the_weighted_average_transmits_at_least_the_exact_light(device: Device) -> None:
    lists = random_lists(8)
    black = FragmentLists(
        lists.z, lists.coverage, np.zeros_like(lists.radiance), lists.transmission
    )
    found = render(device, scene_of(black, WHITE), "weighted_average[precision=float]")
    exact = composite(black, WHITE)
    assert (found >= exact - 1e-6).all()
    assert (found > 1.05 * exact).mean() > 0.9


@pytest.mark.parametrize("name", ["weighted_sum", "weighted_average"])
def test_clear_glass_keeps_its_highlight(device: Device, name: str) -> None:
    clear = [Layer(2.0, 1.0, (0.5, 0.25, 2.0), WHITE), Layer(3.0, 1.0, NOTHING, WHITE)]
    found = render(device, scene_of(stack(clear), GREEN), name)
    assert found[0, 0] == pytest.approx([0.5, 1.25, 2.0])


def test_clear_layers_do_not_change_the_mean(device: Device) -> None:
    some = [Layer(2.0, 0.5, RED), Layer(4.0, 0.5, GREEN)]
    glass = [Layer(z, 1.0, NOTHING, WHITE) for z in (1.0, 3.0, 5.0)]
    found = render(device, stack([*some, *glass]), "weighted_average")
    np.testing.assert_array_equal(found, render(device, stack(some), "weighted_average"))


@pytest.mark.parametrize(
    ("name", "bits"),
    [
        ("weighted_sum", 64),
        ("weighted_sum[precision=float]", 128),
        ("weighted_average", 80),
        ("weighted_average[count=r32f]", 96),
        ("weighted_average[count=r32f,precision=float]", 160),
        ("weighted_blended", 72),
        ("weighted_blended[precision=half]", 80),
        ("weighted_blended[precision=float]", 160),
        ("weighted_blended[msaa=4]", 288),
        ("alpha_blend[precision=float]", 0),
        # A byte marks each block of 16 x 16 pixels.
        ("depth_peeling", 8 * (40 + 1 / 256)),
        ("depth_peeling[precision=float]", 8 * (72 + 1 / 256)),
    ],
)
def test_memory_depends_on_the_formats(device: Device, name: str, bits: float) -> None:
    assert bits_per_pixel(device, scene_of(random_lists(1)), name) == bits
