"""Path-traced films against closed forms; these images have no noise."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from oitbench.path_traced import llvm
from oitbench.path_traced.export.scene import export
from oitbench.path_traced.export.view import View
from oitbench.path_traced.trace.integrators import trace
from oitbench.path_traced.trace.render import render
from oitbench.scene import RGB, Camera, Material, Mesh, Object, Scene, Texture, Wrap, as_vector
from oitbench.scene.texturing import Images, level_of_detail, lookup, premultiplied_pyramid
from tests.path_traced.agreement import needs_mitsuba

pytestmark = needs_mitsuba
FRONT = Camera((0.0, 0.0, 4.0))
BACKGROUND: RGB = (0.2, 0.5, 0.9)


def _quad(z: float = 0.0, half: float = 3.0, tilt: float = 0.0, **more: Any) -> Mesh:
    corners = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    positions = [(half * x, half * y, z + tilt * half * y) for x, y in corners]
    return Mesh(
        np.array(positions, dtype=np.float32),
        np.array([(0, 1, 2), (0, 2, 3)], dtype=np.uint32),
        np.array([(0, 0), (1, 0), (1, 1), (0, 1)], dtype=np.float32),
        **more,
    )


def _materials(count: int, seed: int = 5) -> list[Material]:
    random = np.random.default_rng(seed)
    return [
        Material(
            coverage=float(random.uniform(0.05, 0.5)),
            transmission=as_vector(random.random(3)),
            emission=as_vector(random.uniform(0, 2, 3)),
        )
        for _ in range(count)
    ]


def _stack(materials: list[Material], camera: Camera = FRONT) -> Scene:
    """Return films at z = 1, 0.9, …, in submission order from back to front."""
    films = [
        Object(f"film {i}", _quad(1 - 0.1 * i), material) for i, material in enumerate(materials)
    ]
    return Scene("stack", camera, tuple(films[::-1]), background=BACKGROUND)


def _composite(materials: list[Material], background: RGB = BACKGROUND) -> npt.NDArray[np.float64]:
    """Return Σ α L Π τ + C₀ Π τ; the first film is the nearest."""
    color, through = np.zeros(3), np.ones(3)
    for material in materials:
        assert isinstance(material.coverage, float)
        color += through * material.coverage * np.asarray(material.emission)
        through *= 1 - material.coverage * (1 - np.asarray(material.transmission))
    return color + through * background


def test_a_stack_of_colored_films_is_composited_without_noise() -> None:
    materials = _materials(12)
    estimate = render(_stack(materials), (8, 6))
    expected = np.broadcast_to(_composite(materials), (6, 8, 3))
    np.testing.assert_allclose(estimate.mean, expected, atol=1e-5)
    assert (estimate.variance == 0).all()
    np.testing.assert_array_equal(*estimate.halves)


@pytest.mark.parametrize("variant", [None, llvm.SLOW_VARIANT])
def test_volpath_agrees_where_films_are_far_apart(variant: str | None) -> None:
    scene = _stack(_materials(6))
    own = render(scene, (3, 2), ssaa=1, variant=variant)
    assert own.spp == 1
    mitsuba, view = llvm.load(variant), View(scene.camera, 3, 2)
    content = export(scene, view, mitsuba).content
    samples = [
        trace(mitsuba, _volpath(mitsuba), content, view.rays(0, 6), seed).reshape(2, 3, 3)
        for seed in range(3)
    ]
    for sample in samples:
        np.testing.assert_allclose(own.mean, sample, atol=1e-6)
    assert np.var(samples, axis=0).max() < 1e-12


def _volpath(mitsuba: Any) -> Any:
    """Return Mitsuba's volumetric path tracer with unlimited depth as an integrator."""
    # Films count as no bounce, so neither the depth nor Russian roulette limits their number.
    volpath = mitsuba.load_dict({"type": "volpath", "max_depth": -1, "rr_depth": 1 << 20})
    sampler = mitsuba.load_dict({"type": "independent"})

    def integrate(content: Any, ray: Any, seed: int) -> Any:
        if mitsuba.variant().startswith("scalar"):
            sampler.seed(seed)
        else:
            sampler.seed(seed, ray.o.shape[1])
        return volpath.sample(content, sampler, mitsuba.RayDifferential3f(ray))[0]

    return integrate


