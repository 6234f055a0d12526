"""Glass of an attenuation color and distance."""

from __future__ import annotations

import math

import numpy as np
import pytest

from oitbench.errors import SceneError
from oitbench.modeling.glass import transmission
from oitbench.modeling.mesh import box
from oitbench.path_traced.optics.materials import absorption
from oitbench.scene import RGB, Material, Object

COLOR: RGB = (0.9, 0.5, 0.1)
BLOCK = box((1, 2, 3), (0.2, 0.3, 0.6))


def test_the_path_tracer_absorbs_as_much_as_the_color_says() -> None:
    found = transmission(COLOR, 0.25, BLOCK)
    glass = Object("block", BLOCK, Material(transmission=found, solid=True, index=1.5))
    np.testing.assert_allclose(np.exp(-0.25 * np.array(absorption(glass))), COLOR, rtol=1e-6)


def test_two_surfaces_let_pass_as_much_as_the_mean_chord() -> None:
    chord = 4 * 0.036 / (2 * (0.06 + 0.12 + 0.18))
    expected = np.array(COLOR) ** (chord / 0.5)
    np.testing.assert_allclose(np.square(transmission(COLOR, 0.5, BLOCK)), expected, rtol=1e-6)


def test_clear_and_black_glass() -> None:
    assert transmission(COLOR, math.inf, BLOCK) == (1, 1, 1)
    assert transmission((1.0, 0.0, 1.0), 0.1, BLOCK) == (1, 0, 1)
    with pytest.raises(SceneError, match="attenuation distance is 0; give one above 0"):
        transmission(COLOR, 0.0, BLOCK)
    with pytest.raises(SceneError, match="glass: color"):
        transmission((1.5, 0.0, 1.0), 0.1, BLOCK)
