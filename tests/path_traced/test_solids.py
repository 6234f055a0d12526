"""Path-traced solids and frosted sheets against closed forms."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from oitbench.modeling.mesh import box, quad, sphere
from oitbench.path_traced.optics.materials import interface_roughness, spread
from oitbench.path_traced.trace.render import render
from oitbench.scene import (
    RGB,
    Camera,
    DirectionalLight,
    EnvironmentLight,
    Floats,
    Material,
    Object,
    Scene,
)
from oitbench.scene.texturing import constant
from tests.path_traced.agreement import assert_mean, needs_mitsuba

pytestmark = needs_mitsuba

TINT: RGB = (0.9, 0.6, 0.3)
WHITE: RGB = (1.0, 1.0, 1.0)
NARROW = Camera((0.0, 0.0, 6.0), fov_y=0.02)


def _wall(z: float, emission: RGB = WHITE) -> Object:
    return Object("wall", quad((0, 0, z), (40, 0, 0), (0, 40, 0)), Material(emission=emission))


def test_a_slab_tints_by_its_thickness_and_reflects_by_fresnel() -> None:
    width, depth = 4.0, 0.5
    glass = Material(transmission=TINT, index=1.5, roughness=0.0, solid=True)
    slab = Object("slab", box((0, 0, 0), (width, width, depth)), glass)
    estimate = render(Scene("slab", NARROW, (slab, _wall(-3))), (24, 24), spp=4)
    chord = 4 * width**2 * depth / (2 * width**2 + 4 * width * depth)
    passed = np.asarray(TINT) ** (2 * depth / chord)
    mirrored = 0.04
    expected = (1 - mirrored) ** 2 * passed / (1 - (mirrored * passed) ** 2)
    assert_mean(estimate, expected)


def test_the_mean_tint_of_a_solid_is_that_of_two_surfaces() -> None:
    """A solid of index almost 1 refracts no ray, so the mean chord of the rays is 4V/S."""
    faint = Material(transmission=(0.99, 0.98, 0.97), index=1.0001, roughness=0.0, solid=True)
    ball = sphere((0, 0, 0), 1.0, 64, 32)
    camera = Camera((0.0, 0.0, 400.0), fov_y=2 * math.atan(1 / 400))
    scene = Scene("ball", camera, (Object("ball", ball, faint), _wall(-3)))
    image = render(scene, (48, 48)).mean
    x, y = np.meshgrid(*[(np.arange(48) - 23.5) / 24] * 2)
    inside = np.hypot(x, y) < 0.95
    lost = 1 - image[inside].mean(axis=0)
    # The mean chord of parallel rays within 0.95 of the radius, relative to that of the ball.
    part = (1 - (1 - 0.95**2) ** 1.5) / 0.95**2
    np.testing.assert_allclose(
        lost, (1 - np.square(constant(faint.transmission))) * part, rtol=0.03
    )


@pytest.mark.parametrize("collimation", [1.0, 0.8])
def test_clear_glass_in_a_white_environment_is_white(collimation: float) -> None:
    clear = Material(
        transmission=WHITE, index=1.5, roughness=0.0, solid=True, collimation=collimation
    )
    ball = Object("ball", sphere((0, 0, 0), 1.0, 32, 16), clear)
    camera = Camera((0.0, 0.0, 6.0), fov_y=0.2)
    scene = Scene("furnace", camera, (ball,), lights=(EnvironmentLight(WHITE),))
    estimate = render(scene, (16, 16), spp=4)
    # Microfacets lose the light that they would reflect more than once.
    lost = 0.0 if collimation == 1 else 0.06
    assert estimate.mean.max() < 1 + 1e-4
    assert estimate.mean.mean() > 1 - lost - 1e-4


def test_a_ball_of_glass_shows_the_wall_behind_it_upside_down() -> None:
    above = Object("above", quad((0, 10, -4), (40, 0, 0), (0, 10, 0)), Material(emission=TINT))
    clear = Material(transmission=WHITE, index=1.5, roughness=0.0, solid=True)
    ball = Object("ball", sphere((0, 0, 0), 1.0, 64, 32), clear)
    image = render(Scene("ball", Camera((0.0, 0.0, 6.0), fov_y=0.2), (above, ball)), (8, 8)).mean
    assert image[:3].max() < 0.2
    assert image[5:].min() > 0.2


def test_refracted_light_arrives_by_photons_alone() -> None:
    paper = Object("floor", quad((0, 0, 0), (9, 0, 0), (0, 0, -9)), Material(albedo=WHITE))
    glass = Material(transmission=WHITE, index=1.5, roughness=0.0, solid=True)
    pane = Object("pane", box((0, 2, 0), (3.0, 0.2, 3.0)), glass)
    camera = Camera((0.0, 0.4, 5.0), (0.0, 0.0, 0.0), fov_y=0.05)
    sun = DirectionalLight((0.0, -1.0, 0.0), (math.pi, math.pi, math.pi))
    scene = Scene("pane", camera, (paper, pane), lights=(sun,))
    image = render(scene, (16, 16), spp=4).mean
    mirrored = 0.04
    assert image.mean() == pytest.approx((1 - mirrored) / (1 + mirrored), rel=0.02)


PIXEL = 1 / 32


def _edge(pane: Object, distance: float) -> Floats:
    """Return the brightness across a vertical edge that is `distance` behind `pane`."""
    half = Object(
        "half", quad((20, 0, -distance), (20, 0, 0), (0, 40, 0)), Material(emission=WHITE)
    )
    camera = Camera((0.0, 0.0, 100.0), fov_y=2 * math.atan(1 / 100))
    image = render(Scene("edge", camera, (half, pane)), (64, 64), ssaa=4, spp=8).mean
    return np.asarray(image[..., 0].mean(axis=0), dtype=np.float64)


@pytest.mark.parametrize("collimation", [0.6, 0.2])
def test_a_frosted_sheet_blurs_in_proportion_to_the_distance(collimation: float) -> None:
    frosted = Material(transmission=WHITE, collimation=collimation)
    sheet = Object("sheet", quad((0, 0, 0), (9, 0, 0), (0, 9, 0)), frosted)
    x = (np.arange(63) - 31) * PIXEL
    for distance in (0.5, 1.0):
        slope = np.diff(_edge(sheet, distance))
        mean = (slope * x).sum() / slope.sum()
        variance = (slope * (x - mean) ** 2).sum() / slope.sum()
        # A disk of radius R has the variance R²/4 along an axis. A pixel and a difference of
        # pixels add p²/12 each.
        expected = (spread(collimation) * distance) ** 2 / 4 + PIXEL**2 / 6
        assert variance == pytest.approx(expected, rel=0.04)


def test_light_beside_the_coverage_of_a_frosted_sheet_goes_straight_on() -> None:
    frosted = Material(0.25, transmission=(0.8, 0.8, 0.8), collimation=0.2)
    sheet = Object("sheet", quad((0, 0, 0), (9, 0, 0), (0, 9, 0)), frosted)
    row = _edge(sheet, 1.0)
    # The spread part rises by 2/(πR) per pixel width, and the rest rises at once.
    rise = 0.75 + 0.25 * 0.8 * PIXEL * 2 / math.pi / spread(0.2)
    assert row[32] - row[31] == pytest.approx(rise, abs=0.02)
    assert row[-1] == pytest.approx(0.75 + 0.25 * 0.8, abs=0.01)


def test_a_frosted_solid_spreads_like_a_sheet_of_its_collimation() -> None:
    glass = Material(transmission=WHITE, index=1.5, roughness=0.0, solid=True, collimation=0.7)
    row = _edge(Object("slab", box((0, 0, 0), (9.0, 9.0, 0.01)), glass), 1.0)
    x = (np.arange(64) - 31.5) * PIXEL
    # Two Beckmann lobes form a Gaussian, of which 68 % lie within one standard deviation.
    low, high = np.interp((0.1587, 0.8413), row / row[-8:].mean(), x)
    assert interface_roughness(glass) == pytest.approx(0.15)
    assert (high - low) / 2 == pytest.approx(spread(0.7) / 2, rel=0.1)


def test_only_the_covered_part_of_a_solid_refracts() -> None:
    glass = Material(0.5, transmission=WHITE, index=1.5, roughness=0.0, solid=True)
    ball = Object("ball", sphere((0, 0, 0), 1.0, 32, 16), glass)
    above = Object("above", quad((0, 10, -4), (40, 0, 0), (0, 10, 0)), Material(emission=WHITE))
    camera = Camera((0.0, 0.0, 6.0), fov_y=0.1)
    image = render(Scene("ball", camera, (above, ball)), (8, 8), spp=16).mean
    # Half of the light enters, and half of that leaves at the back. The rest is refracted once.
    assert 0.2 < image[:3].mean() < image[5:].mean() + 0.5
    alone = dataclasses.replace(ball, material=dataclasses.replace(glass, coverage=0.0))
    clear = render(Scene("ball", camera, (above, alone)), (8, 8)).mean
    np.testing.assert_allclose(clear[:4], 1, atol=1e-6)
    np.testing.assert_allclose(clear[4:], 0, atol=1e-6)
