"""Light of an environment map on surfaces that OpenGL draws, against quadrature."""

from __future__ import annotations

import math

import numpy as np
import pytest

from oitbench.gl.device import Device
from oitbench.modeling.mesh import quad
from oitbench.scene import Camera, EnvironmentLight, Floats, Material, Object, Scene, Texture, unit
from tests.helpers import Empty, opened
from tests.models import environment as model
from tests.models.view import rays

SIZE = (5, 5)
NORMALS = [(0, 1, 0), (1, 0, 0), (-1, 0, 0), (0, 0, -1), (0, -1, 0)]


def _seen(
    device: Device, material: Material, n: Floats, v: Floats, texture: Texture
) -> tuple[Floats, Floats]:
    """Return the pixels of a small square with the normal `n`, seen from `v`, and vectors to the
    eye."""
    right = unit(np.cross(n, (0.3, 0.5, 0.8)))
    mesh = quad((0, 0, 0), tuple(right), tuple(np.cross(n, right)))
    camera = Camera(tuple(3 * v), up=tuple(right), fov_y=0.02)
    item = Object("square", mesh, material)
    scene = Scene("square", camera, (item,), lights=(EnvironmentLight(texture),))
    with opened(device, scene, Empty(), SIZE) as frame:
        frame.render()
        return frame.image().astype(np.float64).reshape(-1, 3), -unit(rays(camera, SIZE)).reshape(
            -1, 3
        )


@pytest.mark.parametrize("normal", NORMALS)
def test_a_matte_surface_gathers_the_sky_that_it_faces(
    device: Device, normal: tuple[int, int, int]
) -> None:
    n = np.asarray(normal, dtype=np.float64)
    found, _ = _seen(device, Material(albedo=(0.8, 0.5, 0.2)), n, n, model.sky())
    expected = np.multiply((0.8, 0.5, 0.2), model.irradiance(model.sky(), n)) / math.pi
    np.testing.assert_allclose(found, np.tile(expected, (25, 1)), rtol=4e-3)


@pytest.mark.parametrize("roughness", [0.25, 0.5, 1.0])
@pytest.mark.parametrize("degrees", [0, 30, 60])
def test_a_rough_mirror_gathers_its_lobe(device: Device, roughness: float, degrees: float) -> None:
    """The split sum replaces a lobe by one around its mean direction: far off, it is wider."""
    angle = math.radians(degrees)
    n = unit(np.array([1.0, 0.3, -0.4]))
    v = math.cos(angle) * n + math.sin(angle) * unit(np.cross(n, (0, 1, 0)))
    found, toward = _seen(device, Material(specular=0.3, roughness=roughness), n, v, model.sky())
    expected = [model.mirrored(model.sky(), n, one, 0.3, roughness) for one in toward[:1]]
    np.testing.assert_allclose(found[:1], expected, rtol=0.03 if degrees < 60 else 0.06)


@pytest.mark.parametrize("roughness", [0.25, 1.0])
@pytest.mark.parametrize("degrees", [0, 75])
def test_even_light_is_reflected_by_the_mean_of_f(
    device: Device, roughness: float, degrees: float
) -> None:
    """F(n·v) would be far too much at grazing incidence."""
    white = Texture(np.ones((2, 4, 3), dtype=np.float32))
    angle, n = math.radians(degrees), np.array([0.0, 1.0, 0.0])
    v = np.array([math.sin(angle), math.cos(angle), 0.0])
    found, toward = _seen(device, Material(specular=0.04, roughness=roughness), n, v, white)
    expected = model.mirrored(white, n, toward[0], 0.04, roughness)
    np.testing.assert_allclose(found[0], expected, rtol=0.01)


@pytest.mark.parametrize("row", [20, 31])
def test_a_texel_is_seen_at_its_middle(device: Device, row: int) -> None:
    texels = np.zeros((64, 128), dtype=np.float32)
    texels[row, 40] = 1.0
    polar, longitude = (row + 0.5) / 64 * math.pi, (40.5 / 64 - 1) * math.pi
    target = np.array(
        [
            math.sin(polar) * math.sin(longitude),
            math.cos(polar),
            -math.sin(polar) * math.cos(longitude),
        ]
    )
    aside = Object("aside", quad((0, 0, 90), (0.01, 0, 0), (0, 0.01, 0)), Material())
    camera = Camera((0, 0, 0), tuple(target), fov_y=1e-4)
    lights = (EnvironmentLight(Texture(texels)),)
    with opened(device, Scene("dot", camera, (aside,), lights=lights), Empty(), SIZE) as frame:
        frame.render()
        np.testing.assert_allclose(frame.image(), 1, rtol=5e-3)
