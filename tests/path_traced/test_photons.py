"""Caustics against closed forms, in small scenes of solids and receivers."""

from __future__ import annotations

import importlib
import importlib.util
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from oitbench.modeling.mesh import box, quad, sphere
from oitbench.modeling.placement import merge
from oitbench.path_traced import llvm
from oitbench.path_traced.export.shapes import SOLIDS, solids
from oitbench.path_traced.photons.map import CausticMap
from oitbench.scene import (
    BLACK,
    PENUMBRA,
    RGB,
    WHITE,
    Camera,
    DirectionalLight,
    Floats,
    Light,
    Material,
    Mesh,
    Object,
    Scene,
    SpotLight,
    as_vector,
)
from oitbench.scene.solids import mean_chord

needs_llvm = pytest.mark.skipif(
    importlib.util.find_spec("mitsuba") is None or llvm.backend().variant != llvm.FAST_VARIANT,
    reason="Mitsuba runs without LLVM",
)
DOWN = DirectionalLight((0.0, -1.0, 0.0))
CLEAR = 1.0001
"""A refractive index with almost no refraction and no reflection."""
FLOOR = quad((0, 0, 0), (4, 0, 0), (0, 0, -4))
SLAB = box((0, 1, 0), (2, 0.5, 2))
COUNT = 150_000


def _glass(index: float, transmission: RGB = WHITE, albedo: RGB = BLACK) -> Material:
    return Material(
        transmission=transmission, albedo=albedo, index=index, solid=True, roughness=0.0
    )


def _scene(mesh: Mesh, index: float, lights: Sequence[Light] = (DOWN,), **material: RGB) -> Scene:
    glass = Object("glass", mesh, _glass(index, **material))
    floor = Object("floor", FLOOR, Material(albedo=WHITE))
    return Scene("caustic", Camera((0, 3, 9)), (floor, glass), lights=tuple(lights))


Receiver = tuple[Mesh, dict[str, Any]]
DIFFUSE: dict[str, Any] = {"type": "diffuse"}


class _Traced:
    """A scene in Mitsuba, and the caustic map of its solids."""

    def __init__(
        self,
        scene: Scene,
        receivers: Sequence[Receiver] = ((FLOOR, DIFFUSE),),
        count: int = COUNT,
    ) -> None:
        self.mitsuba = llvm.load()
        self.drjit = importlib.import_module("drjit")
        content: dict[str, Any] = {"type": "scene"}
        items = solids(scene)
        if items:
            content[SOLIDS] = self._shape(merge([item.mesh for item in items]), {"type": "null"})
        for number, (mesh, bsdf) in enumerate(receivers):
            content[f"receiver_{number}"] = self._shape(mesh, bsdf)
        self.content = self.mitsuba.load_dict(content)
        self.map = CausticMap.build(self.mitsuba, self.drjit, self.content, scene, count, 1)

    def _shape(self, mesh: Mesh, bsdf: dict[str, Any]) -> Any:
        properties = self.mitsuba.Properties("mesh")
        properties["bsdf"] = self.mitsuba.load_dict(bsdf)
        shape = self.mitsuba.Mesh(
            "", len(mesh.positions), len(mesh.triangles), properties, has_vertex_normals=True
        )
        values = self.mitsuba.traverse(shape)
        assert mesh.normals is not None
        values["vertex_positions"] = mesh.positions.ravel()
        values["vertex_normals"] = mesh.normals.ravel()
        values["faces"] = mesh.triangles.ravel()
        values.update()
        return shape

    def interactions(self, points: npt.ArrayLike, normal: RGB = (0, 1, 0)) -> Any:
        """Return interactions on a surface of `normal` at `points`, shape (..., 3)."""
        si = self.drjit.zeros(self.mitsuba.SurfaceInteraction3f)
        places = np.reshape(points, (-1, 3)).astype(np.float32)
        si.p = self.mitsuba.Point3f(places.T)
        si.n = self.mitsuba.Normal3f(*(np.asarray(normal) / np.linalg.norm(normal)).tolist())
        return si

    def irradiance(self, points: npt.ArrayLike, normal: RGB = (0, 1, 0)) -> Floats:
        """Return the irradiance at `points`, shape (..., 3), of a surface of `normal`."""
        assert self.map is not None
        found = self.map.irradiance(self.interactions(points, normal), True)
        return np.array(found, dtype=np.float64).T.reshape(np.shape(points))


