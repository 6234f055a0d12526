"""Patterns: checkers of two paints."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.modeling.patterns import checkered_box, checkers
from tests.meshes import agreement, corners, signed_volume


def test_checkers_alternate_and_share_their_vertices() -> None:
    even, odd = checkers((0, 0, 0), (1.5, 0, 0), (0, 1, 0), 3, 2)
    assert len(even.triangles) == len(odd.triangles) == 6
    assert {tuple(p) for p in odd.positions.round(12)} < {
        (x, y, 0.0) for x in (-1.5, -0.5, 0.5, 1.5) for y in (-1.0, 0.0, 1.0)
    }
    np.testing.assert_allclose(corners(even)[:2].mean(axis=(0, 1)), (-1, -0.5, 0), atol=1e-6)
    assert (agreement(even) > 0).all()


def test_a_checkered_box_is_a_closed_box_of_two_colors() -> None:
    even, odd = checkered_box((1, 2, 3), (0.5, 1.0, 2.0), 4)
    assert len(even.triangles) == len(odd.triangles) == 6 * 16
    assert signed_volume(even) + signed_volume(odd) == pytest.approx(1.0, rel=1e-5)
