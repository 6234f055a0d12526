"""Properties that vary over a surface: OpenGL, matched and full pictures agree."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.modeling.mesh import quad, sphere
from oitbench.path_traced.matched.render import matched
from oitbench.path_traced.trace.render import render as full
from oitbench.scene import (
    Camera,
    DirectionalLight,
    EnvironmentLight,
    Floats,
    Light,
    Material,
    Mesh,
    Object,
    Scene,
    Texture,
    Wrap,
)
from tests.helpers import render
from tests.path_traced.agreement import needs_mitsuba

pytestmark = needs_mitsuba
SIZE = (32, 24)
CAMERA = Camera((0.2, 0.3, 4.0), target=(0.1, 0.0, 0.0))
BACKGROUND = (0.3, 0.6, 0.9)


def texture(*shape: int, seed: int = 1, wrap: tuple[Wrap, Wrap] = (Wrap.CLAMP,) * 2) -> Texture:
    """Return random texels."""
    return Texture(np.random.default_rng(seed).random(shape).astype(np.float32), wrap)


def sheet(z: float = 0.0, tilt: float = 0.2, turns: float = 1.0, **more: Any) -> Mesh:
    """Return a tilted square; its texture coordinates run over `turns` of a texture."""
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], dtype=np.float64)
    x, y = 2 * corners.T
    positions = np.column_stack([x, y, z + tilt * y])
    triangles = np.array([(0, 1, 2), (0, 2, 3)], dtype=np.uint32)
    return Mesh.from_arrays(positions, triangles, uvs=turns * corners / 2 + 0.5, **more)


def drawn(device: Device, scene: Scene) -> Floats:
    """Return the picture of exact compositing."""
    return np.asarray(render(device, scene, "a_buffer", size=SIZE), dtype=np.float64)


def assert_alike(found: Floats, expected: Floats, mean: float, most: float) -> None:
    """Compare pictures by the mean and the largest difference of their pixels."""
    assert np.ptp(expected) > 0.1
    error = np.abs(found - expected)
    assert error.mean() < mean, error.mean()
    assert error.max() < most, error.max()


def assert_agreement(device: Device, scene: Scene, mean: float = 1e-3, most: float = 0.01) -> None:
    """Compare OpenGL with the tracers, where nothing is random."""
    expected = drawn(device, scene)
    assert_alike(np.asarray(matched(scene, SIZE, 1)), expected, mean, most)
    assert_alike(np.asarray(full(scene, SIZE, ssaa=1, spp=2).mean), expected, mean, most)


WRAPS = [
    (Wrap.CLAMP, Wrap.CLAMP),
    (Wrap.REPEAT, Wrap.MIRROR),
    (Wrap.MIRROR, Wrap.REPEAT),
]


@pytest.mark.parametrize("wrap", WRAPS)
def test_textures_of_any_size_and_wrap(device: Device, wrap: tuple[Wrap, Wrap]) -> None:
    glow, holes = texture(9, 20, 3, wrap=wrap), texture(12, 5, seed=2, wrap=wrap)
    materials = (
        Material(holes, (0.1, 0.5, 0.9), glow),
        Material(texture(64, 3, wrap=wrap), emission=(1.0, 0.5, 0.2)),
        Material(emission=texture(8, 8, wrap=wrap)),
    )
    objects = [Object(str(k), sheet(-0.4 * k, turns=3), one) for k, one in enumerate(materials)]
    assert_agreement(device, Scene("s", CAMERA, tuple(objects), background=BACKGROUND))


RANDOM = np.random.default_rng(7)
SUN = (DirectionalLight((0.4, -0.5, -1.0), (2.0, 3.0, 2.5)),)
BACK = sheet(-1.0, 0.0)
VARIED: dict[str, tuple[Material, Mesh]] = {
    "transmission": (Material(0.9, transmission=texture(7, 5, 3), albedo=(0.2, 0.3, 0.1)), sheet()),
    "albedo": (Material(0.9, transmission=(0.9, 0.5, 0.7), albedo=texture(6, 9, 3)), sheet()),
    "leaf": (
        Material(texture(8, 8), (0.8, 0.9, 0.3), albedo=texture(4, 6, 3, seed=3)), sheet(),
    ),
    "vertices": (
        Material(0.9, (0.9, 0.8, 0.7), (0.2, 0.1, 0.0), albedo=(0.8, 0.9, 0.5)),
        sheet(
            albedo=RANDOM.random((4, 3)), transmission=RANDOM.random((4, 3)),
            coverage=RANDOM.random(4), radiance=RANDOM.random((4, 3)),
        ),
    ),
    "vertices of an opaque material": (
        Material(emission=(0.2, 0.1, 0.0), albedo=(0.8, 0.9, 0.5)),
        sheet(coverage=[0.0, 0.5, 1.0, 1.0]),
    ),
    "cutoff": (Material(texture(8, 8), cutoff=0.5, emission=texture(8, 8, 3)), sheet()),
    "cutoff of glass": (
        Material(texture(8, 8), (0.5, 0.9, 0.8), albedo=(0.3, 0.1, 0.2), cutoff=0.4), sheet(),
    ),
    "cutoff of vertices": (
        Material(0.8, emission=(0.2, 0.5, 0.0), albedo=(0.8, 0.9, 0.5), cutoff=0.5),
        sheet(coverage=[0.0, 0.5, 1.0, 1.0]),
    ),
    "culled": (
        Material(0.7, (0.5, 0.9, 0.8), (0.2, 0.1, 0.4), albedo=(0.3, 0.1, 0.2), culled=True),
        Mesh.from_arrays(sheet().positions, [(0, 1, 2), (0, 3, 2)]),
    ),
    "culled and opaque": (
        Material(emission=(0.2, 0.1, 0.4), culled=True),
        Mesh.from_arrays(sheet().positions, [(0, 1, 2), (0, 3, 2)]),
    ),
}  # fmt: skip


@pytest.mark.parametrize("lights", [(), SUN], ids=["glowing", "lit"])
@pytest.mark.parametrize("kind", VARIED)
def test_properties_that_vary(device: Device, kind: str, lights: tuple[Light, ...]) -> None:
    material, mesh = VARIED[kind]
    plain = Material(0.5, (0.5, 0.7, 0.9), (0.1, 0.0, 0.1), albedo=(0.3, 0.3, 0.3))
    behind = Object("plain", BACK, plain, receives_shadows=False)
    objects = (Object("varied", mesh, material), behind)
    scene = Scene("s", CAMERA, objects, background=BACKGROUND, lights=lights)
    assert_agreement(device, scene)


FLOOR = Object("floor", quad((0, -0.5, 0), (3, 0, 0), (0, 0, -3)), Material(albedo=(0.8, 0.7, 0.6)))
HIGH = Camera((0.1, 3.0, 4.0), target=(0.0, 0.0, 0.0))
NOON = (DirectionalLight((0.3, -1.0, -0.2), (2.0, 3.0, 2.5)),)
GREEN = (0.5, 0.8, 0.3)


def card(material: Material, height: float = 0.5, *, down: bool = False, **vertices: Any) -> Object:
    """Return a card over the floor whose front is up, or down."""
    flat = quad((0.2, height, 0.1), (1, 0, 0), (0, 0.2, -1))
    order = flat.triangles[:, ::-1] if down else flat.triangles
    mesh = Mesh.from_arrays(flat.positions, order, uvs=flat.uvs, **vertices)
    return Object("card", mesh, material)


SHADOWS = {
    "cutoff": card(Material(texture(4, 4), albedo=GREEN, cutoff=0.5)),
    "cutoff of glass": card(Material(texture(4, 4), (0.5, 0.9, 0.4), albedo=GREEN, cutoff=0.5)),
    "culled": card(Material(albedo=GREEN, culled=True)),
    "culled, from its back": card(Material(albedo=GREEN, culled=True), down=True),
    "culled glass, from its back": card(Material(0.5, albedo=GREEN, culled=True), down=True),
    "vertices": card(
        Material(transmission=(0.9, 0.9, 0.9)),
        coverage=[0.0, 1.0, 0.5, 1.0], transmission=np.eye(4)[:, :3],
    ),
}  # fmt: skip


@pytest.mark.parametrize("kind", SHADOWS)
def test_shadows(device: Device, kind: str) -> None:
    scene = Scene("s", HIGH, (FLOOR, SHADOWS[kind]), lights=NOON)
    expected = drawn(device, scene)
    dark = drawn(device, Scene("s", HIGH, (FLOOR,), lights=NOON)) - expected > 0.2
    assert dark.any() == ("back" not in kind)
    for found in (matched(scene, SIZE, 1), full(scene, SIZE, ssaa=1, spp=2).mean):
        # An edge of a shadow may be on the other side of a pixel.
        assert_alike(np.asarray(found), expected, 2e-3, 0.7)


@pytest.mark.parametrize("kind", ["cutoff", "culled", "culled, from its back"])
def test_occlusion(device: Device, kind: str) -> None:
    over = card(SHADOWS[kind].material, -0.3, down="back" in kind)
    lights = (EnvironmentLight((1.0, 1.0, 1.0)),)
    scene, bare = (
        Scene("s", HIGH, objects, lights=lights, ambient_occlusion=1.0)
        for objects in ((FLOOR, over), (FLOOR,))
    )
    found, expected = drawn(device, scene), matched(scene, SIZE, 1, samples=8)
    closed = drawn(device, bare) - found > 0.05
    assert closed.any() == ("back" not in kind)
    assert np.abs(found - expected).mean() < 0.02


def test_photons_pass_the_back_of_a_culled_surface() -> None:
    glass = Material(transmission=(0.9, 0.9, 0.9), solid=True, index=1.5)
    ball = Object("ball", sphere((0.2, 0.8, 0.0), 0.4, 24, 12), glass)
    front, back = (
        card(Material(albedo=GREEN, culled=True), 0.0, down=down) for down in (False, True)
    )
    scenes = [
        Scene("s", HIGH, (FLOOR, ball, *more), lights=NOON) for more in ((), (back,), (front,))
    ]
    bare, behind, before = (np.asarray(matched(scene, SIZE, 1)) for scene in scenes)
    without = np.asarray(matched(scenes[0], SIZE, 1, ~Effect.CAUSTICS))
    assert np.abs(bare - without).max() > 0.1
    np.testing.assert_allclose(behind, bare, atol=1e-5)
    assert np.abs(before - bare).max() > 0.5
    # From below, its front is not lit through its back.
    low = Camera((0.2, -2.0, 0.2), target=(0.2, 0.0, 0.0), up=(0.0, 0.0, 1.0))
    both = card(Material(albedo=GREEN), 0.0, down=True)
    dark, lit = (
        matched(Scene("s", low, (ball, one), lights=NOON), SIZE, 1) for one in (back, both)
    )
    assert dark.max() == 0
    assert lit.max() > 0.1


SKY = np.full((25, 50, 3), 0.2, dtype=np.float32)
SKY[5:9, 15:24], SKY[11:16, 32:40] = 6, (1, 3, 8)


def test_roughness_and_a_sky_of_any_size(device: Device) -> None:
    ramp = np.linspace(0, 1, 24, dtype=np.float32)[:, None]
    ball = sphere((0, 0, 0), 1.4, 48, 24)
    pictures = []
    for roughness in (0.05, 0.3, 1.0, Texture(ramp)):
        shiny = Object("ball", ball, Material(specular=0.6, roughness=roughness))
        scene = Scene("s", CAMERA, (shiny,), lights=(EnvironmentLight(Texture(SKY)),))
        found, expected = drawn(device, scene), np.asarray(matched(scene, SIZE, 1))
        pictures.append((found, np.abs(found - expected).mean()))
    assert np.abs(pictures[0][0] - pictures[2][0]).mean() > 0.02
    # The approximation of rough lobes, which OpenGL has at constant roughness, too.
    assert pictures[0][1] < 0.01
    assert pictures[3][1] < max(error for _, error in pictures[:3]) + 0.002
