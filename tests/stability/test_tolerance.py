"""The largest error that rounding can cause."""

from __future__ import annotations

import pytest

from oitbench.method.storage import Target
from oitbench.stability.tolerance import rounding, step, tolerance
from tests.helpers import method


def test_a_step_grows_with_each_power_of_two() -> None:
    half = Target("rgba16f")
    assert [step(half, x) for x in (0.7, 1.0, 1.5, 2.0)] == [2.0**-11, 2.0**-10, 2.0**-10, 2.0**-9]
    assert step(half, 0.0) == 2.0**-11
    assert step(Target("r8"), 1.0) == step(Target("r8"), 100.0) == 1 / 255


def test_the_bound_follows_from_the_formats() -> None:
    half, single = (method(f"alpha_blend[precision={name}]") for name in ("half", "float"))
    assert tolerance(half, 1, 1.0) == 2 * 2.0**-10
    assert tolerance(half, 4, 1.0) / tolerance(single, 4, 1.0) > 2**10
    assert tolerance(half, 4, 3.0) == 3 * tolerance(half, 4, 1.0)


def test_packed_records_add_half_a_step_of_color_and_of_opacity() -> None:
    packed, precise = (method(f"a_buffer[node={name}]") for name in ("compact", "precise"))
    assert tolerance(packed, 2, 1.0) - rounding(packed, 2, 1.0) == pytest.approx(2 / 255)
    assert tolerance(packed, 2, 3.0) - rounding(packed, 2, 3.0) == pytest.approx(4 / 255)
    assert tolerance(precise, 2, 1.0) == rounding(precise, 2, 1.0)


def test_lists_that_are_composited_in_a_shader_add_its_arithmetic() -> None:
    chosen = method("a_buffer")
    one, two = (rounding(chosen, layers, 1.0) for layers in (1, 2))
    assert two - one == pytest.approx(4 * 2.0**-23)
