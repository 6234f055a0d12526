"""Rendering: statistics, seeds, variants, and refused input."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from oitbench.errors import CapabilityError, SceneError, UsageError
from oitbench.modeling.mesh import box, quad
from oitbench.path_traced import llvm
from oitbench.path_traced.trace.integrators import is_straight
from oitbench.path_traced.trace.path_tracer import is_random
from oitbench.path_traced.trace.render import Tracing, render
from oitbench.path_traced.trace.sections import Section, estimate
from oitbench.scene import Camera, DirectionalLight, FragmentLists, Material, Object, Scene
from tests.path_traced.agreement import needs_mitsuba

FRONT = Camera((0.0, 0.0, 4.0))
SQUARE = quad((0, 0, 0), (3, 0, 0), (0, 3, 0))
LAMP = DirectionalLight((0.0, 0.0, -1.0))
GLASS = Material(transmission=(0.9, 0.5, 0.2), index=1.5)
PAPER = Material(albedo=(0.8, 0.5, 0.2))


def _scene(material: Material) -> Scene:
    return Scene("square", FRONT, (Object("square", SQUARE, material),))


def test_statistics_equal_those_of_numpy() -> None:
    samples = np.random.default_rng(2).random((5, 2, 3, 3)).astype(np.float32)
    sections = [Section.empty((3, 2)) for _ in range(3)]
    for number, sample in enumerate(samples):
        sections[number // 2].add(sample, number % 2, 1)
    found = estimate(sections)
    np.testing.assert_allclose(found.mean, samples.mean(axis=0), rtol=1e-6)
    np.testing.assert_allclose(found.variance, samples.var(axis=0, ddof=1) / 5, rtol=1e-5)
    np.testing.assert_allclose(found.halves[0], samples[::2].mean(axis=0), rtol=1e-6)
    np.testing.assert_allclose(found.halves[1], samples[1::2].mean(axis=0), rtol=1e-6)


def test_sections_share_all_groups_in_order() -> None:
    scene = _scene(GLASS)
    for spp in (2, 7, 8, 30):
        tracing = Tracing((4, 4), 1, spp, 1)
        count = tracing.sections(scene)
        assert count == min(8, spp)
        sections = [tracing.groups(scene, number) for number in range(count)]
        assert [group for section in sections for group in section] == list(range(spp))
        assert all(sections)


@needs_mitsuba
def test_the_image_depends_on_the_seed() -> None:
    glass = dataclasses.replace(GLASS, solid=True)
    slab = Object("slab", box((0, 0, 0), (4, 4, 0.5)), glass)
    wall = Object("wall", quad((0, 0, -3), (9, 0, 0), (0, 9, 0)), Material(emission=(1, 1, 1)))
    scene = Scene("slab", Camera((0.0, 0.0, 6.0), fov_y=0.02), (slab, wall))
    first, again, other = (render(scene, (4, 4), seed=seed).mean for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()


def test_only_scenes_that_scatter_need_random_numbers() -> None:
    plain = _scene(Material(0.5, transmission=(0.2, 0.5, 0.9)))
    assert is_straight(plain)
    lit = dataclasses.replace(plain, lights=(LAMP,))
    assert not is_straight(lit)
    assert not is_random(lit)
    for material in (GLASS, Material(0.5, (0.2, 0.5, 0.9), collimation=0.5)):
        scene = _scene(material)
        assert is_random(scene)
        assert not is_straight(scene)


def test_bad_sizes_are_refused() -> None:
    for size, ssaa, spp in (((0, 4), 1, 2), ((4, 4), 0, 2), ((4, 4), 1, 1)):
        with pytest.raises(UsageError):
            render(_scene(PAPER), size, ssaa, spp)


@needs_mitsuba
def test_fragment_lists_are_refused() -> None:
    layer = np.ones((1, 2, 2), dtype=np.float32)
    color = np.ones((1, 2, 2, 3), dtype=np.float32)
    scene = Scene("lists", FRONT, lists=FragmentLists(layer, layer, color, color))
    with pytest.raises(
        CapabilityError, match=r"scene lists: .* cannot be path traced; give the scene meshes"
    ):
        render(scene, (2, 2))


@needs_mitsuba
def test_triangles_that_coincide_exactly_are_refused() -> None:
    turned = dataclasses.replace(SQUARE, triangles=np.array([(3, 0, 1)], dtype=np.uint32))
    objects = tuple(Object(n, m, Material(0.5)) for n, m in (("a", SQUARE), ("b", turned)))
    with pytest.raises(CapabilityError, match="2 triangles coincide exactly, as in a and b"):
        render(Scene("same", FRONT, objects), (2, 2))


@needs_mitsuba
def test_lights_need_llvm() -> None:
    scene = dataclasses.replace(_scene(PAPER), lights=(LAMP,))
    with pytest.raises(CapabilityError, match="with LLVM only; apt install"):
        render(scene, (2, 2), variant=llvm.SLOW_VARIANT)


@needs_mitsuba
def test_radiance_that_is_not_finite_is_an_error() -> None:
    bright = Material(0.5, (1.0, 1.0, 1.0), (3e38, 3e38, 3e38))
    films = tuple(
        Object(str(i), quad((0, 0, -0.1 * i), (3, 0, 0), (0, 3, 0)), bright) for i in range(6)
    )
    with pytest.raises(SceneError, match="not finite"):
        render(Scene("bright", FRONT, films), (2, 2))


@needs_mitsuba
def test_surfaces_that_coincide_are_refused_by_name() -> None:
    red = Material(0.5, emission=(1.0, 0.0, 0.0))
    other = quad((0.5, 0.2, 0), (2, 1, 0), (-1, 2, 0))
    scene = _scene(PAPER)
    decal = dataclasses.replace(scene, objects=(*scene.objects, Object("decal", other, red)))
    with pytest.raises(CapabilityError, match="square and decal lie in one plane, so that a ray"):
        render(decal, (4, 4))
    beside = quad((9, 0, 0), (1, 0, 0), (0, 1, 0))
    apart = dataclasses.replace(scene, objects=(*scene.objects, Object("beside", beside, red)))
    assert np.isfinite(render(apart, (4, 4)).mean).all()