def test_layers_that_are_very_close_are_each_hit_once() -> None:
    gap, count = 2e-6, 40
    film = Material(coverage=0.02, emission=(1.0, 1.0, 1.0), transmission=(0.0, 1.0, 1.0))
    films = tuple(Object(str(i), _quad(-gap * i, tilt=1.0), film) for i in range(count))
    camera = Camera((0.03, 0.0, 4.0), target=(0.03, 0.0, 0.0))
    image = render(Scene("hairs", camera, films), (8, 8)).mean
    expected = (1 - 0.98**count, 0.02 * count, 0.02 * count)
    np.testing.assert_allclose(image, np.broadcast_to(expected, (8, 8, 3)), atol=1e-4)


@pytest.mark.parametrize("culled", [False, True])
@pytest.mark.parametrize("variant", [None, llvm.SLOW_VARIANT])
def test_films_closer_than_a_step_are_both_hit(variant: str | None, culled: bool) -> None:
    film = Material(coverage=0.5, emission=(1.0, 1.0, 1.0), culled=culled)
    films = tuple(Object(str(i), _quad(0.3 + 1e-6 * i, tilt=0.7), film) for i in range(2))
    # From here, no ray hits the diagonal that the triangles of a quad share.
    camera = Camera((0.03, 0.0, 4.0), target=(0.03, 0.0, 0.0))
    scene = Scene("twins", camera, films, background=(0.0, 0.0, 10.0))
    image = render(scene, (8, 8), ssaa=1, variant=variant).mean
    expected = np.broadcast_to((0.75, 0.75, 3.25), (8, 8, 3))
    np.testing.assert_allclose(image, expected, atol=1e-5)


def test_films_are_composited_in_reverse_order_from_behind() -> None:
    materials = _materials(5)
    behind = _stack(materials, Camera((0.0, 0.0, -4.0)))
    expected = np.broadcast_to(_composite(materials[::-1]), (4, 4, 3))
    np.testing.assert_allclose(render(behind, (4, 4)).mean, expected, atol=1e-5)


def test_a_clear_film_tints_the_background_and_an_opaque_one_hides_it() -> None:
    tint: RGB = (0.9, 0.5, 0.1)
    scene = _stack([Material(coverage=0.5, transmission=tint)])
    expected = np.asarray(BACKGROUND) * (0.5 + 0.5 * np.asarray(tint))
    np.testing.assert_allclose(render(scene, (2, 2)).mean[0, 0], expected, atol=1e-6)
    wall = _stack([Material(emission=(0.1, 0.2, 0.3)), *_materials(2)])
    np.testing.assert_allclose(render(wall, (2, 2)).mean[0, 0], (0.1, 0.2, 0.3), atol=1e-6)
    black = _stack([Material(), *_materials(1)])
    assert (render(black, (2, 2)).mean == 0).all()


def test_the_number_of_films_is_not_limited() -> None:
    film = Material(coverage=0.01, emission=(1.0, 0.0, 0.0), transmission=(0.0, 1.0, 0.0))
    films = tuple(Object(str(i), _quad(1 - 0.02 * i), film) for i in range(100))
    scene = Scene("many", FRONT, films, background=(0.0, 1.0, 1.0))
    expected = (1 - 0.99**100, 1, 0.99**100)
    np.testing.assert_allclose(render(scene, (2, 2)).mean[0, 0], expected, atol=1e-5)


def test_radiance_at_the_vertices_is_interpolated() -> None:
    radiance = np.array([(1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 0)], dtype=np.float32)
    mesh = _quad(radiance=radiance)
    scene = Scene("ramp", FRONT, (Object("q", mesh, Material(0.5, emission=(2.0, 2.0, 2.0))),))
    image = render(scene, (8, 8), ssaa=1).mean
    points = _hits(View(FRONT, 8, 8), 0.0).reshape(8, 8, 3)
    s, t = points[..., 0] / 6 + 0.5, points[..., 1] / 6 + 0.5
    # Vertices 0, 1, 2 and 0, 2, 3 span the triangles below and above the diagonal s = t.
    np.testing.assert_allclose(image[..., 0], 1 - t, atol=1e-5)
    np.testing.assert_allclose(image[..., 1], s, atol=1e-5)


def _hits(view: View, z: float) -> npt.NDArray[np.float64]:
    origins, directions = view.rays(0, view.width * view.height)
    return origins + directions * ((z - origins[:, 2:]) / directions[:, 2:])


