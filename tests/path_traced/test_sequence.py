"""Evenly spread random numbers of the samples of a pixel."""

from __future__ import annotations

import importlib
import math

import numpy as np

from oitbench.modeling.mesh import quad
from oitbench.path_traced import llvm
from oitbench.path_traced.trace.render import render
from oitbench.path_traced.trace.sequence import Turn
from oitbench.scene import Camera, Floats, Material, Medium, Object, Scene
from tests.path_traced.agreement import assert_mean, needs_mitsuba

pytestmark = needs_mitsuba

SAMPLES, SSAA, WIDTH = 16, 2, 6


def _places(block: int, first: int = 0) -> Floats:
    """Return the numbers `place` of samples and sub-pixels, shape (SAMPLES, 4, WIDTH)."""
    mitsuba, drjit = llvm.load(), importlib.import_module("drjit")
    turns = [Turn(0, block, number, first, WIDTH, SSAA) for number in range(SAMPLES)]
    found = [turn.choices(mitsuba, drjit, 4 * WIDTH).place.numpy() for turn in turns]
    return np.asarray(found, dtype=np.float64).reshape(SAMPLES, 4, WIDTH)


def test_the_numbers_of_a_pixel_leave_no_gaps() -> None:
    places = _places(7)
    assert places.min() >= 0
    assert places.max() < 1
    for pixel in (0, 2):
        # Two rows of two sub-pixels.
        own = np.sort(places[:, :2, pixel : pixel + 2].ravel())
        gaps = np.diff(own, append=own[0] + 1)
        # There is one number in each interval of the length 1/n.
        assert gaps.max() < 2 / len(own)
    assert len(np.unique(places)) > 0.99 * places.size


def test_pairs_of_numbers_leave_no_gaps_in_the_square() -> None:
    mitsuba, drjit = llvm.load(), importlib.import_module("drjit")
    turns = [Turn(0, 3, number, 0, 1, 1) for number in range(SAMPLES)]
    pairs = [turn.choices(mitsuba, drjit, 1).facet.numpy().ravel() for turn in turns]
    # One point in each of 16 boxes, of each shape.
    for across in (1, 2, 4, 8, 16):
        boxes = np.floor(np.asarray(pairs) * (across, SAMPLES // across)).astype(int)
        assert len(np.unique(boxes, axis=0)) == SAMPLES


def test_blocks_are_independent_and_parts_of_a_picture_are_not() -> None:
    places = _places(7)
    assert len(np.intersect1d(places, _places(8))) < 0.01 * places.size
    later = _places(7, first=2 * WIDTH)
    np.testing.assert_array_equal(later[:, :2], places[:, 2:])


def test_samples_in_fog_are_spread_evenly() -> None:
    wall = Object("wall", quad((0, 0, -3), (40, 0, 0), (0, 40, 0)), Material(emission=(1, 1, 1)))
    fog = Medium(0.8, (-8.0, -8.0, -1.0), (8.0, 8.0, 1.0), albedo=(0.0, 0.0, 0.0))
    scene = Scene("fog", Camera((0.0, 0.0, 6.0), fov_y=0.02), (wall,), medium=fog)
    passed = math.exp(-0.8 * 2)
    error = render(scene, (16, 16), 2, 32).mean - passed
    # Independent samples would have this deviation.
    independent = math.sqrt(passed * (1 - passed) / (4 * 32))
    assert np.sqrt((error**2).mean()) < 0.4 * independent


def test_choices_of_one_path_are_independent() -> None:
    # Between two half mirrors, of the light t² / (1 − r²) passes with t = r = 1/2.
    half = Material(transmission=(1.0, 1.0, 1.0), specular=0.5, roughness=0.0)
    sheets = [Object(f"sheet {z}", quad((0, 0, z), (90, 0, 0), (0, 90, 0)), half) for z in (0, -1)]
    wall = Object("wall", quad((0, 0, -3), (90, 0, 0), (0, 90, 0)), Material(emission=(1, 1, 1)))
    camera = Camera((0.0, 0.0, 6.0), fov_y=0.001)
    estimate = render(Scene("mirrors", camera, (*sheets, wall)), (16, 16), 2, 64)
    assert_mean(estimate, [1 / 3] * 3)
