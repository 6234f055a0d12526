"""Paths of cameras."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from oitbench.motion.path import FRAMES, TURNS, cameras_of, middle
from oitbench.scene.paths import between, orbit
from tests.motion.scenes import crossing

FIRST, SECOND = orbit(crossing().camera, 2, 0.2)
PATH = (*between(FIRST, SECOND, 3), FIRST)


def test_a_scene_without_a_path_is_orbited() -> None:
    scene = crossing()
    assert cameras_of(scene) == orbit(scene.camera, FRAMES, TURNS)
    assert cameras_of(scene, 5, 0.5) == orbit(scene.camera, 5, 0.5)


def test_a_scene_has_a_path_of_its_own() -> None:
    scene = replace(crossing(), path=PATH)
    assert cameras_of(scene) == PATH
    assert cameras_of(scene, 4) == PATH
    assert cameras_of(scene, 3, 1.0) == orbit(scene.camera, 3, 1.0)
    half = cameras_of(scene, 7)
    assert (half[0], half[2], half[-1]) == (PATH[0], PATH[1], PATH[3])
    assert half[1].position == pytest.approx(middle(PATH[0], PATH[1]).position)


def test_the_middle_of_two_cameras() -> None:
    one, other = orbit(crossing().camera, 2, 0.02)
    found = middle(one, other)
    assert found.position == pytest.approx(np.add(one.position, other.position) / 2)
    assert math.dist(found.position, one.target) == pytest.approx(1.0, rel=0.01)
