"""Caustics of refracting solids that touch, overlap or contain each other, by closed forms."""

from __future__ import annotations

import dataclasses
import importlib
import math
from collections.abc import Sequence

import numpy as np
import pytest

from oitbench.modeling.mesh import box, quad, sphere
from oitbench.modeling.placement import merge
from oitbench.path_traced import llvm
from oitbench.path_traced.export.scene import export
from oitbench.path_traced.export.view import View
from oitbench.path_traced.optics.materials import absorption
from oitbench.path_traced.photons.map import CausticMap
from oitbench.path_traced.trace.render import render
from oitbench.scene import (
    PENUMBRA,
    WHITE,
    Camera,
    DirectionalLight,
    Floats,
    Light,
    Material,
    Object,
    Scene,
    SpotLight,
)
from tests.path_traced.agreement import needs_mitsuba

pytestmark = needs_mitsuba

DOWN = DirectionalLight((0.0, -1.0, 0.0))
FLOOR = Object("floor", quad((0, 0, 0), (9, 0, 0), (0, 0, -9)), Material(albedo=WHITE))
GLASS = Material(transmission=(0.9, 0.6, 0.4), index=1.5, roughness=0.0, solid=True)
WATER = Material(transmission=(0.5, 0.9, 0.7), index=1.33, roughness=0.0, solid=True)
CLEAR_GLASS, CLEAR_WATER = (dataclasses.replace(one, transmission=WHITE) for one in (GLASS, WATER))
TOP = 2.0
"""Height of the upper face of the topmost slab."""


def _slab(name: str, low: float, high: float, material: Material, priority: int = 0) -> Object:
    """Return a slab between two heights."""
    mesh = box((0, (low + high) / 2, 0), (6, high - low, 6))
    return Object(name, mesh, material, priority=priority)


def _scene(objects: Sequence[Object], light: Light = DOWN) -> Scene:
    camera = Camera((0.0, 0.4, 2.0), (0.0, 0.0, 0.0), fov_y=0.05)
    return Scene("nested", camera, (FLOOR, *objects), lights=(light,))


def _irradiance(scene: Scene, x: Floats, z: Floats, y: float = 0.0) -> Floats:
    """Return the irradiance by photons on a level surface at the height `y`, shape (..., 3)."""
    mitsuba, drjit = llvm.load(), importlib.import_module("drjit")
    exported = export(scene, View(scene.camera, 8, 8), mitsuba)
    found = CausticMap.build(mitsuba, drjit, exported.content, exported.scene, 300_000, 1)
    assert found is not None
    si = drjit.zeros(mitsuba.SurfaceInteraction3f)
    points = np.stack([x.ravel(), np.full(x.size, y), z.ravel()]).astype(np.float32)
    si.p, si.n = mitsuba.Point3f(points), mitsuba.Normal3f(0, 1, 0)
    return np.asarray(found.irradiance(si, True), dtype=np.float64).T.reshape(*x.shape, 3)


def _grid(half: float, steps: int = 64) -> tuple[Floats, Floats]:
    """Return x and z of a square grid of points."""
    across = half * (2 * (np.arange(steps) + 0.5) / steps - 1)
    x, z = np.meshgrid(across, across)
    return x, z


def _below(*objects: Object) -> Floats:
    """Return the mean irradiance under a beam, away from the sides of slabs."""
    return np.asarray(_irradiance(_scene(objects), *_grid(1.5)).mean(axis=(0, 1)))


def _passed(*layers: tuple[Object, float]) -> Floats:
    """Return the transmittance of a pile of solids of some thickness, in all orders."""
    passed, back, index = np.ones(3), np.zeros(3), 1.0
    for item, thickness in (*layers, (None, 0.0)):
        beyond = 1.0 if item is None else item.material.index
        face = ((index - beyond) / (index + beyond)) ** 2
        passed, back = (
            passed * (1 - face) / (1 - back * face),
            face + (1 - face) ** 2 * back / (1 - back * face),
        )
        if item is not None:
            straight = np.exp(-np.asarray(absorption(item)) * thickness)
            passed, back = passed * straight, back * straight**2
        index = beyond
    return passed


@pytest.mark.parametrize("reach", [0.0, 0.05, 0.3], ids=["touch", "overlap", "overlap more"])
@pytest.mark.parametrize("first", [True, False], ids=["glass first", "water first"])
def test_light_under_glass_on_water(reach: float, first: bool) -> None:
    glass = _slab("glass", 1.5, TOP, GLASS, 0 if first else 1)
    water = _slab("water", 0.5, 1.5 + reach, WATER)
    found = _below(*((glass, water) if first else (water, glass)))
    np.testing.assert_allclose(found, _passed((glass, 0.5), (water, 1.0)), rtol=3e-3)


def test_the_solid_of_higher_priority_dims_the_light() -> None:
    glass, water = _slab("glass", 1.5, TOP, GLASS), _slab("water", 0.5, 1.8, WATER, 1)
    np.testing.assert_allclose(
        _below(glass, water), _passed((glass, TOP - 1.8), (water, 1.3)), rtol=3e-3
    )


@pytest.mark.parametrize("priority", [1, -1], ids=["pane", "water"])
def test_light_through_a_pane_inside_of_water(priority: int) -> None:
    water, pane = _slab("water", 0.5, TOP, WATER), _slab("pane", 1.0, 1.5, GLASS, priority)
    within = [(water, 0.5), (pane, 0.5), (water, 0.5)] if priority > 0 else [(water, 1.5)]
    np.testing.assert_allclose(_below(water, pane), _passed(*within), rtol=3e-3)


