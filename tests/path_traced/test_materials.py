"""Absorption in solids."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.modeling.mesh import box, sphere
from oitbench.path_traced.optics.materials import absorption
from oitbench.scene import Material, Object
from oitbench.scene.solids import mean_chord

SLAB = box((0, 1, 0), (2, 0.5, 2))


def test_the_mean_chord_of_a_solid_is_four_times_its_volume_over_its_area() -> None:
    assert mean_chord(SLAB) == pytest.approx(4 * 2.0 / (2 * 4 + 4 * 1.0))
    assert mean_chord(sphere((5, 0, 0), 3, 128, 64)) == pytest.approx(4 * 3 / 3, rel=2e-3)


def test_the_absorption_over_a_mean_chord_is_that_of_both_surfaces() -> None:
    glass = Object("glass", SLAB, Material(transmission=(0.9, 0.5, 0.0), index=1.5, solid=True))
    through = np.exp(-np.array(absorption(glass)) * mean_chord(SLAB))
    np.testing.assert_allclose(through, [0.81, 0.25, 0], atol=1e-6)
