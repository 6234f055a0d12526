"""Four samples per pixel: coverage masks in lists, and multisampled targets."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from oitbench.gl.device import Device
from oitbench.modeling.mesh import quad
from oitbench.plugins import Collection
from oitbench.scene import Camera, Material, Object, Scene
from tests.benchmarks.speed import overlapping_quads
from tests.helpers import (
    assert_order_independent,
    collection,
    method,
    offered,
    opened,
    random_lists,
    render,
    rounding,
    takes_any_order,
    write_method,
)

SIZE = (48, 48)
SORTED = '(Gather("over.glsl", writes={"color": OVER}, order=Order.TRIANGLES),)'
EXACT = (
    "a_buffer[msaa=4]",
    "a_buffer[resolve=iterative,msaa=4]",
    "adaptive[nodes=32,node=precise,msaa=4]",
    "adaptive[nodes=16,memory=fixed,msaa=4]",
)


def blended_by_hardware(device: Device, folder: Path, scene: Scene) -> np.ndarray:
    """Return the image of sorted blending into targets of four samples."""
    write_method(
        folder / "methods" / "multisampled",
        SORTED,
        '{"color": Target("rgba32f")}',
        members="expresses = Effect.COVERAGE\nsample_count = 4",
        over="void gather(Fragment fragment) { color = premultiplied(fragment); }",
    )
    (sorted_over,) = Collection.load([folder]).expand_methods(["multisampled"])
    return render(device, scene, sorted_over, size=SIZE)


@pytest.mark.parametrize(("quads", "names"), [(12, EXACT), (70, EXACT[:2])])
def test_edges_equal_those_of_hardware_multisampling(
    device: Device, tmp_path: Path, quads: int, names: tuple[str, ...]
) -> None:
    # Lists of seventy quads are sorted in their links, which the samples of a pixel share.
    scene = overlapping_quads(quads)
    truth = blended_by_hardware(device, tmp_path, scene)
    assert abs(truth - render(device, scene, "a_buffer", size=SIZE)).max() > 0.05
    for name in names:
        if not offered(device, name):
            continue
        found = render(device, scene, name, size=SIZE)
        np.testing.assert_allclose(found, truth, rtol=0, atol=1e-6, err_msg=name)


@pytest.mark.parametrize("layers", [6, 40])
@pytest.mark.parametrize(
    "name",
    [
        "a_buffer[{}]",
        "a_buffer[node=compact,{}]",
        "a_buffer[resolve=iterative,{}]",
        "adaptive[{}]",
        "adaptive[channels=rgb,node=precise,{}]",
        "adaptive[memory=fixed,{}]",
        "adaptive[memory=fixed,nodes=24,{}]",
        "opacity_map[memory=fixed,{}]",
        "fourier_map[memory=fixed,{}]",
    ],
)
def test_pixels_that_are_covered_completely_do_not_change(
    device: Device, name: str, layers: int
) -> None:
    four = name.format("msaa=4")
    if not offered(device, four):
        pytest.skip(f"{device.renderer} cannot blend four samples in shaders")
    free = takes_any_order(device, four)
    if free and layers > 8 and name.startswith("adaptive"):
        pytest.skip(f"{device.renderer} fills lists in any order")
    lists = random_lists(layers, tinted=True, side=8)
    found = render(device, lists, four)
    # The iterative resolve multiplies in the order of arrival, and so do all lists on GPUs.
    allowed = 1e-6 if "iterative" in name else 0.0
    allowed = max(allowed, rounding(method(four), layers, 1.0)) if free else allowed
    np.testing.assert_allclose(
        found, render(device, lists, name.format("msaa=1")), rtol=0, atol=allowed
    )


@pytest.mark.parametrize("name", ["opacity_map[node=precise,{}]", "fourier_map[node=precise,{}]"])
def test_masks_take_four_bits_of_each_depth(device: Device, name: str) -> None:
    lists = random_lists(12, side=8)
    found = render(device, lists, name.format("msaa=4"))
    np.testing.assert_allclose(found, render(device, lists, name.format("msaa=1")), atol=1e-4)


@pytest.mark.parametrize("layers", [20, 40])
def test_masks_do_not_depend_on_the_order_of_the_draws(device: Device, layers: int) -> None:
    lists = collection().build_scene(f"fragment_lists[width=8,height=8,layers={layers},ties=true]")
    with opened(device, lists, "a_buffer[msaa=4]") as frame:
        assert_order_independent(frame, 3)


def test_single_targets_do_not_add_radiance_to_transmittance(device: Device) -> None:
    """Depth at pixel centers is a separate draw, which must not enable radiance again."""
    sheet = Material(coverage=0.5, emission=(5.0, 5.0, 5.0))
    item = Object("sheet", quad((0, 0, -2), (4, 0, 0), (0, 4, 0)), sheet)
    scene = Scene("sheet", Camera((0, 0, 0), (0, 0, -1)), (item,))
    for msaa in (1, 4):
        with opened(device, scene, f"stochastic[msaa={msaa}]", (16, 16)) as frame:
            frame.render(transmittance=True)
            np.testing.assert_allclose(frame.image().mean(), 0.5, atol=0.1)
