"""Demands of methods, against values that were derived by hand, and against what frames count."""

from __future__ import annotations

import pytest

from oitbench.errors import DeclarationError
from oitbench.gl.device import Device
from oitbench.measure import accounting
from oitbench.method.blending import ADD, COMPOSITE, OVER, PROGRAMMABLE
from oitbench.method.declaration import Method, Plan, Request
from oitbench.method.demands import CLASSES, NOTHING, Demands, default_demands
from oitbench.method.passes import Gather, Interleaved, Loop, Objects, Resolve, Step
from oitbench.method.storage import Target
from tests.helpers import method, opened, random_lists, scene_of

# label: class, geometry passes, targets of a pass, bits of tile memory, bits of a fragment
BY_HAND: dict[str, tuple[str, int | None, int, int, int]] = {
    # One blended RGBA16F: 64 bits, read and written.
    "alpha_blend": ("blending", 1, 1, 64, 128),
    "alpha_blend[precision=float]": ("blending", 1, 1, 128, 256),
    # Both passes alternate over one target.
    "sorted_two_pass": ("blending", 2, 1, 64, 256),
    "sorted_over": ("dual-source", 1, 1, 64, 128),
    # Color replaced, own depth tested and written; four samples of both.
    "alpha_to_coverage": ("blending", 1, 1, 4 * (64 + 32), 4 * (64 + 64)),
    # The opaque depth is read, too.
    "hashed_alpha": ("blending", 1, 1, 64 + 32, 32 + 64 + 64),
    # RGBA16F and R16F, RGBA16F and R8: 20 and 18 bytes a fragment.
    "weighted_average": ("targets", 1, 2, 80, 160),
    "weighted_blended": ("targets", 1, 2, 72, 144),
    "weighted_blended[msaa=4]": ("targets", 1, 2, 4 * 72, 4 * 144),
    # RGBA16F, RGBA8 and RG8: 112 bits as published; the opaque depth is read.
    "phenomenological": ("targets", 1, 3, 112, 2 * 112 + 32),
    # 16 depths of a sample, four to a target; passes: total, depths, colors.
    "stochastic": ("targets", 3, 4, 16 * 32, 2 * 16 + 2 * 16 * 32 + 16 * 32 + 2 * 64),
    # Depths keep one sample per pixel.
    "stochastic[msaa=4]": ("targets", 3, 4, 16 * 32, 4 * 32 + 3 * 16 * 32 + 4 * 128),
    # Two rounds of 32 depths.
    "stochastic[samples=64]": ("targets", 5, 8, 32 * 32, 32 + 2 * (3 * 32 * 32 + 128)),
    # b_0 and six moments; composite reads them and blends RGBA32F.
    "moments": ("targets", 2, 4, 7 * 32, 3 * 7 * 32 + 256),
    "moments[storage=unorm16]": ("interlock", 2, 4, 128, 3 * 128 + 256),
    # Bounds of 8 bytes are read twice after they are blended; 16 floats.
    "wavelet": ("targets", 3, 4, 16 * 32, 2 * 64 + 2 * 64 + 3 * 512 + 256),
    # Three curves one after another, over bounds that are found once; dual-source resolve.
    "wavelet[channels=rgb]": ("dual-source", 7, 4, 512, 128 + 3 * (128 + 3 * 512 + 256)),
    # k nodes of 8 bytes, read and written.
    "multilayer_alpha": ("interlock", 1, 2, 4 * 64, 2 * 4 * 64),
    "k_buffer[k=16,node=32f]": ("interlock", 1, 20, 16 * 160, 2 * 16 * 160),
    # Lists: head exchanged, record written, and read in each pass over pixels.
    "a_buffer[node=compact]": ("atomics", 1, 1, 64, 64 + 2 * 96),
    "a_buffer[node=compact,msaa=4]": ("atomics", 1, 1, 4 * 64, 64 + 3 * 96),
    # Counted twice; first record and count are read; records have no link.
    "a_buffer[node=compact,storage=counted]": ("atomics", 2, 1, 64, 2 * 64 + 64 + 2 * 64),
    "adaptive": ("atomics", 1, 1, 64, 64 + 3 * 96),
    "adaptive[memory=fixed]": ("interlock", 2, 4, 512, 3 * 512 + 256),
    # A pass for each layer: depth 32, and RGBA16F of color and of transmittance.
    "depth_peeling": ("dual-source", None, 2, 32 + 2 * 64, 2 * 32 + 2 * 32 + 2 * 64),
    "depth_peeling[layers=4]": ("dual-source", 4, 2, 160, 4 * 256),
    # All effects: seven targets with RG32F bounds and six RGBA32F.
    "dual_depth_peeling[layers=4]": ("dual-source", 3, 7, 832, 128 + 2 * (64 + 2 * 832)),
}


