"""Surroundings: skies, and rooms with windows."""

from __future__ import annotations

import math

import numpy as np
import pytest

from oitbench.modeling.surroundings import Window, gradient_sky, room
from oitbench.scene import Array, EnvironmentLight, Texture


def texels_of(light: EnvironmentLight) -> Array:
    assert isinstance(light.radiance, Texture)
    return light.radiance.texels


def test_a_gradient_sky_runs_from_below_to_above() -> None:
    texels = texels_of(gradient_sky([(-90, (0, 0, 0)), (0, (1, 1, 1)), (90, (1, 0, 0))]))
    assert texels.shape == (64, 128, 3)
    np.testing.assert_allclose(texels[0, 5], (1, 1 / 64, 1 / 64), rtol=1e-5)
    np.testing.assert_allclose(texels[-1, 5], 1 / 64, rtol=1e-5)
    assert (texels == texels[:, :1]).all()


def test_a_room_has_its_colors_and_its_window_in_their_directions() -> None:
    window = Window(math.radians(90), math.radians(30), 0.4, 0.4, (9.0, 8.0, 7.0))
    texels = texels_of(room((1, 2, 3), (4, 5, 6), (7, 8, 9), [window]))
    assert texels.shape == (64, 128, 3)
    np.testing.assert_allclose(texels[0, 0], (1, 2, 3), atol=0.01)
    np.testing.assert_allclose(texels[-1, 0], (7, 8, 9), atol=0.01)
    np.testing.assert_allclose(texels[32, 0], (4, 5, 6), atol=0.01)
    # To the right of straight ahead (column 64) by a quarter turn, and 30° above the horizon.
    np.testing.assert_allclose(texels[21, 96], (9, 8, 7), atol=1e-5)


def test_a_window_behind_the_viewer_is_whole() -> None:
    window = Window(math.radians(175), 0.0, 0.5, 0.5, (2, 2, 2))
    bright = texels_of(room((1, 1, 1), (1, 1, 1), (1, 1, 1), [window]))[32, :, 0] > 1.5
    assert bright[0]
    assert bright[-1]
    assert bright.sum() == pytest.approx(0.5 / (2 * math.pi) * 128, abs=2)
