"""The A-buffer against double precision, for any lists, order of draws and memory."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from oitbench import COUNT, Gather, Plan, Request
from oitbench.errors import CapabilityError
from oitbench.gl.capabilities import ATOMICS, FETCH, MECHANISMS
from oitbench.gl.device import Device
from oitbench.gl.frame import Frame
from oitbench.measure.oracle import composite
from oitbench.scene import Floats, FragmentLists, Scene
from tests.helpers import (
    BLUE,
    RED,
    Layer,
    assert_order_independent,
    assert_same,
    collection,
    method,
    opened,
    random_lists,
    render,
    scene_of,
    stack,
)

RESOLVES = ("sorted", "iterative")
STORAGES = ("counted", "linked")


def lists_scene(body: str) -> tuple[Scene, FragmentLists]:
    scene = collection().build_scene(f"fragment_lists[{body}]")
    assert scene.lists is not None
    return scene, scene.lists


def error(device: Device, scene: Scene, lists: FragmentLists, name: str) -> float:
    return float(abs(render(device, scene, name) - composite(lists, scene.background)).max())


def compact_bound(lists: FragmentLists, background: Floats) -> Floats:
    """Return the largest error of packed records, shape (h, w, 3).

    Compositing from far to near is C <- c + (1 - o) C. With errors of half a step h = 1/510 in c
    and o, the error E is at most E <- h + h C + (1 - o + h) E. The picture is rounded to 16 bits.
    """
    half = 1 / 510
    order = np.argsort(-lists.z, axis=0, kind="stable")
    color, error = np.broadcast_to(background, (*lists.z.shape[1:], 3)), np.zeros(())
    for rank in order:
        here = (rank, *np.indices(rank.shape))
        alpha = lists.coverage[here][..., None].astype(float)
        error = half + half * color + (1 - alpha + half) * error
        color = alpha * lists.radiance[here] + (1 - alpha) * color
    return np.asarray(error + 2.0**-10 * (color + error + 1))


def test_each_of_65536_random_lists_is_exact(device: Device) -> None:
    scene, lists = lists_scene("layers=64,tinted=true")
    assert lists.z[0].size == 65536
    expected = composite(lists, scene.background)
    for resolve in RESOLVES:
        found = render(device, scene, f"a_buffer[resolve={resolve}]")
        assert abs(found - expected).max() <= 2e-5


@pytest.mark.parametrize("resolve", RESOLVES)
@pytest.mark.parametrize("body", ["tinted=true", "hdr=true,tinted=true", "ties=true,tinted=true"])
def test_tints_high_dynamic_range_and_ties_are_exact(
    device: Device, resolve: str, body: str
) -> None:
    scene, lists = lists_scene(f"width=64,height=64,layers=24,{body}")
    brightest = float(lists.radiance.max())
    assert error(device, scene, lists, f"a_buffer[resolve={resolve}]") <= 2e-6 * max(1, brightest)


@pytest.mark.parametrize("storage", STORAGES)
@pytest.mark.parametrize("resolve", RESOLVES)
def test_700_layers_per_pixel_are_exact(device: Device, resolve: str, storage: str) -> None:
    side = "width=16,height=16" if resolve == "sorted" else "width=8,height=8"
    scene, lists = lists_scene(f"{side},layers=700,alpha_low=0.001,alpha_high=0.02,tinted=true")
    name = f"a_buffer[resolve={resolve},storage={storage}]"
    assert error(device, scene, lists, name) <= 2e-5


@pytest.mark.parametrize("layers", [1, 2, 31, 32, 33, 64, 65])
def test_lists_around_the_size_of_a_batch_are_exact(device: Device, layers: int) -> None:
    lists = random_lists(layers, tinted=True)
    for storage in STORAGES:
        assert error(device, scene_of(lists), lists, f"a_buffer[storage={storage}]") <= 2e-6


@pytest.mark.parametrize("ties", ["true", "false"])
@pytest.mark.parametrize("layers", [24, 40])
@pytest.mark.parametrize("node", ["precise", "compact"])
def test_both_kinds_of_lists_and_counters_give_one_picture(
    device: Device, node: str, layers: int, ties: str
) -> None:
    scene, _ = lists_scene(f"width=16,height=16,tinted=true,layers={layers},ties={ties}")
    expected = render(device, scene, f"a_buffer[node={node}]")
    for mechanism in (FETCH, ATOMICS) if device.has(MECHANISMS[FETCH]) else (ATOMICS,):
        found = render(device, scene, f"a_buffer[node={node},storage=counted]", mechanism=mechanism)
        np.testing.assert_array_equal(found, expected)


def test_fragments_beyond_the_counted_ones_do_not_reach_the_next_list(
    device: Device, tmp_path: Path
) -> None:
    (tmp_path / "few.glsl").write_text(
        "void gather(Fragment fragment) { if (fragment.z < 2.5) { count_stored(); } }"
    )
    chosen = method("a_buffer[storage=counted]")
    base = type(chosen)

    class Few(base):  # type: ignore[misc, valid-type]
        folders = (tmp_path, *base.folders)

        def plan(self, request: Request) -> Plan:
            plan = super().plan(request)
            few = Gather("few.glsl", writes={"stored": COUNT})
            return Plan(plan.targets, (few, *plan.passes[1:]), plan.buffers)

    # Each pixel has a color of its own, in both layers.
    colors = np.random.default_rng(1).random((4, 4, 3), dtype=np.float32)
    lists = stack([Layer(2.0, 0.5, RED), Layer(3.0, 0.5, RED)], side=4)
    lists = replace(lists, radiance=np.stack([colors, colors]))
    found = render(device, scene_of(lists, BLUE), Few(**chosen.values))
    np.testing.assert_allclose(found, 0.5 * colors + 0.5 * np.array(BLUE), atol=1e-6)


@pytest.mark.parametrize("copies", [2, 33, 70])
def test_all_copies_of_a_layer_are_composited(device: Device, copies: int) -> None:
    lists = stack([Layer(2.0, 0.03, RED)] * copies + [Layer(3.0, 0.5, BLUE)], side=4)
    for resolve in RESOLVES:
        assert error(device, scene_of(lists), lists, f"a_buffer[resolve={resolve}]") <= 2e-6


@pytest.mark.parametrize("resolve", RESOLVES)
def test_the_error_of_packed_records_is_within_its_bound(device: Device, resolve: str) -> None:
    scene, lists = lists_scene("width=64,height=64,layers=24")
    found = render(device, scene, f"a_buffer[node=compact,resolve={resolve}]")
    expected = composite(lists, scene.background)
    bound = compact_bound(lists, np.asarray(scene.background))
    assert (abs(found - expected) <= bound).all()
    # The bound is small, and the error is not zero.
    assert bound.max() < 0.06
    assert abs(found - expected).max() > 1e-3


@pytest.mark.parametrize("body", ["ties=true,layers=20", "layers=40"])
@pytest.mark.parametrize("node", ["precise", "compact"])
def test_ten_orders_of_the_draws_give_the_same_picture(
    device: Device, node: str, body: str
) -> None:
    scene, _ = lists_scene(f"width=48,height=48,tinted=true,{body}")
    with opened(device, scene, f"a_buffer[node={node}]") as frame:
        assert_order_independent(frame, 10)


def test_permutations_shuffle_the_draws(device: Device) -> None:
    scene, _ = lists_scene("width=8,height=8,layers=20")
    pictures = [render(device, scene, "alpha_blend", permutation=seed) for seed in (1, 2)]
    assert abs(pictures[0] - pictures[1]).max() > 0.1


@pytest.mark.parametrize("name", ["a_buffer", "a_buffer[resolve=iterative]"])
def test_a_frame_in_several_regions_is_the_same(device: Device, name: str) -> None:
    scene, _ = lists_scene("width=200,height=130,layers=4,tinted=true")
    whole = render(device, scene, name)
    # One tile of 64 × 64 pixels has 16384 fragments, each with a vec4.
    with opened(device, scene, name, block_limit=16 * 2 * 16384) as frame:
        assert len(frame.resources.regions) > 4
        frame.render()
        assert_same(device, frame.image(), whole, name, 4)
        # A timed frame has no checks between regions, and is the same too.
        frame.restore()
        frame.composite()
        assert_same(device, frame.image(), whole, name, 4)


def test_a_tile_that_does_not_fit_in_a_block_is_refused(device: Device) -> None:
    scene, _ = lists_scene("width=64,height=64,layers=4")
    # Enough for a word per pixel, but not for a vec4 per fragment.
    refused = pytest.raises(CapabilityError, match="in one 64×64 tile exceed the driver's limit")
    with refused, opened(device, scene, "a_buffer", block_limit=4 * 64 * 64):
        pass


def limit_memory(frame: Frame, records: int) -> None:
    """Reduce the memory of the frame to `records` in each tile."""
    frame.resources.reserve(np.full(frame.resources.tiles, records, dtype=np.int64))


@pytest.mark.parametrize("records", [0, 1, 12000])
@pytest.mark.parametrize("block_limit", [None, 16 * 2 * 16384])
def test_the_frame_is_repeated_with_more_memory_if_it_runs_out(
    device: Device, records: int, block_limit: int | None
) -> None:
    scene, lists = lists_scene("width=150,height=70,layers=4,tinted=true")
    with opened(device, scene, "a_buffer", block_limit=block_limit) as frame:
        frame.render()
        limit_memory(frame, records)
        frame.restore()
        frame.composite()
        assert abs(frame.image() - composite(lists, scene.background)).max() > 0.01
        frame.render()
        fragments = np.array([[16384, 16384, 5632], [1536, 1536, 528]])
        np.testing.assert_array_equal(frame.resources.demand, np.maximum(fragments, records))
        assert abs(frame.image() - composite(lists, scene.background)).max() <= 2e-6
        # The memory is sufficient for the next frame.
        complete = frame.image()
        frame.restore()
        frame.composite()
        np.testing.assert_array_equal(frame.image(), complete)


def test_two_layers_over_a_background_equal_a_hand_example(device: Device) -> None:
    lists = stack([Layer(2.0, 0.45, (0.0, 1.0, 0.0)), Layer(1.0, 0.45, RED)], side=4)
    found = render(device, scene_of(lists, BLUE), "a_buffer")
    assert found[0, 0] == pytest.approx([0.45, 0.2475, 0.3025], abs=1e-6)
