"""Refracting solids that touch, overlap or contain each other, in both path tracers."""

from __future__ import annotations

import dataclasses
import math
from itertools import pairwise

import numpy as np
import pytest

from oitbench.modeling.mesh import box, quad, sphere
from oitbench.path_traced.matched.render import matched
from oitbench.path_traced.trace.render import render
from oitbench.scene import (
    WHITE,
    Camera,
    EnvironmentLight,
    Floats,
    Material,
    Medium,
    Mesh,
    Object,
    Scene,
)
from oitbench.scene.texturing import constant
from tests.path_traced.agreement import assert_mean, needs_mitsuba

pytestmark = needs_mitsuba

GLASS = Material(transmission=WHITE, index=1.5, roughness=0.0, solid=True)
WATER = dataclasses.replace(GLASS, index=1.33)
AHEAD = Camera((0.0, 0.0, 4.0), fov_y=0.01)
WALL = Object("wall", quad((0, 0, -9), (30, 0, 0), (0, 30, 0)), Material(emission=WHITE))
DARK = Object("dark", quad((0, 0, 5), (30, 0, 0), (0, 30, 0)), Material())
FURNACE = EnvironmentLight((1.0, 2.0, 3.0))


def _pile(*indices: float) -> float:
    """Return the transmittance of parallel interfaces between media, in all orders."""
    passed, back = 1.0, 0.0
    for a, b in pairwise(indices):
        face = ((a - b) / (a + b)) ** 2
        passed, back = (
            passed * (1 - face) / (1 - back * face),
            face + (1 - face) ** 2 * back / (1 - back * face),
        )
    return passed


def _slab(name: str, far: float, near: float, material: Material, priority: int = 0) -> Object:
    """Return a wide slab between two depths."""
    mesh = box((0, 0, (far + near) / 2), (100, 100, near - far))
    return Object(name, mesh, material, priority=priority)


def _matched(*objects: Object, camera: Camera = AHEAD) -> Floats:
    """Return a matched pixel."""
    scene = Scene("nested", camera, (*objects, WALL))
    return np.asarray(matched(scene, (4, 4), 1).mean(axis=(0, 1)), dtype=np.float64)


def _assert_passed(expected: float, *objects: Object) -> None:
    """Check what passes `objects` before a white wall, in both path tracers."""
    np.testing.assert_allclose(_matched(*objects), expected, atol=6e-4)
    scene = Scene("nested", AHEAD, (*objects, WALL, DARK))
    assert_mean(render(scene, (16, 16), 1, 256), np.full(3, expected))


@pytest.mark.parametrize("reach", [0.0, 0.05, 0.3], ids=["touch", "overlap", "overlap more"])
@pytest.mark.parametrize("first", [True, False], ids=["glass first", "water first"])
def test_water_that_touches_glass_or_reaches_into_it(reach: float, first: bool) -> None:
    glass = _slab("glass", -1.0, 0.0, GLASS, 0 if first else 1)
    water = _slab("water", -3.0, -1.0 + reach, WATER)
    pair = (glass, water) if first else (water, glass)
    assert _pile(1, 1.5, 1.33, 1) == pytest.approx(0.9383, abs=1e-4)
    _assert_passed(_pile(1, 1.5, 1.33, 1), *pair)


def test_water_and_glass_apart_have_four_faces() -> None:
    # In a matched picture, the water's face mirrors the environment instead of the glass.
    objects = _slab("glass", -1.0, 0.0, GLASS), _slab("water", -3.0, -1.05, WATER)
    estimate = render(Scene("apart", AHEAD, (*objects, WALL, DARK)), (16, 16), 1, 256)
    assert_mean(estimate, [_pile(1, 1.5, 1, 1.33, 1)] * 3)


def _straight(item: Object, length: float) -> float:
    """Return what the absorption of `item` lets pass over a length."""
    size = np.ptp(item.mesh.positions, axis=0)
    volume, area = size.prod(), 2 * (size * np.roll(size, 1)).sum()
    return float(constant(item.material.transmission)[0] ** (2 * length / (4 * volume / area)))


@pytest.mark.parametrize("priority", [-1, 1])
def test_the_solid_of_higher_priority_absorbs(priority: int) -> None:
    # Equal indices: there is no reflection between the solids.
    gray = dataclasses.replace(GLASS, transmission=(0.5, 0.5, 0.5))
    pale = dataclasses.replace(GLASS, transmission=(0.9, 0.9, 0.9))
    one, other = _slab("gray", -1.0, 0.0, gray), _slab("pale", -1.6, -0.6, pale, priority)
    own = 1.0 if priority < 0 else 0.6
    passed = _straight(one, own) * _straight(other, 1.6 - own)
    face = 0.04
    expected = (1 - face) ** 2 * passed / (1 - face**2 * passed**2)
    _assert_passed(expected, one, other)


