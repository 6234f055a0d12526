"""Closed solids: volumes, and refused rings."""

from __future__ import annotations

import math

import numpy as np
import pytest

from oitbench.modeling.solids import closed, loft, turned
from tests.meshes import signed_volume


def test_open_solids_are_refused() -> None:
    with pytest.raises(ValueError, match="must be points"):
        turned(np.array([(0.5, 0.0), (0.5, 1.0), (0.0, 1.0)]), 8)


def test_a_loft_joins_elliptic_rings() -> None:
    rings = np.array([(0, 0, 0, 0, 0), (-1, 0, 3, 0, 0.5), (-1, 2, 3, 2, 0.5), (1, 2, 1, 2, 0)])
    mesh = loft(rings.astype(np.float64), 256)
    assert signed_volume(mesh) == pytest.approx(math.pi * 2 * 0.5 * 2, rel=1e-3)


def test_the_smallest_closed_grid_is_two_cones() -> None:
    angle = np.arange(4) * math.pi / 2
    waist = np.stack([np.cos(angle), np.ones(4), -np.sin(angle)], axis=1)
    mesh = closed(np.stack([np.zeros((4, 3)), waist, np.tile([0.0, 2, 0], (4, 1))]))
    assert len(mesh.triangles) == 8
    assert signed_volume(mesh) == pytest.approx(4 / 3)
