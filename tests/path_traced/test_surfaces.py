"""Properties that vary over a surface: OpenGL, matched and full pictures agree."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from oitbench.gl.device import Device
from oitbench.path_traced.matched.render import matched
from oitbench.path_traced.trace.render import render as full
from oitbench.scene import (
    Camera,
    DirectionalLight,
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
