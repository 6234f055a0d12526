"""Refraction in matched pictures against closed forms."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from oitbench.effects import Effect
from oitbench.modeling.mesh import box, quad, sphere
from oitbench.scene import Camera, EnvironmentLight, Material, Object, Scene
from tests.path_traced.agreement import needs_mitsuba
from tests.path_traced.matched.scenes import image

pytestmark = needs_mitsuba

CLEAR = Material(transmission=(1.0, 1.0, 1.0), index=1.5, roughness=0.0, solid=True)
TINTED = dataclasses.replace(CLEAR, transmission=(0.9, 0.6, 0.3))
AHEAD = Camera((0.0, 0.0, 4.0), fov_y=math.radians(30))
FURNACE = EnvironmentLight((1.0, 2.0, 3.0))


def _ball(material: Material = CLEAR) -> Object:
    return Object("ball", sphere((0, 0, 0), 1.0, 48, 24), material)


def _slab(material: Material) -> Object:
    return Object("slab", box((0, 0, 0), (100, 100, 1)), material)


@pytest.mark.parametrize("item", [_ball(), _slab(CLEAR)], ids=lambda item: item.name)
def test_clear_glass_in_a_furnace_is_invisible(item: Object) -> None:
    found = image(Scene("furnace", AHEAD, (item,), lights=(FURNACE,)))
    np.testing.assert_allclose(found, np.tile((1.0, 2.0, 3.0), (30, 1)), rtol=3e-3)


def test_a_slab_reflects_and_absorbs_in_all_orders() -> None:
    # At normal incidence, with F = 0.04 at each face and the transmittance a of one way:
    # (1 − F)² a / (1 − F² a²) passes, F + (1 − F)² F a² / (1 − F² a²) is reflected.
    narrow = Camera((0.0, 0.0, 4.0), fov_y=0.01)
    wall = Object(
        "wall", quad((0, 0, -9), (9, 0, 0), (0, 9, 0)), Material(emission=(5.0, 5.0, 5.0))
    )
    scene = Scene("slab", narrow, (_slab(TINTED), wall), lights=(FURNACE,))
    mesh = _slab(TINTED).mesh
    thickness = 1.0
    chord = 4 * 100 * 100 * thickness / (2 * 100 * 100 + 4 * 100 * thickness)
    a = np.asarray(TINTED.transmission) ** (2 * thickness / chord)
    assert len(mesh.triangles) == 12
    again = 1 - 0.04**2 * a**2
    passed = 0.96**2 * a / again
    mirrored = 0.04 + 0.96**2 * 0.04 * a**2 / again
    expected = passed * 5 + mirrored * np.array([1.0, 2.0, 3.0])
    np.testing.assert_allclose(image(scene), np.tile(expected, (30, 1)), rtol=2e-3)


@pytest.mark.parametrize("degrees", [20, 40])
def test_a_tilted_slab_shifts_what_is_behind_it_by_snells_law(degrees: float) -> None:
    tilt = math.radians(degrees)
    across, up = np.array([math.cos(tilt), 0, -math.sin(tilt)]), np.array([0.0, 1.0, 0.0])
    turn = np.stack([across, up, np.cross(across, up)], axis=1)
    slab = _slab(CLEAR)
    mesh = dataclasses.replace(slab.mesh, positions=slab.mesh.positions @ turn.T, normals=None)
    wall = quad((0, 0, -60), (1, 0, 0), (0, 1, 0))
    # Red grows to the right, by one a meter.
    radiance = np.ones((len(wall.positions), 3), dtype=np.float32)
    radiance[:, 0] += wall.positions[:, 0]
    behind = Object(
        "wall",
        dataclasses.replace(wall, radiance=radiance),
        Material(emission=(1.0, 1.0, 1.0)),
    )
    camera = Camera((0.0, 0.0, 4.0), fov_y=1e-4)
    tilted = dataclasses.replace(slab, mesh=mesh)
    found = image(Scene("tilted", camera, (tilted, behind)))
    shift = math.sin(tilt) * (1 - math.cos(tilt) / math.sqrt(1.5**2 - math.sin(tilt) ** 2))
    seen = found[:, 0] / found[:, 1] - 1
    np.testing.assert_allclose(np.abs(seen.mean()), shift, rtol=0.02)


def test_refraction_that_is_left_out_leaves_two_sheets() -> None:
    sheets = dataclasses.replace(TINTED, index=1.0, specular=0.04, solid=False)
    lights = (FURNACE,)
    scene = Scene("ball", AHEAD, (_ball(TINTED),), lights=lights)
    plain = image(scene, scene.effects & ~Effect.REFRACTION)
    expected = image(Scene("sheets", AHEAD, (_ball(sheets),), lights=lights))
    np.testing.assert_allclose(plain, expected, rtol=1e-6)
    assert not np.allclose(image(scene), expected, rtol=1e-2)
