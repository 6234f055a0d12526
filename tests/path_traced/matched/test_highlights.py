"""Highlights of lamps on smooth glass: the same in OpenGL, in matched pictures and path traced."""

from __future__ import annotations

import math

import numpy as np
import pytest

from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.modeling.mesh import sphere
from oitbench.path_traced.matched.render import matched
from oitbench.path_traced.trace.render import render
from oitbench.scene import (
    Camera,
    DirectionalLight,
    Floats,
    Light,
    Material,
    Object,
    Scene,
    SpotLight,
)
from tests.helpers import opened
from tests.path_traced.agreement import needs_mitsuba

pytestmark = needs_mitsuba

SIDE = 96
GLASS = Material(transmission=(0.9, 0.9, 0.9), index=1.5, roughness=0.0, solid=True)
SUN = DirectionalLight((0.0, -0.5, -1.0), (1.0, 2.0, 3.0))
LAMP = SpotLight((0.0, 3.0, 6.0), (0.0, 0.0, 0.0), (45.0, 90.0, 135.0), math.radians(60))


def _upper(image: Floats) -> Floats:
    """Return the sum over the upper half, where the lamp is mirrored by the front of the sphere."""
    return np.asarray(image[: SIDE // 2].sum(axis=(0, 1)), dtype=np.float64)


@pytest.mark.parametrize("light", [SUN, LAMP], ids=["sun", "lamp"])
def test_a_glass_sphere_shows_its_lamp(device: Device, light: Light) -> None:
    ball = Object("ball", sphere((0, 0, 0), 1.0, 192, 96), GLASS, casts=False)
    camera = Camera((0, 0, 8), (0, 0, 0), fov_y=math.radians(16))
    scene = Scene("ball", camera, (ball,), lights=(light,))
    size = SIDE, SIDE
    with opened(device, scene, "a_buffer", size) as frame:
        frame.render()
        drawn = _upper(frame.image().astype(np.float64))
    truth = matched(scene, size, 1, scene.effects & ~Effect.CAUSTICS).astype(np.float64)
    assert truth.max() > 1
    np.testing.assert_allclose(drawn, _upper(truth), rtol=0.01)
    full = render(scene, size, 1, spp=8).mean.astype(np.float64)
    np.testing.assert_allclose(_upper(full), _upper(truth), rtol=0.03)
