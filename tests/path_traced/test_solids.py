"""Path-traced solids and frosted sheets against closed forms."""

from __future__ import annotations

import dataclasses
import importlib.util
import math

import numpy as np
import numpy.typing as npt
import pytest

from oitbench.modeling.mesh import box, quad, sphere
from oitbench.path_traced.trace.reflection import interface_roughness, spread
from oitbench.path_traced.trace.render import Estimate, render
from oitbench.scene import RGB, Camera, DirectionalLight, EnvironmentLight, Material, Object, Scene

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("mitsuba") is None, reason="Mitsuba is not installed"
)
Floats = npt.NDArray[np.float64]

TINT: RGB = (0.9, 0.6, 0.3)
WHITE: RGB = (1.0, 1.0, 1.0)
NARROW = Camera((0.0, 0.0, 6.0), fov_y=0.02)


def _agrees(estimate: Estimate, expected: npt.ArrayLike) -> None:
    """Compare the mean of all pixels within six of its standard errors."""
    error = np.sqrt(estimate.variance.mean(axis=(0, 1)) / estimate.mean[..., 0].size)
    assert (error < 0.02 * np.max(expected)).all()
    deviation = np.abs(estimate.mean.mean(axis=(0, 1)) - expected)
    assert (deviation < 6 * error + 1e-5).all(), (deviation, error)


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
    _agrees(estimate, expected)


def test_a_mean_path_through_front_and_back_is_tinted_twice() -> None:
    """Rays that a solid of index almost 1 does not bend cross it by chords of mean 4V/S."""
    faint = Material(transmission=(0.99, 0.98, 0.97), index=1.0001, roughness=0.0, solid=True)
    ball = sphere((0, 0, 0), 1.0, 64, 32)
    camera = Camera((0.0, 0.0, 400.0), fov_y=2 * math.atan(1 / 400))
    scene = Scene("ball", camera, (Object("ball", ball, faint), _wall(-3)))
    image = render(scene, (48, 48)).mean
    x, y = np.meshgrid(*[(np.arange(48) - 23.5) / 24] * 2)
    inside = np.hypot(x, y) < 0.95
    lost = 1 - image[inside].mean(axis=0)
    # The mean chord of a disk of parallel rays out to 0.95 of the radius, over that of the ball.
    part = (1 - (1 - 0.95**2) ** 1.5) / 0.95**2
    np.testing.assert_allclose(lost, (1 - np.square(faint.transmission)) * part, rtol=0.03)


@pytest.mark.parametrize("collimation", [1.0, 0.8])
def test_clear_glass_between_white_surroundings_is_white(collimation: float) -> None:
    clear = Material(
        transmission=WHITE, index=1.5, roughness=0.0, solid=True, collimation=collimation
    )
    ball = Object("ball", sphere((0, 0, 0), 1.0, 32, 16), clear)
    camera = Camera((0.0, 0.0, 6.0), fov_y=0.2)
    scene = Scene("furnace", camera, (ball,), lights=(EnvironmentLight(WHITE),))
    estimate = render(scene, (16, 16), spp=4)
    # Microfacets lose what they would reflect more than once.
    lost = 0.0 if collimation == 1 else 0.06
    assert estimate.mean.max() < 1 + 1e-4
    assert estimate.mean.mean() > 1 - lost - 1e-4


def test_a_ball_of_glass_shows_what_is_behind_it_upside_down() -> None:
    above = Object("above", quad((0, 10, -4), (40, 0, 0), (0, 10, 0)), Material(emission=TINT))
    clear = Material(transmission=WHITE, index=1.5, roughness=0.0, solid=True)
    ball = Object("ball", sphere((0, 0, 0), 1.0, 64, 32), clear)
    image = render(Scene("ball", Camera((0.0, 0.0, 6.0), fov_y=0.2), (above, ball)), (8, 8)).mean
    assert image[:3].max() < 0.2
    assert image[5:].min() > 0.2


def test_light_that_is_bent_arrives_by_photons_alone() -> None:
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
        # A disk of radius R has a variance of R²/4 along an axis, a pixel and a difference of
        # pixels one of p²/12 each.
        expected = (spread(collimation) * distance) ** 2 / 4 + PIXEL**2 / 6
        assert variance == pytest.approx(expected, rel=0.04)


def test_what_a_frosted_sheet_does_not_cover_goes_straight_on() -> None:
    frosted = Material(0.25, transmission=(0.8, 0.8, 0.8), collimation=0.2)
    sheet = Object("sheet", quad((0, 0, 0), (9, 0, 0), (0, 9, 0)), frosted)
    row = _edge(sheet, 1.0)
    # What is spread rises by 2/(πR) times a pixel where the rest rises at once.
    rise = 0.75 + 0.25 * 0.8 * PIXEL * 2 / math.pi / spread(0.2)
    assert row[32] - row[31] == pytest.approx(rise, abs=0.02)
    assert row[-1] == pytest.approx(0.75 + 0.25 * 0.8, abs=0.01)


def test_a_frosted_solid_spreads_as_a_sheet_of_its_collimation_does() -> None:
    glass = Material(transmission=WHITE, index=1.5, roughness=0.0, solid=True, collimation=0.7)
    row = _edge(Object("slab", box((0, 0, 0), (9.0, 9.0, 0.01)), glass), 1.0)
    x = (np.arange(64) - 31.5) * PIXEL
    # Two Beckmann lobes make a Gaussian, of which 68 % lie within a standard deviation.
    low, high = np.interp((0.1587, 0.8413), row / row[-8:].mean(), x)
    assert interface_roughness(glass) == pytest.approx(0.15)
    assert (high - low) / 2 == pytest.approx(spread(0.7) / 2, rel=0.1)


def test_only_what_covers_a_solid_bends() -> None:
    glass = Material(0.5, transmission=WHITE, index=1.5, roughness=0.0, solid=True)
    ball = Object("ball", sphere((0, 0, 0), 1.0, 32, 16), glass)
    above = Object("above", quad((0, 10, -4), (40, 0, 0), (0, 10, 0)), Material(emission=WHITE))
    camera = Camera((0.0, 0.0, 6.0), fov_y=0.1)
    image = render(Scene("ball", camera, (above, ball)), (8, 8), spp=16).mean
    # Half of the light enters, of which half leaves at the back; the rest is bent at one side.
    assert 0.2 < image[:3].mean() < image[5:].mean() + 0.5
    alone = dataclasses.replace(ball, material=dataclasses.replace(glass, coverage=0.0))
    clear = render(Scene("ball", camera, (above, alone)), (8, 8)).mean
    np.testing.assert_allclose(clear[:4], 1, atol=1e-6)
    np.testing.assert_allclose(clear[4:], 0, atol=1e-6)


def test_the_same_seed_gives_the_same_picture_and_another_seed_another() -> None:
    glass = Material(transmission=TINT, index=1.5, solid=True)
    slab = Object("slab", box((0, 0, 0), (4, 4, 0.5)), glass)
    scene = Scene("slab", NARROW, (slab, _wall(-3)))
    first, again, other = (render(scene, (4, 4), seed=seed).mean for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()