def test_a_solid_inside_of_another_one_is_seen_by_its_relative_index() -> None:
    water = _slab("water", -3.0, 0.0, WATER)
    pane = _slab("pane", -2.0, -1.0, GLASS, 1)
    _assert_passed(_pile(1, 1.33, 1.5, 1.33, 1), water, pane)
    below = dataclasses.replace(pane, priority=-1)
    _assert_passed(_pile(1, 1.33, 1), water, below)


@pytest.mark.parametrize("reversed_order", [False, True])
def test_equal_solids_are_one(reversed_order: bool) -> None:
    pair = _slab("one", -1.0, 0.0, GLASS), _slab("other", -1.0, 0.0, WATER)
    index = 1.33 if reversed_order else 1.5
    _assert_passed(_pile(1, index, 1), *(pair[::-1] if reversed_order else pair))


def test_the_first_solid_of_the_scene_fills_the_space_whatever_else_is_of_its_material() -> None:
    gray = dataclasses.replace(GLASS, transmission=(0.5, 0.5, 0.5))
    pair = _slab("water", -3.0, -0.5, WATER), _slab("gray", -1.0, 0.0, gray)
    beside = Object("beside", box((300, 0, 0), (1, 1, 1)), gray)
    np.testing.assert_array_equal(_matched(beside, *pair), _matched(*pair))


def _inverted(mesh: Mesh) -> Mesh:
    normals = None if mesh.normals is None else -mesh.normals
    return dataclasses.replace(mesh, triangles=mesh.triangles[:, ::-1].copy(), normals=normals)


def _joined(one: Mesh, other: Mesh) -> Mesh:
    normals = None
    if one.normals is not None and other.normals is not None:
        normals = np.concatenate([one.normals, other.normals])
    return Mesh(
        np.concatenate([one.positions, other.positions]),
        np.concatenate([one.triangles, other.triangles + np.uint32(len(one.positions))]),
        normals=normals,
    )


@pytest.mark.parametrize("curved", [False, True])
def test_a_vessel_full_of_clear_water_is_invisible_in_a_furnace(curved: bool) -> None:
    if curved:
        outer, inner = sphere((0, 0, 0), 1.2, 32, 16), sphere((0, 0, 0), 1.0, 32, 16)
    else:
        outer, inner = box((0, 0, 0), (2, 2, 2)), box((0, 0, 0), (1.6, 1.6, 1.6))
    vessel = Object("vessel", _joined(outer, _inverted(inner)), GLASS, priority=1)
    camera = Camera((1.0, 2.0, 4.0), fov_y=0.4)
    scene = Scene("vessel", camera, (vessel, Object("water", inner, WATER)), lights=(FURNACE,))
    expected = np.tile((1.0, 2.0, 3.0), (16, 16, 1))
    np.testing.assert_allclose(matched(scene, (16, 16), 1), expected, rtol=0.02)
    np.testing.assert_allclose(render(scene, (16, 16), 1, 4).mean, expected, rtol=1e-4)


def test_a_camera_inside_of_glass_sees_through_one_face() -> None:
    glass = _slab("glass", -1.0, 5.0, GLASS)
    expected = _pile(1.5, 1)
    # Light that returns from the face does not return again from a dark wall.
    dark = Object("dark", quad((0, 0, 4.5), (30, 0, 0), (0, 30, 0)), Material())
    np.testing.assert_allclose(_matched(glass, dark), expected, atol=1e-4)
    assert_mean(render(Scene("in", AHEAD, (glass, dark, WALL)), (16, 16), 1, 256), [expected] * 3)


def test_a_camera_inside_of_glass_sees_the_absorption_on_its_way() -> None:
    glass = _slab("glass", -1.0, 5.0, dataclasses.replace(GLASS, transmission=(0.5, 0.5, 0.5)))
    # Rays start on the near plane.
    straight = _straight(glass, 5.0 - AHEAD.near)
    dark = Object("dark", quad((0, 0, 4.5), (30, 0, 0), (0, 30, 0)), Material())
    estimate = render(Scene("in", AHEAD, (glass, dark, WALL)), (16, 16), 1, 256)
    assert_mean(estimate, [0.96 * straight] * 3)


def test_a_camera_inside_of_a_medium_sees_the_fog_before_it() -> None:
    fog = Medium(0.2, (-50.0, -50.0, -5.0), (50.0, 50.0, 50.0), albedo=(0.0, 0.0, 0.0))
    scene = Scene("fog", AHEAD, (WALL,), medium=fog)
    expected = math.exp(-0.2 * (AHEAD.position[2] + 5 - AHEAD.near))
    np.testing.assert_allclose(matched(scene, (4, 4), 1), expected, rtol=1e-3)
    assert_mean(render(scene, (32, 32), 1, 64), [expected] * 3)
