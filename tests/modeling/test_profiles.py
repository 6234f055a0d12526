"""Profiles: smooth curves, fillets and insets."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.modeling.profiles import inset, outline, smooth_curve


def test_a_smooth_curve_keeps_its_ends_and_is_evenly_spaced() -> None:
    curve = smooth_curve([(0, 0), (1, 0), (1, 1)], 40)
    np.testing.assert_allclose(curve[[0, -1]], [(0, 0), (1, 1)])
    steps = np.linalg.norm(np.diff(curve, axis=0), axis=1)
    np.testing.assert_allclose(steps, steps.mean(), rtol=1e-2)
    # The corner itself is cut off.
    assert np.linalg.norm(curve - [1, 0], axis=1).min() > 0.1


def test_fillets_are_arcs_that_meet_the_edges_smoothly() -> None:
    curve = outline([(0.0, 0.0, 0.0), (2.0, 0.0, 0.5), (2.0, 3.0, 0.0)], 1.0)
    arc = curve[1:-1]
    np.testing.assert_allclose(np.linalg.norm(arc - (1.5, 0.5), axis=1), 0.5, rtol=1e-12)
    np.testing.assert_allclose(arc[[0, -1]], [(1.5, 0), (2, 0.5)], atol=1e-12)


def test_fillets_that_overlap_are_refused() -> None:
    with pytest.raises(ValueError, match="edge 1 of an outline overlap"):
        outline([(0, 0, 0), (1, 0, 0.6), (1, 1, 0.6), (0, 1, 0)], 1.0)


def test_an_inset_is_inside_and_starts_on_the_axis() -> None:
    angle = np.linspace(0, np.pi / 2, 200)
    bowl = np.stack([2 * np.sin(angle), -2 * np.cos(angle)], axis=1)
    inner = inset(bowl, 0.5)
    np.testing.assert_allclose(np.linalg.norm(inner, axis=1), 1.5, rtol=1e-4)
    assert inner[0, 0] == 0
