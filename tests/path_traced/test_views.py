"""Orthographic cameras in both renderers: the same points, footprints, directions and clips."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.gl.device import Device
from oitbench.image.files import Image, box_downsample
from oitbench.modeling.mesh import box, quad
from oitbench.path_traced.matched.render import matched
from oitbench.path_traced.trace.render import render as traced
from oitbench.scene import Camera, DirectionalLight, Material, Object, Scene, Texture
from tests.helpers import render
from tests.path_traced.agreement import needs_mitsuba

pytestmark = needs_mitsuba
SIZE = (24, 16)
SUN = DirectionalLight((0.4, -1.0, -0.3), (2.0, 2.5, 3.0))
OBLIQUE = Camera((2.0, 3.0, 4.0), (0.1, 0.0, 0.0), height=3.0)


def both(device: Device, scene: Scene) -> tuple[Image, Image]:
    """Return exact compositing and matched tracing, 2 × 2 sub-pixels each."""
    fine = (2 * SIZE[0], 2 * SIZE[1])
    return box_downsample(render(device, scene, "a_buffer", size=fine), 2), matched(scene, SIZE, 2)


def panes() -> tuple[Object, ...]:
    rough = Material(0.6, transmission=(0.3, 0.8, 0.9), albedo=(0.2, 0.1, 0.1), roughness=0.5)
    clear = Material(transmission=(0.9, 0.5, 0.2), index=1.5)
    return (
        Object("floor", quad((0, -1, 0), (4, 0, 0), (0, 0, -4)), Material(albedo=(0.8, 0.5, 0.2))),
        Object("rough", box((-0.4, -0.2, 0), (0.8, 0.9, 0.7)), rough),
        Object("clear", quad((0.5, 0.2, 0.6), (0.7, 0, 0.2), (0, 0.6, 0.1)), clear),
    )


def test_parallel_rays_reflect_and_transmit_alike(device: Device) -> None:
    scene = Scene("panes", OBLIQUE, panes(), background=(0.3, 0.4, 0.5))
    exact, truth = both(device, scene)
    assert exact.std() > 0.05
    off = np.abs(exact - truth).max(axis=-1)
    assert np.median(off) < 1e-5
    assert (off > 1e-3).mean() < 0.02
    lit = Scene("lit", OBLIQUE, panes(), lights=(SUN,))
    # Only panes that mirror each other differ in full.
    assert np.median(np.abs(matched(lit, SIZE, 2) - traced(lit, SIZE, ssaa=2).mean)) < 1e-6


@pytest.mark.parametrize("tilt", [0.0, 2.0])
@pytest.mark.parametrize("distance", [1.0, 30.0])
def test_textures_are_filtered_alike_at_any_distance(
    device: Device, distance: float, tilt: float
) -> None:
    texels = np.random.default_rng(1).random((64, 64)).astype(np.float32)
    leaf = Material(Texture(texels), emission=(1.0, 0.5, 0.2))
    card = Object("card", quad((0, 0, 0), (2, 0, 0), (0, 2, 2 * tilt)), leaf)
    camera = Camera((0, 0, distance + 5.0), height=1.5)
    exact, truth = both(device, Scene("card", camera, (card,), background=(0.1, 0.1, 0.4)))
    assert 0.01 < exact.std() < 0.2  # Filtered, but not to a constant.
    np.testing.assert_allclose(exact, truth, atol=2e-3)


def test_both_clip_at_the_same_planes(device: Device) -> None:
    half = Material(0.5, emission=(1.0, 0.0, 0.0))
    sheets = tuple(
        Object(f"{z}", quad((0, 0, z), (3, 0, 0), (0, 3, 0.0)), half)
        for z in (1.95, 1.85, -1.9, -2.1)
    )
    camera = Camera((0, 0, 2.0), near=0.1, far=4.0, height=2.0)
    exact, truth = both(device, Scene("clipped", camera, sheets))
    np.testing.assert_allclose(exact[..., 0], 0.75, atol=1e-6)
    np.testing.assert_allclose(truth[..., 0], 0.75, atol=1e-6)
