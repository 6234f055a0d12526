"""Shadow rays of layers that contribute little: fewer of them, but the same light in the mean."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.effects import Effect
from oitbench.modeling.mesh import quad, sphere
from oitbench.path_traced.matched.render import is_random, matched
from oitbench.scene import Camera, DirectionalLight, Material, Object, Scene
from tests.path_traced.agreement import needs_mitsuba

SUN = DirectionalLight((0.0, -1.0, -0.5), (3.0, 2.0, 4.0))
LAYERS = 24


def layers() -> Scene:
    """Return thin layers, half of them in shadow, and a glass ball that is far from all of them."""
    thin = Material(coverage=0.06, albedo=(0.9, 0.6, 0.3), specular=0.0)
    shade = Object("shade", quad((-1.0, 2.0, -3.0), (1.0, 0, 0), (0, 0, -3.0)), Material())
    glass = Material(transmission=(0.9, 0.9, 0.9), index=1.5, solid=True)
    sheets = [
        Object(f"layer {k}", quad((0, 0, -3 - 0.1 * k), (2.0, 0, 0), (0, 2.0, 0)), thin)
        for k in range(LAYERS)
    ]
    ball = Object("ball", sphere((300.0, 0.0, 0.0), 1.0, 8, 4), glass)
    return Scene("layers", Camera((0, 0, 0), (0, 0, -1)), (shade, *sheets, ball), lights=(SUN,))


@needs_mitsuba
@pytest.mark.parametrize("ssaa", [2, 8])
def test_fewer_shadow_rays_give_the_same_light(ssaa: int) -> None:
    scene = layers()
    certain = scene.effects & ~Effect.CAUSTICS
    assert is_random(scene, scene.effects)
    assert not is_random(scene, certain)
    expected = matched(scene, (8, 8), ssaa, certain)
    pictures = [matched(scene, (8, 8), ssaa, part=part) for part in range(4)]
    assert len({picture.tobytes() for picture in pictures}) == 4
    means = np.mean(pictures, axis=0).mean(axis=(0, 1)), expected.mean(axis=(0, 1))
    np.testing.assert_allclose(*means, rtol=5e-3)
