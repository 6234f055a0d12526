"""Particles: thickness, places and orientation."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.modeling.particles import fill, shared_coverage, sprites
from oitbench.scene import Sprites


def test_shared_coverage_keeps_the_transmittance_of_the_whole() -> None:
    assert shared_coverage(0.3, 100, 100) == pytest.approx(0.3)
    assert (1 - shared_coverage(0.3, 100, 250)) ** 250 == pytest.approx(0.7**100)


def test_points_fill_balls_evenly_and_by_volume() -> None:
    random = np.random.default_rng(3)
    points = fill(random, 20000, [(0, 0, 0), (10, 0, 0)], [1.0, 2.0], stretch=(1, 0.5, 1))
    large = points[:, 0] > 5
    assert large.mean() == pytest.approx(8 / 9, abs=0.01)
    local = (points[large] - [10, 0, 0]) / [1, 0.5, 1]
    reach = np.linalg.norm(local, axis=1) / 2
    assert reach.max() <= 1
    # Half of the volume of a ball is within 0.5^(1/3) of its radius.
    assert (reach < 0.5 ** (1 / 3)).mean() == pytest.approx(0.5, abs=0.015)


def test_sprites_are_turned_at_random() -> None:
    found = sprites(np.random.default_rng(1), [(0, 0, 0), (1, 2, 3)], [0.5, 2.0], (0, 1, 0))
    assert isinstance(found, Sprites)
    first, second = np.asarray(found.turns)
    assert first != second
    assert found.toward_light == (0, 1, 0)
    np.testing.assert_array_equal(found.radii, [0.5, 2.0])
