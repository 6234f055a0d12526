"""Depth peeling from one end and from both: truncation, equal depths and intersections."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from oitbench.gl.device import Device
from oitbench.gl.frame import Frame
from oitbench.measure.oracle import composite
from oitbench.modeling.mesh import box
from oitbench.modeling.placement import rotation, transform
from oitbench.scene import Camera, FragmentLists, Material, Object, Scene
from tests.helpers import (
    BACKGROUND,
    BLUE,
    NOTHING,
    RED,
    WHITE,
    Layer,
    bits_per_pixel,
    collection,
    keeps_promises,
    opened,
    random_lists,
    render,
    scene_of,
    stack,
)
from tests.models.peeling import peeled


def runs(frame: Frame) -> dict[str, int]:
    """Render, and return the number of runs of each pass."""
    frame.render()
    measured = frame.measure()
    return {record.name: record.runs for record in measured.passes}


@settings(max_examples=30, deadline=None, derandomize=True)
@given(
    count=st.integers(1, 12),
    seed=st.integers(0, 2**32 - 1),
    layers=st.integers(0, 14),
    tinted=st.booleans(),
    name=st.sampled_from(["depth_peeling", "dual_depth_peeling"]),
)
def test_pictures_follow_the_model(
    device: Device, count: int, seed: int, layers: int, tinted: bool, name: str
) -> None:
    lists = random_lists(count, tinted=tinted, seed=seed)
    lists.z[:] = np.random.default_rng(seed).permuted(lists.z, axis=0)
    # Colors stay below one, so that a step of half floats is at most 2^-11.
    lists.radiance[:] *= 1 - lists.transmission
    expected = peeled(lists, BACKGROUND, layers, both_ends=name == "dual_depth_peeling")
    found = render(device, lists, f"{name}[layers={layers}]")
    steps = 3 + (4 * count if name == "depth_peeling" else 0)
    assert abs(found - expected).max() <= steps * 2.0**-11


@pytest.mark.parametrize("tinted", [False, True])
@pytest.mark.parametrize("name", ["depth_peeling[precision=float]", "dual_depth_peeling"])
def test_many_layers_are_exact(device: Device, name: str, tinted: bool) -> None:
    lists = random_lists(60, tinted=tinted)
    lists.coverage[:] *= np.float32(0.1)
    error = abs(render(device, lists, name) - composite(lists, BACKGROUND)).max()
    assert error <= (3 * 2.0**-11 if name == "dual_depth_peeling" else 1e-5)


@pytest.mark.parametrize("name", ["depth_peeling", "dual_depth_peeling"])
@pytest.mark.parametrize("scene", ["glass_bars", "layer_stack[count=7,transmission=colored]"])
def test_peeling_equals_the_a_buffer(device: Device, scene: str, name: str) -> None:
    built = collection().build_scene(scene)
    exact, found = (render(device, built, item, size=(96, 64)) for item in ("a_buffer", name))
    depth = 8
    assert (abs(found - exact) <= 4 * depth * 2.0**-11 * np.maximum(exact, 0.5)).all()


@pytest.mark.parametrize("count", [1, 2, 5, 6])
def test_peeling_ends_when_no_layer_is_left(device: Device, count: int) -> None:
    scene = scene_of(random_lists(count))
    with opened(device, scene, "depth_peeling") as frame:
        assert runs(frame)["peel"] == count + 1
    with opened(device, scene, "dual_depth_peeling") as frame:
        times = (count + 1) // 2
        assert runs(frame) == {
            "find": 1,
            "peel": times,
            "mark block=16": times,
            "combine": 1,
        }


def deep_in(lists: FragmentLists, rows: slice, columns: slice) -> Scene:
    """Return lists of which only the first layer is seen outside of some pixels."""
    inside = np.zeros(lists.coverage.shape[1:], bool)
    inside[rows, columns] = True
    coverage = lists.coverage * (inside | (np.arange(len(lists.coverage)) == 0)[:, None, None])
    return scene_of(replace(lists, coverage=coverage.astype(np.float32)), WHITE)


def test_passes_draw_only_the_rectangle_around_blocks_with_layers(device: Device) -> None:
    lists = random_lists(3, side=48)
    scene = deep_in(lists, slice(0, 17), slice(33, 34))
    with opened(device, scene, "depth_peeling") as frame:
        frame.render()
        counts = {record.name: record.fragments for record in frame.measure().passes}
    # All 9 blocks of 16 x 16 pixels have one layer, and 2 of them have more.
    assert counts["add"] == (9 + 9 + 2 + 2) * 16 * 16


@pytest.mark.parametrize("name", ["depth_peeling[precision=float]", "dual_depth_peeling"])
def test_finished_pixels_keep_their_layers(device: Device, name: str) -> None:
    """Targets that trade places hold old depths outside of the rectangle."""
    scene = deep_in(random_lists(9, side=48), slice(20, 21), slice(20, 21))
    found, exact = (render(device, scene, item) for item in (name, "a_buffer"))
    # `color` has half floats with dual peeling.
    np.testing.assert_allclose(found, exact, rtol=0, atol=3 * 2.0**-11 if "dual" in name else 1e-5)


@pytest.mark.parametrize(("layers", "times"), [(1, 1), (2, 1), (3, 2), (100, 3)])
def test_peeling_ends_after_the_given_number_of_layers(
    device: Device, layers: int, times: int
) -> None:
    scene = scene_of(random_lists(6))
    with opened(device, scene, f"dual_depth_peeling[layers={layers}]") as frame:
        assert runs(frame)["peel"] == times
    with opened(device, scene, f"depth_peeling[layers={layers}]") as frame:
        assert runs(frame)["peel"] == min(layers, 7)


def test_dual_peeling_composites_all_layers_of_equal_depth(device: Device) -> None:
    for count in (2, 3, 5):
        for others in ([], [Layer(2.0, 0.5, NOTHING)], [Layer(z, 0.5) for z in (2.0, 3.5, 4.0)]):
            lists = stack([Layer(3.0, 0.5, NOTHING)] * count + others)
            with opened(device, scene_of(lists, WHITE), "dual_depth_peeling") as frame:
                frame.render(transmittance=True)
                assert (frame.image() == 0.5 ** (count + len(others))).all()


def test_peeling_from_the_front_composites_one_layer_of_equal_depth(device: Device) -> None:
    # The order of the draws decides which one.
    pair = [Layer(3.0, 0.5, RED), Layer(3.0, 0.5, BLUE)]
    for layers, color in ((pair, RED), (pair[::-1], BLUE)):
        found = render(device, scene_of(stack(layers), WHITE), "depth_peeling")[0, 0]
        assert found == pytest.approx(0.5 * np.asarray(color) + 0.5)


def crossing_boxes() -> Scene:
    """Return two intersecting glass boxes, so near that their intersections cross the frame."""
    turn = rotation((1.0, 2.0, 3.0), 0.4)
    meshes = {"one": box((0, 0, 0), (1, 1, 1)), "other": transform(box((0, 0, 0), (1, 1, 1)), turn)}
    boxes = tuple(
        Object(name, mesh, Material(0.5, emission=color))
        for (name, mesh), color in zip(meshes.items(), (RED, BLUE), strict=True)
    )
    camera = Camera((0.35, 0.4, 0.9), (0.3, 0.3, 0.4), near=0.01)
    return Scene("crossing boxes", camera, boxes, background=WHITE)


def test_dual_peeling_has_no_gap_where_boxes_intersect(device: Device) -> None:
    scene, size = crossing_boxes(), (96, 96)
    exact = render(device, scene, "a_buffer", size=size)
    with opened(device, scene, "dual_depth_peeling", size) as frame:
        frame.render()
        # At an intersection two window depths can be equal: no layer is lost, but the order may be.
        wrong = (abs(frame.image() - exact) > 2.0**-10).any(axis=-1)
        assert wrong.sum() <= 4
        # Faces of both boxes are nearest in parts of the frame.
        nearest = exact[..., 0] > exact[..., 2]
        assert 0.05 < nearest.mean() < 0.95
        frame.render(transmittance=True)
        np.testing.assert_array_equal(frame.image()[::-1, :, 0], 0.5**frame.complexity)


def test_truncated_peeling_keeps_its_promises(device: Device) -> None:
    keeps_promises(device, "depth_peeling[layers=2]", "dual_depth_peeling[layers=3]")


def test_memory_depends_on_the_formats(device: Device) -> None:
    for tinted, dual in ((False, 48), (True, 112)):
        scene = scene_of(random_lists(2, tinted=tinted))
        for name, size in (
            ("depth_peeling", 40),
            ("depth_peeling[precision=float]", 72),
            ("dual_depth_peeling", dual),
        ):
            # And one mark of 8 bits for a block.
            assert bits_per_pixel(device, scene, name) == 8 * size + 8 / 16**2
