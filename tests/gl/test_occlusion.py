"""Ambient occlusion dims only the environment light; edges of binary coverage infer it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.gl.frame import Frame, Image
from oitbench.measure import accounting
from oitbench.modeling.mesh import quad
from oitbench.plugins import Collection
from oitbench.scene import (
    Camera,
    DirectionalLight,
    EnvironmentLight,
    Light,
    Material,
    Object,
    Scene,
    Texture,
)
from tests.helpers import method, opened, render

SIDE = 96
SIZE = (SIDE, SIDE)
HALF_FLOAT = 2.0**-11
GRAY = Material(albedo=(0.5, 0.5, 0.5))
BLACK = Material()
AO, INFERRED = Effect.AMBIENT_OCCLUSION, Effect.INFERRED_AO
SKY = (EnvironmentLight(),)
# Rows of the floor that are at least a radius from the wall, and rows of the crease.
FLOOR, CREASE = slice(3 * SIDE // 4, SIDE), slice(SIDE // 2 - 1, SIDE // 2 + 1)


def corner(
    wall: bool = True, radius: float = 0.2, lights: tuple[Light, ...] = SKY, tilt: float = 1.0
) -> Scene:
    """Return a floor and a wall that meet in the middle of the picture."""
    camera = Camera(position=(0, tilt, 1), target=(0, 0, 0), fov_y=math.radians(40))
    objects = [Object("floor", quad((0, 0, 0), (3, 0, 0), (0, 0, -3)), GRAY)]
    if wall:
        objects.append(Object("wall", quad((0, 3, 0), (3, 0, 0), (0, 3, 0)), GRAY))
    return Scene("corner", camera, tuple(objects), lights=lights, ambient_occlusion=radius)


def round_leaf(soft: float = 0.3, most: float = 1.0) -> Texture:
    """Return a disk of coverage `most` that falls to zero over a rim of width `soft`."""
    line = (np.arange(64) + 0.5) / 32 - 1
    x, y = np.meshgrid(line, line)
    return Texture(np.clip((0.8 - np.hypot(x, y)) / soft, 0, most).astype(np.float32))


def leaf(
    coverage: Texture | float | None = None,
    radius: float = 0.2,
    behind: tuple[Object, ...] | None = None,
    binary: bool = True,
) -> Scene:
    """Return one white leaf half a meter in front of a black wall."""
    camera = Camera(position=(0, 0, 2), target=(0, 0, 0), fov_y=math.radians(60))
    wall = (Object("wall", quad((0, 0, -0.5), (4, 0, 0), (0, 4, 0)), BLACK),)
    described = Material(
        coverage=round_leaf() if coverage is None else coverage,
        albedo=(0.8, 0.8, 0.8),
        binary_coverage=binary,
    )
    card = Object("leaf", quad((0, 0, 0), (0.8, 0, 0), (0, 0.8, 0)), described)
    objects = (*(wall if behind is None else behind), card)
    return Scene("leaf", camera, objects, lights=SKY, ambient_occlusion=radius)


def openness(frame: Frame) -> npt.NDArray[np.float64]:
    """Return the openness of each pixel, top row first."""
    assert frame.occlusion is not None
    frame.occlusion.prepare()
    data = np.frombuffer(frame.occlusion.samplers["openness_texture"].read(), dtype=np.uint8)
    return data.reshape(frame.plan.size[::-1])[::-1] / 255.0


def set_openness(frame: Frame, values: npt.NDArray[np.float64] | float) -> None:
    """Replace the openness of the frame by `values`, top row first."""
    assert frame.occlusion is not None
    frame.occlusion.prepare()
    texels = np.broadcast_to(np.round(255 * np.asarray(values)), frame.plan.size[::-1])[::-1]
    frame.occlusion.samplers["openness_texture"].write(texels.astype(np.uint8).tobytes())


def found_openness(device: Device, scene: Scene) -> npt.NDArray[np.float64]:
    with opened(device, scene, "alpha_blend", SIZE) as frame:
        return openness(frame)


def with_openness(
    device: Device, scene: Scene, values: npt.NDArray[np.float64] | float, **options: Any
) -> Image:
    with opened(device, scene, "alpha_blend", SIZE, **options) as frame:
        set_openness(frame, values)
        frame.render()
        return frame.image()


def coverage_of(device: Device, scene: Scene) -> Image:
    """Return the leaf's coverage at each pixel."""
    # Half floats would round the opacity of edges.
    precise = "alpha_blend[precision=float]"
    with opened(device, scene, precise, SIZE, effects=Effect.COVERAGE) as frame:
        frame.render(transmittance=True)
        return 1 - frame.image()[..., 0]


