"""Particles in targets of a lower resolution, and declarations of such targets."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from oitbench.errors import DeclarationError
from oitbench.gl.device import Device
from oitbench.gl.draws.records import FrameMeasurement
from oitbench.gl.frame import Frame, Image
from oitbench.measure import accounting
from oitbench.method.declaration import Request
from oitbench.modeling.mesh import box, quad
from oitbench.scene import RGB, WHITE, Camera, Material, Medium, Object, Scene
from tests.helpers import foreign_method, method, opened, render, write_method

SIZE = (64, 48)
PIXELS = 64 * 48
BLOCKS = 16 * 12
CAMERA = Camera((0, 0, 0), (0, 0, -1))
FULL, MIXED = "phenomenological", "phenomenological[subsample=4]"
EXACT, EXACT_MIXED = (f"phenomenological[precision=float{more}]" for more in ("", ",subsample=4"))
STEP = 1 / 255


def sheet(
    name: str, z: float, material: Material, left: float = -9.0, smoke: bool = False
) -> Object:
    """Return a sheet at distance z, right of `left` (in units of z). Default: it fills the view."""
    width = 9 * z
    mesh = quad((left * z + width, 0, -z), (width, 0, 0), (0, width, 0))
    return Object(name, mesh, material, particles=smoke)


def smoke(z: float, coverage: float, emission: RGB = WHITE, left: float = -9.0) -> Object:
    material = Material(coverage=coverage, emission=emission)
    return sheet(f"smoke {z}", z, material, left, smoke=True)


def scene(*objects: Object) -> Scene:
    return Scene("mixed", CAMERA, objects, background=(0.2, 0.5, 0.7))


def rendered(frame: Frame) -> tuple[Image, FrameMeasurement]:
    frame.render()
    measured = frame.measure()
    return frame.image(), measured


@pytest.mark.parametrize("msaa", [1, 4])
def test_uniform_smoke_is_the_same_at_any_resolution(device: Device, msaa: int) -> None:
    glass = sheet("glass", 3.0, Material(transmission=(0.9, 0.4, 0.2)), left=0.05)
    mixed = scene(smoke(2, 0.3), glass, smoke(4, 0.6, (0.2, 0.9, 0.4)))
    full, *others = (
        render(device, mixed, f"{EXACT[:-1]},subsample={subsample},msaa={msaa}]", size=SIZE)
        for subsample in (1, 2, 4)
    )
    for found in others:
        np.testing.assert_allclose(found, full, atol=2e-6)


def test_other_objects_keep_their_resolution(device: Device) -> None:
    # An edge of glass in the middle of a block.
    glass = sheet("glass", 3.0, Material(coverage=0.5, emission=(3, 0, 0)), left=0.031)
    clear = smoke(2, 0.0)
    np.testing.assert_array_equal(
        render(device, scene(clear, glass), MIXED, size=SIZE),
        render(device, scene(clear, glass), FULL, size=SIZE),
    )


@pytest.mark.parametrize("size", [(64, 48), (67, 50), (3, 5)])
def test_a_block_covers_its_pixels(device: Device, size: tuple[int, int]) -> None:
    # The depth of a slope is linear in 1/z, so the center of a block has the mean of its pixels.
    slope = Object("slope", quad((0, 0, -4), (9, 0, 4), (0, 9, 0)), Material(coverage=0.5))
    found = {}
    for chosen in (EXACT, EXACT_MIXED):
        smooth = Object("slope", slope.mesh, slope.material, particles=True)
        with opened(device, scene(smooth), chosen, size) as frame:
            frame.render()
            found[chosen] = frame.read("small_accum" if chosen == EXACT_MIXED else "accum")[..., 3]
    full, small = found[EXACT][::-1], found[EXACT_MIXED][::-1]
    assert small.shape == (-(-size[1] // 4), -(-size[0] // 4))
    rows, columns = size[1] // 4, size[0] // 4
    blocks = full[: 4 * rows, : 4 * columns].reshape(rows, 4, columns, 4)
    # The weight is convex: the center is below the mean, by less than the change over a pixel.
    np.testing.assert_allclose(small[:rows, :columns], blocks.mean(axis=(1, 3)), rtol=5e-3)


def test_blur_is_in_pixels_of_the_frame(device: Device) -> None:
    frosted = Material(coverage=0.9, emission=WHITE, collimation=0.8)
    wall = sheet("wall", 5.0, Material(emission=(0.4, 0.2, 0.1)))
    veil = sheet("veil", 2.0, frosted, smoke=True)
    variance = {}
    for chosen in (EXACT, EXACT_MIXED):
        with opened(device, scene(wall, veil), chosen, SIZE) as frame:
            frame.render()
            variance[chosen] = frame.read("beta")[..., 3]
    assert variance[EXACT].min() > 1
    np.testing.assert_allclose(variance[EXACT_MIXED], variance[EXACT], rtol=1e-5)


@pytest.mark.parametrize("msaa", [1, 4])
@pytest.mark.parametrize("edge", [0.0, 0.03, 0.06, 0.09])
def test_smoke_does_not_bleed_over_the_edge_of_an_object_in_front_of_it(
    device: Device, edge: float, msaa: int
) -> None:
    board = sheet("board", 2.0, Material(emission=(0.01, 0.01, 0.01)), left=edge)
    dense = scene(board, smoke(4, 0.9), smoke(5, 0.9))
    full, mixed = (
        render(device, dense, f"{FULL}[subsample={subsample},msaa={msaa}]", size=SIZE)[24]
        for subsample in (1, 4)
    )
    first = int(np.argmin(full[:, 0]))  # the first column that the board covers
    assert 30 < first < 40
    difference = abs(mixed - full).max(axis=-1)
    # Less than a step of the display, although smoke is a hundred times as bright as the board.
    beside = np.r_[difference[: first - 1], difference[first + 1 :]]
    assert beside.max() < STEP
    assert full[first - 2, 0] > 0.9


def test_smoke_in_front_of_an_edge_is_uniform(device: Device) -> None:
    board = sheet("board", 6.0, Material(emission=(0.4, 0.2, 0.1)), left=0.02)
    near = scene(board, smoke(2, 0.5))
    full, mixed = (render(device, near, name, size=SIZE) for name in (EXACT, EXACT_MIXED))
    np.testing.assert_allclose(mixed, full, atol=2e-6)


def test_smoke_in_front_of_an_oblique_ground_has_no_stripes(device: Device) -> None:
    # From block to block the ground recedes by more than the width of the filter's depth key.
    plain = quad((0, -1, -50), (90, 0, 0), (0, 0, -49.5))
    ground = Object("ground", plain, Material(emission=WHITE))
    banks = [smoke(2 * 1.1**k, 0.1, (0.2, 0.2, 0.2)) for k in range(24)]
    full, mixed = (
        render(device, scene(ground, *banks), name, size=(16, 192))[105:, 8, 0]
        for name in (EXACT, EXACT_MIXED)
    )
    np.testing.assert_allclose(mixed, full, atol=0.04)
    # A key that ignores the slope gives ten times as much curvature.
    assert abs(np.diff(mixed, 2)).sum() < 0.05
    assert (np.diff(mixed) > 0).all()


def test_a_thin_object_between_the_texels_of_blocks_has_smoke_in_front_of_it(
    device: Device,
) -> None:
    # Half a pixel wide and beside the sample of its block: no small texel contains it.
    post = Object("post", quad((0.019, 0, -3), (0.012, 0, 0), (0, 9, 0)), Material(emission=WHITE))
    mixed = render(device, scene(post, smoke(2, 0.9, (0.1, 0.1, 0.1))), MIXED, size=SIZE)
    assert np.isfinite(mixed).all()
    assert mixed[24].max() < 0.25


def test_scenes_without_particles_have_no_small_targets(device: Device) -> None:
    glass = scene(sheet("glass", 3.0, Material(coverage=0.5, emission=WHITE)))
    names, bits = {}, {}
    for chosen in (FULL, MIXED):
        with opened(device, glass, chosen, SIZE) as frame:
            names[chosen] = [item.name for item in frame.plan.passes]
            bits[chosen] = accounting.memory(frame)
    assert names[MIXED] == names[FULL] == ["gather", "resolve"]
    assert bits[MIXED] == bits[FULL]


def test_scenes_of_particles_alone_have_no_full_gather(device: Device) -> None:
    with opened(device, scene(smoke(2, 0.5)), MIXED, SIZE) as frame:
        names = [item.name for item in frame.plan.passes]
    assert names == ["shrink_depth", "gather small=1", "upsample", "resolve"]


def test_memory_and_traffic_count_the_texels_of_small_targets(device: Device) -> None:
    glass = sheet("glass", 3.0, Material(coverage=0.5, emission=WHITE))
    with opened(device, scene(smoke(2, 0.5), smoke(4, 0.5), glass), MIXED, SIZE) as frame:
        _, measured = rendered(frame)
        memory = {item.resource: item.bytes for item in accounting.memory(frame).terms}
        terms = accounting.traffic(frame, measured).terms
    assert memory == {
        "accum": 8 * PIXELS, "beta": 3 * PIXELS, "small_accum": 8 * BLOCKS,
        "small_beta": 3 * BLOCKS, "small_distance": 4 * BLOCKS, "small_depth": 4 * BLOCKS,
    }  # fmt: skip
    moved = {(t.pass_, t.resource, t.kind): t.items for t in terms}
    assert moved["gather", "accum", "write"] == PIXELS
    assert moved["gather small=1", "small_accum", "write"] == 2 * BLOCKS
    assert moved["shrink_depth", "opaque_depth", "read"] == BLOCKS
    assert moved["shrink_depth", "small_depth", "write"] == BLOCKS
    assert moved["upsample", "small_accum", "read"] == BLOCKS
    assert moved["upsample", "accum", "blend"] == PIXELS
    assert moved["clear", "small_accum", "clear"] == BLOCKS


def test_blocks_keep_one_sample(device: Device) -> None:
    glass = sheet("glass", 3.0, Material(coverage=0.5, emission=WHITE))
    chosen = f"{MIXED[:-1]},msaa=4]"
    with opened(device, scene(smoke(2, 0.5), glass), chosen, SIZE) as frame:
        memory = {item.resource: item.bytes for item in accounting.memory(frame).terms}
    assert memory == {
        "accum": 4 * 8 * PIXELS, "beta": 4 * 3 * PIXELS, "small_accum": 8 * BLOCKS,
        "small_beta": 3 * BLOCKS, "small_distance": 4 * BLOCKS, "small_depth": 4 * BLOCKS,
    }  # fmt: skip


def test_fog_in_blocks_leaves_refraction_at_the_frame_s_resolution(device: Device) -> None:
    clear = Medium(1e-7, (-9, -9, -4), (9, 9, -1), albedo=WHITE)
    bend = Material(coverage=0.8, transmission=(0.9, 0.5, 0.7), index=1.5, solid=True)
    block = Object("block", box((0.2, 0, -3), (1.0, 0.7, 0.4)), bend)
    wall = Object("wall", quad((0, 0, -5), (1, 0.3, 0), (-0.3, 1, 0)), Material(emission=WHITE))
    seen = replace(scene(block, wall), medium=clear)
    full, mixed = (render(device, seen, name, size=SIZE) for name in (EXACT, EXACT_MIXED))
    np.testing.assert_allclose(mixed, full, atol=1e-5)
    with opened(device, seen, EXACT_MIXED, SIZE) as frame:
        assert "small_delta" not in frame.plan.targets
        frame.render()
        assert abs(frame.read("delta")).max() > 1


TARGETS = """{
    "whole": Target("r32f"),
    "part": Target("r32f", subsample=2),
    "depth": Target("depth32f", subsample=2),
}"""
BUFFERS = '{"heads": Buffer({"first": "uint"}, Items.PIXELS)}'


@pytest.mark.parametrize(
    ("declared", "message"),
    [
        (
            'Resolve("one.glsl", writes={"part": ADD, "whole": ADD})',
            "one size: part 1/2, whole 1/1",
        ),
        ('Gather("one.glsl", writes={"part": ADD})', "one size: part 1/2, opaque_depth 1/1"),
        (
            'Resolve("one.glsl", writes={"part": ADD}, buffers=("heads",))',
            "a pass with buffers must have the frame's size",
        ),
        (
            'Gather("one.glsl", reads=("depth",), writes={"part": ADD}, depth="depth")',
            "reads and tests 'depth'",
        ),
        ('Gather("one.glsl", writes={"part": ADD}, depth="dept")', "unknown target 'dept'"),
        ('Gather("one.glsl", writes={"whole": ADD}, depth="part")', "depth 'part' is r32f"),
        ('Gather("one.glsl", depth="opaque_depth")', "the opaque depth cannot be written"),
    ],
)
def test_a_pass_that_mixes_sizes_is_refused(
    device: Device, tmp_path: Path, declared: str, message: str
) -> None:
    folder = write_method(tmp_path / "small", f"({declared},)", TARGETS, BUFFERS, one="")
    chosen = foreign_method(folder)
    refused = pytest.raises(DeclarationError, match=message)
    with refused, opened(device, scene(smoke(2, 0.5)), chosen, SIZE):
        pass


def test_a_resolve_can_write_the_depth_that_a_gather_tests(device: Device, tmp_path: Path) -> None:
    targets = """{
        "part": Target("r32f", subsample=2),
        "depth": Target("depth32f", clear=(1.0,), subsample=2),
    }"""
    passes = """(
        Resolve("fill.glsl", depth="depth"),
        Gather("count.glsl", writes={"part": ADD}, depth="depth", depth_writes=False),
    )"""
    # The depth is that of a wall at 3 m in the left half of the frame, and of nothing elsewhere.
    fill = "void resolve() { gl_FragDepth = gl_FragCoord.x < 16.0 ? 0.1 / 3.0 : 0.0; }"
    count = "void gather(Fragment fragment) { part = 1.0; }"
    folder = write_method(tmp_path / "tested", passes, targets, fill=fill, count=count)
    chosen = foreign_method(folder)
    with opened(device, scene(smoke(2, 0.5), smoke(4, 0.5)), chosen, SIZE) as frame:
        frame.render()
        part = frame.read("part")[..., 0]
    assert part.shape == (24, 32)
    assert (part[:, :16] == 1).all()
    assert (part[:, 16:] == 2).all()


def test_subsampling_is_off_by_default() -> None:
    plain, mixed = method(FULL), method(MIXED)
    every = Request(plain.shows, particles=True)
    assert not any(target.subsample > 1 for target in plain.plan(every).targets.values())
    assert len(mixed.plan(every).passes) == len(plain.plan(every).passes) + 3
