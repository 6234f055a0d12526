"""The bust: its proportions, symmetry, and the hair around it."""

from __future__ import annotations

import numpy as np

from oitbench.modeling.props import bust
from oitbench.modeling.props.hairstyle import grow
from tests.meshes import agreement


def test_the_bust_has_the_proportions_of_a_woman() -> None:
    along = np.linspace(-0.3, 0.2, 400)
    middle = np.stack([0 * along, along, 0 * along], axis=1)
    inside = bust.distance(middle) < 0
    assert abs(along[inside].max() - 0.115) < 0.004
    across = np.stack([along, 0 * along + 0.01, 0 * along - 0.01], axis=1)
    width = np.ptp(along[bust.distance(across) < 0])
    assert 0.13 < width < 0.17
    neck = np.stack([along, 0 * along - 0.15, 0 * along - 0.04], axis=1)
    assert 0.07 < np.ptp(along[bust.distance(neck) < 0]) < 0.11


def test_left_and_right_are_equal() -> None:
    points = np.random.default_rng(2).uniform(-0.2, 0.2, (300, 3))
    mirrored = bust.distance(points * [-1, 1, 1])
    np.testing.assert_allclose(bust.distance(points), mirrored, atol=1e-12)


def test_its_mesh_is_open_below_only() -> None:
    mesh = bust.bust(0.012)
    assert (agreement(mesh).sum(axis=1) > 0).mean() > 0.99
    assert mesh.positions[:, 1].min() < -0.35
    assert abs(bust.distance(mesh.positions)).max() < 0.004


def test_locks_gather_strands() -> None:
    """Neighbors at the tips are closer to each other than independent places would be."""
    curves = grow(np.random.default_rng(1), 1500, 10)
    assert curves.shape == (1500, 10, 3)
    steps = np.linalg.norm(np.diff(curves, axis=1), axis=2)
    assert steps.max() < 0.12

    def gap(points: np.ndarray) -> float:
        apart = np.linalg.norm(points[:, None] - points[None], axis=2)
        return float(np.median(np.sort(apart, axis=1)[:, 4]) / points.std())

    assert gap(curves[:, -1]) < 0.8 * gap(np.random.default_rng(0).permuted(curves[:, -1], axis=0))
