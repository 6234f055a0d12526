"""Known failures of methods are as large as their formulas predict."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.gl.device import Device
from oitbench.measure.oracle import composite
from oitbench.modeling.mesh import quad
from oitbench.scene import Camera, Material, Mesh, Object, Scene
from tests.helpers import (
    BACKGROUND,
    BLUE,
    GREEN,
    NOTHING,
    RED,
    WHITE,
    Layer,
    method,
    random_lists,
    render,
    rounding,
    scene_of,
    stack,
)
from tests.models import commutative


@pytest.mark.parametrize(
    ("equation", "measured"), [(7, 0.059), (8, 0.094), (9, 0.199), (10, 0.030)]
)
def test_weighted_blending_leaks_through_an_opaque_front(
    device: Device, equation: int, measured: float
) -> None:
    chosen = method(f"weighted_blended[weight={equation}]")
    assert "opaque_front_hides" not in chosen.promised
    front, behind = Layer(1.0, 1.0, RED), Layer(2.0, 0.5, GREEN)
    red, green, blue = render(device, stack([front, behind]), chosen)[0, 0]
    near, far = commutative.weight(equation, np.array([front.z, behind.z])) * (1, 0.5**2)
    leak = far / (near + far)
    assert green == pytest.approx(leak, rel=4e-3)
    assert green == pytest.approx(measured, abs=1e-3)
    assert red == pytest.approx(1 - leak, rel=4e-3)
    # The background is hidden.
    assert blue == 0


@pytest.mark.parametrize("equation", [7, 8, 9, 10])
def test_weighted_blending_equals_its_formula_to_rounding(device: Device, equation: int) -> None:
    chosen = method(f"weighted_blended[weight={equation}]")
    lists = random_lists(5)
    expected = commutative.weighted_blended(lists, BACKGROUND, equation)
    found = render(device, lists, chosen)
    np.testing.assert_allclose(found, expected, rtol=0, atol=rounding(chosen, 5, 1.0))


def test_alpha_blending_depends_on_the_order_of_the_draws(device: Device) -> None:
    near, far = Layer(2.0, 0.5, RED), Layer(4.0, 0.5, BLUE)
    right = render(device, stack([far, near]), "alpha_blend")
    wrong = render(device, stack([near, far]), "alpha_blend")
    assert abs(right - composite(stack([near, far]), BACKGROUND)).max() < 2e-3
    assert wrong[0, 0] - right[0, 0] == pytest.approx([-0.25, 0.0, 0.25], abs=2e-3)


@pytest.mark.parametrize("name", ["alpha_blend", "weighted_blended", "a_buffer[node=compact]"])
def test_methods_of_one_channel_turn_colored_glass_gray(device: Device, name: str) -> None:
    glass = Layer(2.0, 1.0, NOTHING, transmission=(0.9, 0.6, 0.0))
    found = render(device, scene_of(stack([glass]), WHITE), name)
    assert "colored_layer_exact" not in method(name).promised
    assert found[0, 0] == pytest.approx([0.5, 0.5, 0.5], abs=4e-3)


def test_packed_records_clip_radiance_above_one(device: Device) -> None:
    found = render(device, stack([Layer(2.0, 1.0, (4.0, 1.0, 0.0))]), "a_buffer[node=compact]")
    assert found[0, 0] == pytest.approx([1.0, 1.0, 0.0])


def test_two_passes_per_object_do_not_attenuate_its_second_layer(device: Device) -> None:
    front, back = (quad((0, 0, z), (9, 0, 0), (0, 9, 0)) for z in (-2.0, -3.0))
    both = Mesh(
        np.concatenate([front.positions, back.positions]),
        np.concatenate([front.triangles, back.triangles + len(front.positions)]),
    )
    pair = Object("pair", both, Material(coverage=0.5, emission=WHITE))
    scene = Scene("pair", Camera((0, 0, 0), (0, 0, -1)), (pair,))
    exact = render(device, scene, "a_buffer", size=(8, 8))
    by_object = render(device, scene, "sorted_two_pass", size=(8, 8))
    by_triangle = render(device, scene, "sorted_two_pass[sort=triangle]", size=(8, 8))
    assert exact[4, 4] == pytest.approx([0.75] * 3)
    assert by_object[4, 4] == pytest.approx([1.0] * 3)
    assert abs(by_triangle - exact).max() < 2e-3