# The estimator


@pytest.mark.parametrize("tilt", [0.1, 0.5, 2.0])
def test_a_plane_is_not_occluded(device: Device, tilt: float) -> None:
    found = found_openness(device, corner(wall=False, tilt=tilt))
    assert found.min() >= 1 - 1 / 255


def test_a_crease_is_half_open(device: Device) -> None:
    found = found_openness(device, corner(radius=2.0))[:, SIDE // 4 : -SIDE // 4]
    # A wall hides half of the cosine-weighted hemisphere; pixels are slightly off the crease.
    assert found[CREASE].mean() == pytest.approx(0.5, abs=0.04)
    assert (np.diff(found[SIDE // 2 : FLOOR.start].mean(axis=1)) > 0).all()


def test_a_plane_is_not_occluded_beyond_the_radius(device: Device) -> None:
    found = found_openness(device, corner(radius=0.2))
    assert found[FLOOR].min() >= 1 - 1 / 255
    assert found[CREASE].max() < 0.75
    # Floor and wall are symmetric; the sampling pattern is not.
    np.testing.assert_allclose(found, found[::-1], atol=0.05)


def test_the_filter_leaves_no_pattern(device: Device) -> None:
    found = found_openness(device, corner(radius=0.5))[:, SIDE // 4 : -SIDE // 4]
    assert found.std(axis=1).max() < 0.01


def test_an_object_far_in_front_of_a_surface_does_not_occlude_it(device: Device) -> None:
    near = Object("bar", quad((0, 0, 0.5), (0.2, 0, 0), (0, 2, 0)), GRAY)
    wall = Object("wall", quad((0, 0, -0.5), (4, 0, 0), (0, 4, 0)), GRAY)
    scene = leaf(radius=0.3, behind=(wall, near))
    found = found_openness(device, replace(scene, objects=scene.objects[:2]))
    assert found.min() >= 1 - 1 / 255


# Shading


def test_openness_dims_the_environment_light(device: Device) -> None:
    with opened(device, corner(), "alpha_blend", SIZE) as frame:
        frame.render()
        np.testing.assert_allclose(
            frame.image()[..., 0], 0.5 * openness(frame), rtol=0, atol=4 * HALF_FLOAT
        )


def test_direct_light_is_not_dimmed(device: Device) -> None:
    sun = DirectionalLight((0.3, -1.0, -0.8), (2.0, 1.0, 0.5))
    scene = corner(lights=(sun, EnvironmentLight((0.0, 0.0, 0.0))))
    dimmed, plain = (
        render(device, scene, "alpha_blend", size=SIZE, effects=effects)
        for effects in (scene.effects, scene.effects & ~AO)
    )
    assert plain.max() > 0.2
    np.testing.assert_array_equal(dimmed, plain)


@pytest.mark.parametrize("name", ["alpha_blend", "a_buffer"])
def test_a_radius_of_zero_changes_nothing(device: Device, name: str) -> None:
    scene = leaf(radius=0.0)
    assert not scene.effects & (AO | INFERRED)
    plain = render(device, scene, name, size=SIZE)
    with opened(device, scene, name, SIZE, effects=scene.effects | AO | INFERRED) as frame:
        frame.render()
        np.testing.assert_array_equal(frame.image(), plain)


def test_scenes_without_ambient_occlusion_have_no_pass_for_it(device: Device) -> None:
    scene = leaf()
    for described, effects in (
        (scene, scene.effects & ~AO),
        (leaf(radius=0.0), scene.effects),
        (replace(scene, lights=()), scene.effects),
    ):
        device.programs.clear()
        with opened(device, described, "alpha_blend", SIZE, effects=effects) as frame:
            frame.render()
            assert frame.occlusion is None
            assert not any("openness" in fragment and "occluders" in fragment
                           for _, fragment in device.programs)  # fmt: skip


def test_its_cost_belongs_to_shading(device: Device) -> None:
    with opened(device, leaf(), "alpha_blend", SIZE) as frame:
        frame.render()
        measured = frame.measure()
        account = accounting.shading(frame, measured)
        assert [record.name for record in measured.shading] == [
            "occluders", "occlusion", "occlusion filter",
        ]  # fmt: skip
        # The wall fills the picture, and the interior of the leaf is in front of it.
        pixels = SIDE * SIDE
        drawn, *screens = (record.fragments for record in measured.shading)
        assert screens == [pixels, pixels]
        assert pixels < drawn < 2 * pixels
        memory = {term.resource: term.bytes for term in account.memory.terms}
        assert memory == {"occluders": 4 * pixels, "raw": pixels, "openness": pixels}
        written = [term for term in account.traffic.terms if term.kind == "write"]
        assert sum(term.bytes for term in written) == 4 * drawn + 2 * pixels
        assert len(measured.passes) == len(frame.plan.passes)


# Edges of binary coverage


@pytest.mark.parametrize("soft", [0.3, 0.02])
def test_edges_infer_a_constant_openness_exactly(device: Device, soft: float) -> None:
    scene = leaf(round_leaf(soft))
    whole, part = (with_openness(device, scene, value) for value in (1.0, 0.4))
    assert whole.max() > 0.5
    np.testing.assert_allclose(part, 0.4 * whole, rtol=0, atol=4 * HALF_FLOAT)


def test_a_leaf_of_constant_coverage_infers_from_its_surroundings(device: Device) -> None:
    # It has neither a gradient nor an interior, so only the wall has an openness.
    scene = leaf(0.5)
    whole, part = (with_openness(device, scene, value) for value in (1.0, 0.4))
    np.testing.assert_allclose(part, 0.4 * whole, rtol=0, atol=4 * HALF_FLOAT)


def test_small_weights_do_not_darken(device: Device) -> None:
    # Without an interior, all samples are on a wall 40 m away. Their weights sum to 0.003.
    wall = Object("wall", quad((0, 0, -40), (80, 0, 0), (0, 80, 0)), BLACK)
    scene = leaf(round_leaf(0.3, 0.9), behind=(wall,))
    inferred = with_openness(device, scene, 1.0)
    plain = with_openness(device, scene, 1.0, effects=scene.effects & ~INFERRED)
    assert plain.max() > 0.5
    np.testing.assert_allclose(inferred, plain, rtol=0, atol=4 * HALF_FLOAT)


def test_edges_have_the_openness_of_the_interior_and_not_of_the_wall_behind(device: Device) -> None:
    scene = leaf()
    alpha = coverage_of(device, scene)
    inside = alpha >= 254 / 255
    split = np.where(inside, 0.2, 1.0)
    inferred = with_openness(device, scene, split)[..., 0]
    bright = with_openness(device, scene, split, effects=scene.effects & ~INFERRED)[..., 0]
    edge = (alpha > 0.1) & (alpha < 0.9)
    assert edge.sum() > 100
    np.testing.assert_allclose(bright[edge], 0.8 * alpha[edge], rtol=0.01)
    np.testing.assert_allclose(inferred[edge], 0.2 * 0.8 * alpha[edge], rtol=0.15)
    np.testing.assert_allclose(inferred[inside], 0.2 * 0.8, rtol=0.01)


def test_a_fragment_with_nothing_nearby_is_not_occluded(device: Device) -> None:
    scene = leaf(0.5, behind=())
    dark, open_ = (with_openness(device, scene, value) for value in (0.0, 1.0))
    np.testing.assert_array_equal(dark, open_)


def test_other_transparent_surfaces_are_not_occluded(device: Device) -> None:
    scene = leaf(binary=False)
    assert INFERRED not in scene.effects
    forced = scene.effects | INFERRED
    dark, open_ = (with_openness(device, scene, value, effects=forced) for value in (0.0, 1.0))
    np.testing.assert_array_equal(dark, open_)


# Interiors of binary coverage


@pytest.mark.parametrize("running", [AO, AO | INFERRED])
def test_interiors_are_left_out_of_the_fragments(device: Device, running: Effect) -> None:
    scene = leaf()
    alpha = coverage_of(device, scene)[::-1]
    with opened(device, scene, "alpha_blend", SIZE, effects=Effect.COVERAGE) as frame:
        every = frame.scene.fragment_counts(SIZE)
        part = frame.scene.fragment_counts(SIZE, Effect.COVERAGE | running)
        np.testing.assert_array_equal(every == 1, alpha > 0)
        np.testing.assert_array_equal(every - part, alpha >= 254 / 255)
        assert 0 < part.sum() < every.sum()


@pytest.mark.parametrize(
    "name",
    ["a_buffer", "depth_peeling", "hashed_alpha", "sorted_over", "weighted_blended",
     "stochastic[samples=4,msaa=4]"],
)  # fmt: skip
def test_interiors_are_part_of_the_opaque_picture_of_every_method(
    device: Device, name: str
) -> None:
    scene = leaf()
    with opened(device, scene, name, SIZE) as frame:
        frame.render()
        opaque = frame.read("opaque_color")[..., :3]
        inside = coverage_of(device, scene) >= 254 / 255
        assert inside.sum() > 500
        np.testing.assert_array_equal(frame.image()[inside], opaque[inside])
        assert opaque[inside].min() > 0.3
        if frame.plan.samples == 1:
            assert (frame.complexity[::-1][inside] == 0).all()


def test_opaque_interiors_change_a_picture_by_at_most_their_threshold(
    device: Device,
) -> None:
    scene = leaf()
    split = with_openness(device, scene, 1.0)
    plain = render(device, scene, "alpha_blend", size=SIZE, effects=Effect.COVERAGE)
    np.testing.assert_allclose(split, plain, rtol=0, atol=1 / 255)


# Figure 6 of McGuire & Mara 2017


def test_foliage_under_the_sky_has_bright_outlines_without_inference(device: Device) -> None:
    scene = Collection.load().build_scene("foliage[light=sky,detail=0.05]")
    assert {"SHADOWS", "TRANSLUCENT_SHADOWS", "AMBIENT_OCCLUSION", "INFERRED_AO"} <= {
        effect.name for effect in scene.effects
    }
    # Sunlight is the same in all three images; it has no shadows here, for speed.
    sky = scene.effects & ~(Effect.SHADOWS | Effect.TRANSLUCENT_SHADOWS)
    size = (2 * SIDE, 2 * SIDE)
    flat, outlined, consistent = (
        render(device, scene, method("a_buffer"), size=size, effects=effects)
        for effects in (sky & ~(AO | INFERRED), sky & ~INFERRED, sky)
    )
    assert (consistent <= outlined + 4 * HALF_FLOAT).all()
    assert ((outlined - consistent).max(axis=-1) > 0.1).mean() > 0.01
    assert consistent.mean() < outlined.mean() < flat.mean()
    assert np.isfinite(consistent).all()
