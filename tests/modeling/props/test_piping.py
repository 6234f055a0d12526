"""Parts of plants: elbows, vessels, railings and gratings."""

from __future__ import annotations

import math

import numpy as np
import pytest

from oitbench.modeling.props.piping import beams, drum, grating, railing, rounded, vessel
from tests.meshes import agreement, bounds, signed_volume

CORNERS = np.array([[(0, 0, 0), (2, 0, 0), (2, 2, 0), (2, 2, 3)]], dtype=np.float64)


def test_elbows_replace_corners_by_arcs() -> None:
    route = rounded(CORNERS, 0.5)[0]
    assert len(route) == 8
    np.testing.assert_array_equal(route[[0, -1]], CORNERS[0, [0, -1]])
    center = np.array([1.5, 0.5, 0.0])
    np.testing.assert_allclose(np.linalg.norm(route[1:4] - center, axis=1), 0.5, rtol=2e-3)


def test_an_elbow_takes_less_than_half_of_a_short_edge() -> None:
    route = rounded(CORNERS, 50.0)[0]
    steps = np.linalg.norm(np.diff(route, axis=0), axis=1)
    assert steps.min() > 0.01


def test_a_vessel_is_a_cylinder_with_domes() -> None:
    mesh = vessel((1, 2, 3), 0.5, 4.0, 4.0)
    low, high = bounds(mesh)
    np.testing.assert_allclose((low[1], high[1]), (2, 6))
    dome = 2 / 3 * math.pi * 0.25 * 0.175
    volume = math.pi * 0.25 * (4 - 0.35) + 2 * dome
    assert signed_volume(mesh) == pytest.approx(volume, rel=0.02)
    assert (agreement(mesh).sum(axis=1) > 0).all()


def test_a_drum_lies_along_its_axis() -> None:
    low, high = bounds(drum((0, 1, 0), 0.5, 4.0, 1.0, (1, 0, 0)))
    np.testing.assert_allclose(high - low, (4, 1, 1), atol=0.02)


def test_a_closed_railing_has_no_doubled_post() -> None:
    loop = [(0, 0, 0), (2.5, 0, 0), (2.5, 0, 2.5), (0, 0, 0)]
    posts = 2 + 2 + 3
    mesh = railing(loop, 4)
    assert len(mesh.triangles) == 8 * (posts + 2 * 3)
    assert bounds(mesh)[1][1] == pytest.approx(1.1, abs=0.03)


def test_beams_span_their_ends() -> None:
    mesh = beams(np.array([(0.0, 0, 0)]), np.array([(0.0, 3, 0)]), 0.2)
    np.testing.assert_allclose(np.subtract(*bounds(mesh)[::-1]), (0.2, 3, 0.2))


def test_a_grating_has_a_frame_bars_and_gaps() -> None:
    cover = grating().texels
    assert set(np.unique(cover)) == {0, 1}
    assert cover[5].sum() == 256 - 8
    assert 0.3 < cover[20:-20, 20:-20].mean() < 0.6