def _grid(half: float, steps: int = 64, center: RGB = (0, 0, 0)) -> Floats:
    """Return a square grid of points, shape (steps, steps, 3), on a horizontal plane."""
    across = half * (2 * (np.arange(steps) + 0.5) / steps - 1)
    x, z = np.meshgrid(across, across)
    return np.stack([x, np.zeros_like(x), z], axis=-1) + center


@needs_llvm
def test_a_slab_passes_the_light_that_is_neither_reflected_nor_absorbed() -> None:
    scene = _scene(SLAB, 1.5, transmission=(0.9, 0.5, 0.2))
    found = _Traced(scene).irradiance(_grid(0.8)).mean(axis=(0, 1))
    reflected = 0.2**2
    passed = np.array([0.9, 0.5, 0.2]) ** (2 * 0.5 / mean_chord(SLAB))
    # The geometric series of reflections inside.
    expected = (1 - reflected) ** 2 * passed / (1 - (reflected * passed) ** 2)
    np.testing.assert_allclose(found, expected, rtol=5e-3)


@needs_llvm
def test_light_through_a_clear_solid_is_uniform_and_ends_at_its_edge() -> None:
    traced = _Traced(_scene(SLAB, CLEAR, [DirectionalLight((0, -1, 0), (1, 2, 3))]))
    assert traced.map is not None
    side = float(traced.map.side[0])
    lit = traced.irradiance(_grid(0.9))
    np.testing.assert_allclose(lit.mean(axis=(0, 1)), (1, 2, 3), rtol=1e-3)
    # Photons at random places would vary by 1/√128 = 9 %.
    assert lit[..., 0].std() < 0.02
    x = np.linspace(0, 0.9, 2000)
    across = traced.irradiance(np.stack([x, 0 * x, 0 * x], axis=-1))[:, 0]
    assert np.abs(np.diff(across)).max() < 0.1 * (x[1] / side)
    beyond = 1 + 1.6 * side
    assert not traced.irradiance(_grid(0.2, center=(beyond + 0.2, 0, 0))).any()
    assert not traced.irradiance(_grid(0.9), (0, -1, 0)).any()
    assert not traced.irradiance([(0, 0, 1e6), (math.nan, 0, 0)]).any()


@needs_llvm
def test_scattered_light_does_not_enter_a_solid() -> None:
    traced = _Traced(_scene(SLAB, CLEAR, albedo=(0.0, 0.3, 0.9)))
    found = traced.irradiance(_grid(0.8)).mean(axis=(0, 1))
    np.testing.assert_allclose(found, (1, 0.7, 0.1), rtol=5e-3)


@needs_llvm
def test_two_solids_in_a_beam_count_its_light_once_and_two_beams_add() -> None:
    below, above = box((0, 1, 0), (2, 0.2, 2)), box((0.5, 2, 0), (2, 0.2, 2))
    scene = _scene(below, CLEAR, [DOWN, DirectionalLight((0, -1, 0), (0, 0, 2))])
    glass = Object("above", above, _glass(CLEAR))
    traced = _Traced(Scene("two", scene.camera, (*scene.objects, glass), lights=scene.lights))
    found = traced.irradiance(_grid(0.8, center=(0.25, 0, 0))).mean(axis=(0, 1))
    np.testing.assert_allclose(found, (1, 1, 3), rtol=5e-3)


@needs_llvm
def test_films_receive_and_tint_the_light_behind_the_solid_only() -> None:
    under, over = quad((0, 0.5, 0), (1, 0, 0), (0, 0, -1)), quad((0, 2, 0), (1, 0, 0), (0, 0, -1))
    film = {"type": "mask", "opacity": 0.25, "bsdf": DIFFUSE}
    receivers: list[Receiver] = [(FLOOR, DIFFUSE), (under, film), (over, film)]
    traced = _Traced(_scene(SLAB, CLEAR), receivers)
    for height, expected in ((2, 0.0), (0.5, 0.75), (0, 0.75**2)):
        found = traced.irradiance(_grid(0.8, center=(0, height, 0)))[..., 0].mean()
        assert found == pytest.approx(expected, rel=5e-3, abs=1e-4), height