@pytest.mark.parametrize("label", BY_HAND)
def test_demands_equal_those_derived_by_hand(label: str) -> None:
    found = default_demands(method(label))
    numbers = (found.geometry_passes, found.targets, found.tile_bits, found.fragment_bits)
    assert (found.capability_class, *numbers) == BY_HAND[label]


@pytest.mark.parametrize(
    ("label", "samples", "offered", "fixed"),
    [
        ("hashed_alpha", 1, (1,), True),
        ("weighted_sum", 1, (1, 4), True),
        ("weighted_blended", 1, (1, 4), True),
        ("weighted_blended[msaa=4]", 4, (1, 4), True),
        ("alpha_to_coverage", 4, (4, 8), True),
        ("a_buffer", 1, (1, 4), False),
        ("depth_peeling", 1, (1,), False),
        ("depth_peeling[layers=3]", 1, (1,), True),
    ],
)
def test_samples_and_growth(
    label: str, samples: int, offered: tuple[int, ...], fixed: bool
) -> None:
    found = default_demands(method(label))
    assert (found.samples, found.offered, found.has_fixed_cost) == (samples, offered, fixed)


@pytest.mark.parametrize(
    "label",
    [
        "alpha_blend",
        "depth_layered",
        "depth_peeling[layers=1]",
        "moments",
        "multilayer_alpha_buckets",
        "phenomenological[precision=half]",
        "stochastic[samples=64]",
        "wavelet[rank=2]",
    ],
)
def test_bits_of_a_fragment_are_those_that_a_frame_counts(device: Device, label: str) -> None:
    """Every fragment passes every test here, since there is one layer and nothing opaque."""
    lists = random_lists(1)
    with opened(device, scene_of(lists), method(label)) as frame:
        frame.render()
        measured = frame.measure()
        terms = accounting.traffic(frame, measured).terms
        gathers = {item.name for item in frame.plan.passes if isinstance(item, Gather)}
        moved = [t for t in terms if t.pass_ in gathers and t.kind != "clear"]
        fragments = lists.z.shape[1] * lists.z.shape[2]
        assert frame.plan.demands.fragment_bits * fragments == 8 * sum(t.bytes for t in moved)


def demands(*steps: Step, requires: tuple[str, ...] = ()) -> Demands:
    """Return the demands of a method with these steps and two targets."""
    needed = requires

    class Made(Method):
        name = "made"
        requires = needed

        def plan(self, request: Request) -> Plan:
            return Plan({"a": Target("r32f"), "b": Target("rgba8")}, steps)

    return default_demands(Made())


def test_an_empty_plan_demands_nothing() -> None:
    assert demands() == NOTHING
    assert NOTHING.capability_class == "blending"


def test_the_class_is_the_highest_that_a_pass_needs() -> None:
    plain = Gather("a.glsl", writes={"a": ADD})
    both = Resolve("b.glsl", writes={"a": ADD, "b": OVER})
    dual = Resolve("c.glsl", writes={"color": COMPOSITE})
    shader = Gather("d.glsl", writes={"a": PROGRAMMABLE})
    steps: tuple[Step, ...] = (plain, both, dual, shader)
    found = [demands(*steps[:count]).capability_class for count in range(1, 5)]
    assert found == list(CLASSES)[:4]


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("dual_source", "dual-source"),
        ("framebuffer_fetch", "interlock"),
        ("interlock", "interlock"),
        ("image_load_store", "atomics"),
        ("post_depth_coverage", "blending"),
    ],
)
def test_required_extensions_count_whatever_the_plan_says(name: str, expected: str) -> None:
    assert demands(requires=(name,)).capability_class == expected


def test_alternating_passes_share_tile_memory_and_others_do_not() -> None:
    one, other = Gather("a.glsl", writes={"a": ADD}), Gather("b.glsl", writes={"b": ADD})
    assert demands(one, other).tile_bits == 32
    assert demands(Interleaved((one, other))).tile_bits == 64
    assert demands(one, other).geometry_passes == 2


def test_passes_over_different_objects_draw_all_geometry_once() -> None:
    particles = Gather("a.glsl", writes={"a": ADD}, objects=Objects.PARTICLES)
    others = Gather("b.glsl", writes={"color": ADD}, objects=Objects.OTHERS)
    found = demands(particles, others)
    assert (found.geometry_passes, found.fragment_bits) == (1, 128)


def test_a_loop_needs_an_end() -> None:
    with pytest.raises(DeclarationError, match="the loop has no end"):
        Loop((Gather("a.glsl"),))