def test_rays_hit_the_pixels_that_a_rasterizer_would_cover() -> None:
    camera = Camera((0.0, 0.0, 2.0), fov_y=2 * math.atan(0.5))
    # On the plane z = 0 the image is 4 m wide and 2 m high: a pixel of 16 × 8 is 0.25 m.
    corner = np.array([(-2, 1, 0), (-1.5, 1, 0), (-1.5, 0.25, 0), (-2, 0.25, 0)])
    mesh = dataclasses.replace(_quad(), positions=corner)
    scene = Scene("corner", camera, (Object("q", mesh, Material(emission=(1.0, 1.0, 1.0))),))
    expected = np.zeros((8, 16))
    expected[:3, :2] = 1
    np.testing.assert_array_equal(render(scene, (16, 8), ssaa=2).mean[..., 0], expected)
    shifted = dataclasses.replace(mesh, positions=corner + np.array([0.1, 0, 0]))
    scene = dataclasses.replace(scene, objects=(Object("q", shifted, scene.objects[0].material),))
    # The film starts beyond the first column's left sub-pixels and ends beyond the third's.
    row = render(scene, (16, 8), ssaa=2).mean[0, :4, 0]
    np.testing.assert_array_equal(row, [0.5, 1, 0.5, 0])


def test_films_in_front_of_the_near_and_beyond_the_far_plane_are_not_drawn() -> None:
    materials = _materials(3)
    camera = Camera((0.0, 0.0, 4.0), near=3.05, far=3.15)
    image = render(_stack(materials, camera), (4, 4)).mean
    np.testing.assert_allclose(image[0, 0], _composite(materials[1:2]), atol=1e-6)


CLAMPED = (Wrap.CLAMP, Wrap.CLAMP)


@pytest.mark.parametrize(
    ("shape", "wrap"),
    [
        ((64, 64), CLAMPED),
        ((2, 128), CLAMPED),
        ((63, 45), CLAMPED),
        ((7, 100), (Wrap.REPEAT, Wrap.MIRROR)),
        ((64, 33), (Wrap.MIRROR, Wrap.REPEAT)),
    ],
)
def test_textures_use_the_shared_filter(shape: tuple[int, int], wrap: tuple[Wrap, Wrap]) -> None:
    random = np.random.default_rng(8)
    emission = Texture(random.random((*shape, 3)).astype(np.float32), wrap)
    coverage = Texture(random.random(shape).astype(np.float32), wrap)
    material = Material(coverage, (0.1, 0.5, 0.9), emission)
    camera = Camera((0.3, -0.2, 4.0), target=(0.1, 0.0, 0.0))
    tilt, turns = 1.5, 1 if wrap == CLAMPED else 3
    mesh = _quad(tilt=tilt)
    assert mesh.uvs is not None
    mesh = dataclasses.replace(mesh, uvs=turns * mesh.uvs - turns // 2)
    scene = Scene("floor", camera, (Object("q", mesh, material),), background=BACKGROUND)
    image = render(scene, (24, 16), ssaa=1).mean.reshape(-1, 3)
    pyramid = premultiplied_pyramid(Images(emission, coverage))
    texels = turns * shape[0], turns * shape[1]
    uv, lod = _footprints(View(camera, 24, 16), tilt, texels, len(pyramid))
    inside = ((uv > 0) & (uv < 1)).all(axis=1)
    assert inside.sum() > 150
    assert np.ptp(lod[inside]) > 1
    found = lookup(pyramid, turns * uv - turns // 2, lod, wrap)
    through = 1 - found[:, 3:] * (1 - np.asarray(material.transmission))
    expected = found[:, :3] + through * BACKGROUND
    np.testing.assert_allclose(image[inside], expected[inside], atol=1e-4)


def _footprints(
    view: View, tilt: float, shape: tuple[int, int], levels: int
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return uv and the level of detail on the quad z = tilt · y, by finite differences."""
    right, up, back = view.camera.axes
    index = np.arange(view.width * view.height)
    film = np.stack([index % view.width + 0.5, index // view.width + 0.5], axis=1)

    def uv(offset: tuple[float, float]) -> npt.NDArray[np.float64]:
        x, y = ((film + offset) - (view.width / 2, view.height / 2)).T * view.step[0]
        forward = x[:, None] * right - y[:, None] * up - back
        origin = np.asarray(view.camera.position)
        distance = (tilt * origin[1] - origin[2]) / (forward[:, 2] - tilt * forward[:, 1])
        return np.asarray((origin + distance[:, None] * forward)[:, :2] / 6 + 0.5)

    tiny = 1e-5
    texels = np.array([shape[1], shape[0]])
    dx = (uv((tiny, 0)) - uv((-tiny, 0))) / (2 * tiny) * texels
    dy = (uv((0, tiny)) - uv((0, -tiny))) / (2 * tiny) * texels
    return uv((0, 0)), level_of_detail(dx, dy, levels)