@needs_llvm
def test_light_inside_a_solid_is_power_and_not_radiance() -> None:
    film = quad((0, 1, 0), (0.9, 0, 0), (0, 0, -0.9))
    traced = _Traced(_scene(SLAB, 1.5), [(film, {"type": "null"})])
    # Downward and upward light add to (1 − R)(1 + R)/(1 − R²). Radiance would be 2.25 times that.
    found = traced.irradiance(_grid(0.7, center=(0, 1, 0)))[..., 0].mean()
    assert found == pytest.approx(1, rel=5e-3)


@needs_llvm
@pytest.mark.parametrize("tilt", [0.3, 0.7, 1.0])
def test_a_tilted_receiver_is_lit_by_the_cosine(tilt: float) -> None:
    normal = (math.sin(tilt) * 0.6, math.cos(tilt), math.sin(tilt) * 0.8)
    right = np.cross(normal, (1.0, 0, 0))
    up = np.cross(normal, right)
    floor = quad((0, -3, 0), as_vector(4 * right), as_vector(4 * up))
    traced = _Traced(_scene(SLAB, CLEAR), [(floor, DIFFUSE)])
    points = _grid(0.8)
    points[..., 1] = -3 - (points @ np.array(normal)) / normal[1]
    found = traced.irradiance(points, normal)[..., 0]
    assert found.mean() == pytest.approx(math.cos(tilt), rel=5e-3)
    assert found.std() < 0.03


@needs_llvm
def test_all_light_on_a_sphere_arrives_at_the_walls_around_it() -> None:
    half, beyond = 2.5, 0.5  # light spreads a little beyond the edges of a wall
    ball, room = sphere((0, 2.2, 0), 1, 64, 32), box((0, half, 0), (2 * half,) * 3)
    # Walls that transmit everything let the beam in, and still receive photons.
    traced = _Traced(_scene(ball, 1.5), [(room, {"type": "null"})], COUNT)
    total = 0.0
    for axis in range(3):
        for sign in (1, -1):
            points = np.roll(_grid(half + beyond, 200), axis - 1, axis=-1)
            points[..., axis] = sign * half
            normal = np.roll((sign, 0, 0), axis)
            lit = traced.irradiance(np.add(points, (0, half, 0)), as_vector(normal))[..., 0]
            total += lit.mean() * (2 * (half + beyond)) ** 2
    assert total == pytest.approx(math.pi, rel=5e-3)


def _within(radius: float, height: float, index: float) -> float:
    """Return the power that a unit sphere sends to a disk `height` below its center.

    The beam is parallel and of unit irradiance. Fresnel losses are those of unpolarized light.
    """
    across = (np.arange(200_000) + 0.5) / 200_000
    outer, inner = np.arcsin(across), np.arcsin(across / index)
    perpendicular = (np.sin(outer - inner) / np.sin(outer + inner)) ** 2
    parallel = (np.tan(outer - inner) / np.tan(outer + inner)) ** 2
    passed = (1 - (perpendicular + parallel) / 2) ** 2
    turned = 2 * (outer - inner)
    along = (height - np.cos(2 * inner - outer)) / np.cos(turned)
    arrived = np.sin(2 * inner - outer) - along * np.sin(turned)
    hit = (np.cos(turned) > 0) & (np.abs(arrived) < radius)
    return float((2 * math.pi * across * passed * hit).mean())


@needs_llvm
@pytest.mark.parametrize("index", [1.3, 1.5])
def test_a_sphere_focuses_light_as_refraction_predicts(index: float) -> None:
    traced = _Traced(_scene(sphere((0, 1.5, 0), 1, 128, 64), index))
    points = _grid(0.9, 300)
    lit = traced.irradiance(points)[..., 0]
    distance = np.hypot(points[..., 0], points[..., 2])
    for radius in (0.4, 0.8):
        power = lit[distance < radius].sum() * (1.8 / 300) ** 2
        assert power == pytest.approx(_within(radius, 1.5, index), rel=1e-2), radius
    assert lit[distance < 0.1].min() > 3
    assert lit[distance > 0.8].max() < 0.2