def test_scattered_light_enters_neither_solid() -> None:
    pale = dataclasses.replace(CLEAR_GLASS, albedo=(0.0, 0.2, 0.5))
    glass, water = _slab("glass", 1.5, TOP, pale, 1), _slab("water", 0.5, 1.5, CLEAR_WATER)
    clear = _slab("glass", 1.5, TOP, CLEAR_GLASS)
    expected = _passed((clear, 0.5), (water, 1.0)) * (1, 0.8, 0.5)
    np.testing.assert_allclose(_below(glass, water), expected, rtol=3e-3)


def test_a_path_traced_floor_under_glass_on_water() -> None:
    glass, water = _slab("glass", 1.5, TOP, CLEAR_GLASS), _slab("water", 0.5, 1.5, CLEAR_WATER)
    light = DirectionalLight((0.0, -1.0, 0.0), (math.pi, math.pi, math.pi))
    image = render(_scene((glass, water), light), (16, 16), ssaa=1, spp=16).mean
    assert image.mean() == pytest.approx(_passed((glass, 0.5), (water, 1.0)).mean(), rel=0.01)


@pytest.mark.parametrize("reach", [0.0, 0.3], ids=["touch", "overlap"])
def test_an_oblique_beam_is_bent_by_the_ratio_of_the_indices(reach: float) -> None:
    sine = 0.8
    glass = _slab("glass", 1.5, TOP, CLEAR_GLASS, 1)
    water = _slab("water", 0.5, 1.5 + reach, CLEAR_WATER)
    # An opaque sheet ends at x = −2 and casts an edge through the slabs.
    sheet = Object("sheet", quad((-7, TOP + 0.01, 0), (5, 0, 0), (0, 0, 9)), Material())
    beam = DirectionalLight((sine, -math.sqrt(1 - sine**2), 0.0))
    # Beyond, light arrives from the sides of the slabs.
    x = np.linspace(-1.2, 1.0, 2000)
    lit = _irradiance(_scene((glass, water, sheet), beam), *np.meshgrid(x, [-0.5, 0.0, 0.5]))
    row = lit.mean(axis=(0, 2))
    full = row[x > 0.3].mean()
    edge = x[-1] - row.sum() * (x[1] - x[0]) / full

    def across(index: float, thickness: float) -> float:
        return thickness * math.tan(math.asin(sine / index))

    expected = -2 + across(1.0, 0.51) + across(1.5, 0.5) + across(1.33, 1.0)
    assert edge == pytest.approx(expected, abs=0.02)
    assert full > 0.4


def test_a_vessel_of_equal_index_is_a_ball() -> None:
    outer, inner = sphere((0, 1.5, 0), 1.0, 64, 32), sphere((0, 1.5, 0), 0.8, 64, 32)
    assert inner.normals is not None
    hollow = dataclasses.replace(
        inner, triangles=inner.triangles[:, ::-1].copy(), normals=-inner.normals
    )
    vessel = Object("vessel", merge([outer, hollow]), CLEAR_GLASS, priority=1)
    ball = Object("ball", outer, CLEAR_GLASS)
    full = _scene((vessel, Object("content", inner, CLEAR_GLASS)))
    found, expected = (_irradiance(one, *_grid(0.9, 90)) for one in (full, _scene((ball,))))
    assert expected.max() > 3
    assert found.mean() == pytest.approx(expected.mean(), rel=3e-3)
    # Different photons arrive, some hundred in each cell.
    assert np.abs(found - expected).mean() < 0.03 * expected.mean()


def _lamp(height: float, angle: float = 0.1) -> SpotLight:
    return SpotLight((0, height, 0), (0, 0, 0), (1.0, 1.0, 1.0), angle)


def test_a_lamp_inside_of_solids_shines_out_of_them() -> None:
    lamp = _lamp(1.2)
    # In the space of both; the water fills it, and the glass is below.
    water, glass = _slab("water", 1.0, TOP, WATER, 1), _slab("glass", 0.5, 1.5, GLASS)
    x, z = _grid(0.3, 200)
    power = _irradiance(_scene((water, glass), lamp), x, z).sum(axis=(0, 1)) * (0.6 / 200) ** 2
    theta = (np.arange(10_000) + 0.5) / 10_000 * lamp.angle / 2
    faded = np.clip((lamp.angle / 2 - theta) / (PENUMBRA * lamp.angle / 2), 0, 1)
    emitted = 2 * math.pi * (faded * np.sin(theta)).sum() * (theta[1] - theta[0])
    faces = (1 - (0.17 / 2.83) ** 2) * (1 - 0.04)
    passed = np.exp(-0.2 * np.asarray(absorption(water)) - 0.5 * np.asarray(absorption(glass)))
    # What is reflected upward and returns is less than 0.2 %.
    np.testing.assert_allclose(power, emitted * faces * passed, rtol=6e-3)


def test_a_hidden_face_does_not_bend_light() -> None:
    """Shadow rays pass it too, so that photons would bring the light a second time."""
    faint = dataclasses.replace(CLEAR_WATER, index=1.0001)
    water, pane = _slab("water", 0.5, 3.0, faint, 1), _slab("pane", 1.5, 1.8, CLEAR_GLASS)
    film = Object("film", quad((0, 1, 0), (2, 0, 0), (0, 0, -2)), Material(0.01))
    lamp = _lamp(2.5, 1.0)
    at = _grid(0.2)
    scene = _scene((water, pane, film), lamp)
    assert _irradiance(scene, *at, y=1.0).max() < 1e-3
    assert _irradiance(scene, *at).mean() > 0.1
