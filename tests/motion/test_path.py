"""Paths of cameras."""

from __future__ import annotations

import math

import numpy as np
import pytest

from oitbench.motion.path import middle, orbit
from oitbench.scene import Camera

CAMERA = Camera((3.0, 1.0, 0.0), target=(1.0, 1.0, 0.0), fov_y=1.0)


def test_an_orbit_turns_about_the_target() -> None:
    around = orbit(CAMERA, 4, 1.0)
    places = [camera.position for camera in around]
    assert places[0] == pytest.approx(CAMERA.position)
    # Counterclockwise as seen from above.
    assert places[1] == pytest.approx((1.0, 1.0, -2.0))
    assert places[2] == pytest.approx((-1.0, 1.0, 0.0))
    assert all(camera.target == CAMERA.target for camera in around)


def test_the_middle_of_two_cameras() -> None:
    one, other = orbit(CAMERA, 2, 0.02)
    between = middle(one, other)
    assert between.position == pytest.approx(np.add(one.position, other.position) / 2)
    assert math.dist(between.position, CAMERA.target) == pytest.approx(2.0, rel=1e-3)