@needs_llvm
def test_a_spot_light_fades_with_distance_slope_and_angle() -> None:
    height, angle = 3.0, 0.9
    spot = SpotLight((0, height, 0), (0, 0, 0), (9.0, 9.0, 9.0), angle)
    traced = _Traced(_scene(box((0, 1, 0), (4, 0.01, 4)), CLEAR, [spot]), count=4 * COUNT)
    points = _grid(1.8, 300)
    theta = np.arctan(np.hypot(points[..., 0], points[..., 2]) / height)
    faded = np.clip((angle / 2 - theta) / (PENUMBRA * angle / 2), 0, 1)
    expected = np.cos(theta) ** 3 * faded
    found = traced.irradiance(points)[..., 0]
    assert np.abs(found - expected).mean() < 0.01
    for part in (theta < 0.35, theta > 0.35):
        assert found[part].mean() == pytest.approx(expected[part].mean(), rel=5e-3)


@needs_llvm
def test_a_far_spot_light_equals_a_directional_light() -> None:
    far = 1000.0
    spot = SpotLight((0, far, 0), (0, 0, 0), (far**2, far**2, far**2), 0.01)
    scenes = [_scene(sphere((0, 1.5, 0), 1, 64, 32), 1.5, [light]) for light in (DOWN, spot)]
    parallel, central = (_Traced(scene) for scene in scenes)
    for half in (0.2, 0.8):
        # The sphere is closer to the light than the floor and receives more: (1 − 1.5/1000)⁻².
        expected = 1.003 * parallel.irradiance(_grid(half, 100)).mean()
        assert central.irradiance(_grid(half, 100)).mean() == pytest.approx(expected, rel=5e-3)


@needs_llvm
def test_the_lookup_works_inside_a_symbolic_loop() -> None:
    traced = _Traced(_scene(SLAB, CLEAR))
    mitsuba, drjit, caustics = traced.mitsuba, traced.drjit, traced.map
    assert caustics is not None
    points = _grid(1.2, 16)

    def step(number: Any, si: Any, total: Any) -> tuple[Any, Any, Any]:
        total = total + caustics.irradiance(si, number < 1)
        si.p.x += 0.1
        return number + 1, si, total

    state = mitsuba.UInt32(0), traced.interactions(points), mitsuba.Color3f(0)
    looped = drjit.while_loop(state, lambda number, si, total: number < 3, step, mode="symbolic")
    found = np.array(looped[2]).T.reshape(points.shape)
    np.testing.assert_allclose(found, traced.irradiance(points), atol=1e-5)


@needs_llvm
def test_the_seed_determines_the_photons() -> None:
    scene = _scene(SLAB, 1.5)
    traced = _Traced(scene)
    first = traced.irradiance(_grid(0.8))
    for seed, same in ((1, True), (2, False)):
        traced.map = CausticMap.build(
            traced.mitsuba, traced.drjit, traced.content, scene, COUNT, seed
        )
        assert np.array_equal(traced.irradiance(_grid(0.8)), first) == same


@needs_llvm
def test_there_is_no_map_without_a_beam_on_a_solid_that_refracts() -> None:
    aside = SpotLight((0, 5, 0), (0, 9, 0))
    assert _Traced(_scene(SLAB, 1.5, [])).map is None
    assert _Traced(_scene(SLAB, 1.5, [aside])).map is None
    assert _Traced(_scene(SLAB, 1.0)).map is None
    assert _Traced(_scene(SLAB, 1.5, transmission=(0.0, 0.0, 0.0))).map is None


@needs_llvm
def test_a_solid_without_its_shape_is_named() -> None:
    scene = _scene(SLAB, 1.5)
    empty = _Traced(_scene(SLAB, 1.0))
    with pytest.raises(ValueError, match="has no shape solids; export the same scene"):
        CausticMap.build(empty.mitsuba, empty.drjit, empty.content, scene, COUNT, 1)
