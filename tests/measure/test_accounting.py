"""Memory and traffic follow from declarations and from counted fragments."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from oitbench.gl.device import Device
from oitbench.gl.draws.records import PassRecord
from oitbench.gl.frame import Frame
from oitbench.measure import accounting
from oitbench.method.passes import Gather
from oitbench.modeling.mesh import quad
from oitbench.results.schema import MemoryTerm, TrafficTerm
from oitbench.scene import WHITE, Camera, Material, Object, Scene
from tests.helpers import (
    assert_same,
    bits_per_pixel,
    collection,
    method,
    opened,
    random_lists,
    render,
    scene_of,
)

SIZE = (96, 70)
PIXELS = 96 * 70
TILES = 2 * 2
BLENDING = {"blend", "write"}


@pytest.fixture
def planes() -> Scene:
    """Four planes that fill the view: four fragments in every pixel."""
    return collection().build_scene("layer_stack[count=4]")


@pytest.fixture
def half_hidden() -> Scene:
    """Three panes; one wall hides half of the middle pane, another one hides the farthest."""
    panes = [
        Object(f"pane {z}", quad((0, 0, -z), (0.5, 0, 0), (0, 0.5, 0)), Material(coverage=0.5))
        for z in (2.0, 4.0, 6.0)
    ]
    wall = Object("wall", quad((5, 0, -3), (5, 0, 0), (0, 9, 0)), Material(emission=WHITE))
    behind = Object("back", quad((0, 0, -5), (9, 0, 0), (0, 9, 0)), Material(emission=WHITE))
    return Scene("hidden", Camera((0, 0, 0), (0, 0, -1)), (*panes, wall, behind))


def measured(frame: Frame) -> tuple[list[TrafficTerm], list[PassRecord]]:
    """Render, then measure another frame; return its traffic and its passes."""
    frame.render()
    measured = frame.measure()
    return accounting.traffic(frame, measured).terms, measured.passes


def total(terms: list[TrafficTerm], pass_: str, *kinds: str) -> int:
    return sum(t.bytes for t in terms if t.pass_ == pass_ and (not kinds or t.kind in kinds))


@pytest.mark.parametrize(("node", "payload"), [("compact", 8), ("precise", 28)])
@pytest.mark.parametrize(
    ("storage", "link", "heads"),
    [("linked", 4, {"heads": 4}), ("counted", 0, {"heads": 8, "stored": 4})],
)
def test_an_a_buffer_has_heads_at_pixels_and_one_record_per_fragment(
    device: Device,
    planes: Scene,
    node: str,
    payload: int,
    storage: str,
    link: int,
    heads: dict[str, int],
) -> None:
    with opened(device, planes, f"a_buffer[node={node},storage={storage}]", SIZE) as frame:
        facts = accounting.memory(frame)
        assert facts.terms == [
            *(MemoryTerm(name, size * PIXELS) for name, size in heads.items()),
            MemoryTerm("nodes", (link + payload) * 4 * PIXELS),
            MemoryTerm("nodes allocator", 8 * TILES),
        ]
        assert facts.bytes == sum(term.bytes for term in facts.terms)


@pytest.mark.parametrize(
    ("name", "bits"),
    [("weighted_blended", 72), ("alpha_blend", 0), ("sorted_over", 0), ("sorted_two_pass", 0)],
)
def test_methods_without_lists_have_a_fixed_number_of_bits_per_pixel(
    device: Device, planes: Scene, name: str, bits: int
) -> None:
    assert bits_per_pixel(device, planes, name, size=SIZE) == bits


@pytest.mark.parametrize(
    ("name", "size"),
    [
        ("alpha_blend", 16),
        ("sorted_over", 16),
        ("sorted_over[sort=object]", 16),
        ("sorted_two_pass", 32),
        ("sorted_two_pass[sort=triangle]", 32),
        ("weighted_blended", 18),
    ],
)
def test_blending_has_a_fixed_number_of_bytes_per_fragment(
    device: Device, planes: Scene, name: str, size: int
) -> None:
    with opened(device, planes, name, SIZE) as frame:
        terms, records = measured(frame)
        gathers = {item.name for item in frame.plan.passes if isinstance(item, Gather)}
        moved = sum(total(terms, gather, *BLENDING) for gather in gathers)
        assert moved == size * 4 * PIXELS
        assert {r.name: r.fragments for r in records if r.name in gathers} == dict.fromkeys(
            gathers, 4 * PIXELS
        )


def test_weighted_blending_reads_its_targets_once(device: Device, planes: Scene) -> None:
    with opened(device, planes, "weighted_blended", SIZE) as frame:
        terms, _ = measured(frame)
        reads = {t.resource: t.bytes for t in terms if t.kind == "read"}
        assert reads == {"accum": 8 * PIXELS, "reveal": PIXELS}
        assert total(terms, "clear") == 9 * PIXELS
        assert total(terms, "resolve", *BLENDING) == 16 * PIXELS


@pytest.mark.parametrize(("node", "payload"), [("compact", 8), ("precise", 28)])
def test_counted_lists_write_and_read_each_record_once(
    device: Device, planes: Scene, node: str, payload: int
) -> None:
    with opened(
        device, planes, f"a_buffer[node={node},storage=counted]", SIZE, counted=True
    ) as frame:
        terms, _ = measured(frame)
        fragments = 4 * PIXELS
        assert total(terms, "count") == 8 * fragments
        assert {(t.resource, t.kind): t.bytes for t in terms if t.pass_ == "allocate"} == {
            ("stored", "read"): 4 * PIXELS,
            ("heads", "write"): 8 * PIXELS,
            ("nodes.allocator", "atomic"): 8 * PIXELS,
        }
        assert total(terms, "capture", "write") == (4 + payload) * fragments
        assert total(terms, "capture", "blend", "read") == (4 + 8) * fragments
        assert total(terms, "resolve_sorted", "read") == 12 * PIXELS + payload * fragments
        assert {t.kind for t in terms if t.pass_ == "capture"} == {
            "clear",
            "write",
            "blend",
            "read",
        }
        # All targets at the start of the frame, and the number of stored fragments once more.
        assert total(terms, "clear") + total(terms, "capture", "clear") == 16 * PIXELS


@pytest.mark.parametrize(("node", "payload"), [("compact", 8), ("precise", 28)])
def test_linked_lists_write_and_read_each_record_once(
    device: Device, planes: Scene, node: str, payload: int
) -> None:
    name = f"a_buffer[node={node},storage=linked]"
    with opened(device, planes, name, SIZE, counted=True) as frame:
        terms, _ = measured(frame)
        fragments = 4 * PIXELS
        # The link and the payload of each record.
        assert total(terms, "capture", "write") == (4 + payload) * fragments
        atomics = {t.resource: t.bytes for t in terms if t.kind == "atomic"}
        assert atomics == {"heads.first": 8 * fragments, "nodes.allocator": 8 * fragments}
        assert total(terms, "capture", "read") == 0
        assert total(terms, "resolve_sorted", "read") == 4 * PIXELS + (4 + payload) * fragments
        assert total(terms, "clear") == 4 * PIXELS


def test_the_iterative_resolve_reads_a_quadratic_number_of_records(device: Device) -> None:
    scene = scene_of(random_lists(5))
    name = "a_buffer[node=compact,resolve=iterative,storage=linked]"
    with opened(device, scene, name, counted=True) as frame:
        terms, _ = measured(frame)
        heads, once, square = 4 * 256, 12 * 5 * 256, 12 * 5 * 5 * 256
        # The last round follows the links and finds no further record.
        last = (4 + 5 * 4) * 256
        assert total(terms, "resolve_iterative", "read") == heads + once + square + last


def test_measuring_twice_counts_one_frame(device: Device, planes: Scene) -> None:
    with opened(device, planes, "a_buffer", SIZE, counted=True) as frame:
        first, _ = measured(frame)
        frame.render(permutation=1)
        second, _ = measured(frame)
        assert first == second


@pytest.mark.parametrize(
    "name", ["a_buffer", "a_buffer[resolve=iterative]", "a_buffer[node=compact]"]
)
def test_counting_changes_no_pixel(device: Device, name: str) -> None:
    scene = scene_of(random_lists(9, tinted=True))
    plain, counted = (render(device, scene, name, counted=on) for on in (False, True))
    assert_same(device, counted, plain, name, 9)


@pytest.mark.parametrize(
    "name", ["a_buffer", "alpha_blend", "sorted_over", "sorted_two_pass", "weighted_blended"]
)
def test_hidden_fragments_are_not_counted(device: Device, half_hidden: Scene, name: str) -> None:
    with opened(device, half_hidden, name, (64, 64), counted=True) as frame:
        terms, records = measured(frame)
        counts = Counter(frame.complexity.ravel().tolist())
        # The near pane is visible, and so is the left half of the middle one.
        assert set(counts) == {0, 1, 2}
        visible = counts[1] + 2 * counts[2]
        gathers = [r for r in records if r.name in {t.pass_ for t in terms} and r.fragments != 4096]
        assert {r.fragments for r in gathers} == {visible}
        seen = np.count_nonzero(render(device, half_hidden, "a_buffer", size=(64, 64))[..., 0] < 1)
        assert seen == counts[1] + counts[2]
        if name == "a_buffer":
            assert sum(
                t.items for t in terms if t.resource == "nodes.depth" and t.kind == "write"
            ) == (visible)


def test_every_method_of_the_suite_has_an_account(device: Device, planes: Scene) -> None:
    for name in collection().methods:
        with opened(device, planes, method(name), (16, 16), counted=True) as frame:
            terms, _ = measured(frame)
            assert all(term.items > 0 and term.bytes_per_item > 0 for term in terms)
            kinds = {term.kind for term in terms}
            assert kinds <= {"clear", "read", "write", "blend", "atomic"}
