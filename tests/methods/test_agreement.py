"""Sorted blending equals the A-buffer in scenes that can be sorted."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.gl.device import Device
from oitbench.method.storage import Target
from oitbench.scene import Floats
from tests.helpers import all_passes, collection, full_plan, method, render

SIZE = (96, 64)
SCENES = (
    "layer_stack",
    "layer_stack[order=near_first]",
    "layer_stack[order=shuffled,seed=7,count=8,alpha=0.3]",
    "layer_stack[transmission=colored]",
    "layer_stack[transmission=gray,clarity=0.3]",
    "layer_stack[radiance=40]",
    "glass_bars",
)
SORTED = ("sorted_over[sort=triangle]", "sorted_over[sort=object]", "sorted_two_pass[sort=object]")


def local_step(target: Target, image: Floats) -> Floats:
    """Return the distance of neighboring values of the target's format at each value of `image`."""
    octave = np.floor(np.log2(np.maximum(image, 0.5))) + 1
    return np.asarray(target.texel.step * 2.0**octave)


@pytest.mark.parametrize("name", SORTED)
@pytest.mark.parametrize("scene", SCENES)
def test_sorted_blending_equals_the_a_buffer(device: Device, scene: str, name: str) -> None:
    built = collection().build_scene(scene)
    exact = render(device, built, "a_buffer", size=SIZE).astype(np.float64)
    found = render(device, built, name, size=SIZE)
    color = full_plan(method(name)).targets.get("color", Target("rgba16f"))
    # Two steps for each blended pass of the geometry, one for the opaque picture.
    steps = 2 * len(list(all_passes(method(name)))) + 1
    assert (abs(found - exact) <= steps * local_step(color, exact)).all()


@pytest.mark.parametrize("scene", SCENES)
def test_both_resolves_of_the_a_buffer_are_equal(device: Device, scene: str) -> None:
    built = collection().build_scene(scene)
    exact = render(device, built, "a_buffer", size=SIZE)
    found = render(device, built, "a_buffer[resolve=iterative]", size=SIZE)
    np.testing.assert_allclose(found, exact, rtol=1e-6, atol=1e-6)


def test_unsorted_blending_differs_from_the_a_buffer(device: Device) -> None:
    built = collection().build_scene("layer_stack")
    exact = render(device, built, "a_buffer", size=SIZE)
    assert abs(render(device, built, "alpha_blend", size=SIZE) - exact).max() > 0.05
