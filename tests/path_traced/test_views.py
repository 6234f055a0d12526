"""Views in both renderers: parallel rays, and meshes that face the camera."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from oitbench.gl.device import Device
from oitbench.image.files import Image, box_downsample
from oitbench.modeling.mesh import box, quad
from oitbench.modeling.particles import puff, sprites
from oitbench.path_traced.matched.render import matched
from oitbench.path_traced.trace.render import render as traced
from oitbench.scene import (
    Camera,
    DirectionalLight,
    Material,
    Object,
    Scene,
    Sprites,
    Strands,
    Texture,
)
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


def cloud() -> Object:
    random = np.random.default_rng(3)
    centers = random.normal(size=(12, 3)) * 0.6
    dust = Material(puff(0.5), albedo=(0.9, 0.8, 0.7), isotropic=True)
    return Object("cloud", sprites(random, centers, 0.7, (-0.4, 1.0, 0.3)), dust)


ASIDE = Camera((-3.0, 1.0, 0.5))


@pytest.mark.parametrize("camera", [OBLIQUE, ASIDE], ids=["parallel", "aside"])
def test_particles_face_any_camera_alike(device: Device, camera: Camera) -> None:
    scene = Scene("cloud", camera, (cloud(),), lights=(SUN,), background=(0.1, 0.2, 0.3))
    unlit = replace(scene, objects=(replace(scene.objects[0], receives_shadows=False),))
    exact, truth = both(device, unlit)
    assert exact.std() > 0.02
    np.testing.assert_allclose(exact, truth, atol=2e-3)
    # They would be another picture if they faced another camera.
    assert isinstance(scene.objects[0].mesh, Sprites)
    main = replace(cloud(), mesh=scene.objects[0].mesh.for_view(Camera((0, 0, 5)), 1))
    other, _ = both(device, replace(unlit, objects=(main,)))
    assert np.abs(other - exact).max() > 0.02


@pytest.mark.parametrize("camera", [OBLIQUE, ASIDE], ids=["parallel", "aside"])
def test_thin_strands_cover_alike(device: Device, camera: Camera) -> None:
    random = np.random.default_rng(5)
    starts = random.normal(size=(150, 1, 3)) * 0.5
    points = starts + np.cumsum(random.normal(size=(150, 5, 3)) * 0.15, axis=1)
    hair = Object("hair", Strands(points, 0.004), Material(0.8, emission=(1.0, 0.6, 0.3)))
    exact, truth = both(device, Scene("hair", camera, (hair,), background=(0.0, 0.1, 0.3)))
    assert exact.std() > 0.01
    off = np.abs(exact - truth).max(axis=-1)
    # Rasterizers snap corners to 1/256 of a pixel, which is all that a strand is wide.
    assert off.mean() < 0.01 * np.abs(exact - (0.0, 0.1, 0.3)).mean()
    assert (off > 1e-3).mean() < 0.03


def test_the_light_of_thin_strands_does_not_depend_on_the_size_of_a_pixel(device: Device) -> None:
    """In the mean, a ribbon of one pixel covers as much as the thinner strand."""
    points = np.linspace((-0.8, -0.6, 0.0), (0.9, 0.7, 0.0), 9)[None]
    strand = Object("s", Strands(points, 0.01), Material(0.5, emission=(1.0, 1.0, 1.0)))
    scene = Scene("strand", Camera((0, 0, 3), height=2.0), (strand,))
    length, area = float(np.linalg.norm(points[0, -1] - points[0, 0])), 2.0 * 3.0
    for size in ((96, 64), (480, 320), (960, 640)):
        found = render(device, scene, "a_buffer", size=size).mean()
        assert found == pytest.approx(0.5 * 0.01 * length / area, rel=0.03)
