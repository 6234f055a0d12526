"""Glassware: volumes, and drinks that do not touch their glasses."""

from __future__ import annotations

import math

import numpy as np
import pytest

from oitbench.modeling.profiles import outline
from oitbench.modeling.props.glassware import Vessel, ice_cube, tank, tumbler, wine_glass
from tests.meshes import hits, signed_volume

GAP = 0.0004


@pytest.mark.parametrize(
    ("vessel", "level"),
    [
        (tumbler(0.03, 0.037, 0.095, 0.003, 0.009), 0.06),
        (wine_glass(0.043, 0.175, 0.0022), 0.113),
    ],
    ids=["tumbler", "wine glass"],
)
def test_a_glass_holds_its_drink_without_touching_it(vessel: Vessel, level: float) -> None:
    wall = outline(vessel.inside, 1.0)
    drink = vessel.filling(level, GAP, 1.0).positions.astype(np.float64)
    radii = np.hypot(drink[:, 0], drink[:, 2])
    assert drink[:, 1].max() == pytest.approx(level)
    start, end = wall[:-1, None], wall[1:, None]
    points = np.stack([radii, drink[:, 1]], axis=1)[None]
    along = ((points - start) * (end - start)).sum(-1) / ((end - start) ** 2).sum(-1)
    nearest = start + np.clip(along, 0, 1)[..., None] * (end - start)
    distance = np.linalg.norm(points - nearest, axis=-1).min(axis=0)
    # The middle of the bottom is a corner of the profile, where the gap is a little smaller.
    assert distance.min() > 0.75 * GAP
    assert (radii < np.interp(drink[:, 1], wall[::-1, 1], wall[::-1, 0]) + 1e-9).all()


def test_a_tumbler_has_the_volume_of_its_wall() -> None:
    mesh = tumbler(0.03, 0.03, 0.1, 0.003, 0.01).glass(16.0)
    cylinders = math.pi * (0.03**2 * 0.1 - 0.027**2 * 0.09)
    # Rounded edges remove a little at the foot and the rim, and add a little inside.
    assert signed_volume(mesh) == pytest.approx(cylinders, rel=0.02)


def test_ice_keeps_its_size_and_its_rounding() -> None:
    mesh = ice_cube((0.03, 0.02, 0.025), 0.004, 1.0)
    np.testing.assert_allclose(np.ptp(mesh.positions, axis=0), (0.03, 0.02, 0.025), rtol=1e-5)
    core = np.clip(mesh.positions, *(np.outer((-1, 1), (0.011, 0.006, 0.0085))))
    np.testing.assert_allclose(np.linalg.norm(mesh.positions - core, axis=1), 0.004, rtol=1e-3)


def test_a_drink_of_negative_gap_reaches_into_the_wall_of_its_glass() -> None:
    vessel = tumbler(0.03, 0.037, 0.095, 0.003, 0.009)
    drink, glass = vessel.filling(0.06, -GAP, 1.0), vessel.glass(1.0)
    origin = (-0.1, 0.04, 1e-4)
    inner = hits(glass, origin, (1, 0, 0))[1]
    depth = inner - hits(drink, origin, (1, 0, 0))[0]
    assert depth == pytest.approx(GAP, rel=0.1)


def test_a_tank_is_open_above_and_has_the_volume_of_its_walls() -> None:
    glass = tank((0.4, 0.25, 0.2), 0.01)
    walls = 0.4 * 0.25 * 0.2 - 0.38 * 0.24 * 0.18
    assert signed_volume(glass) == pytest.approx(walls)
    down = hits(glass, (0.013, 1.0, 0.017), (0, -1, 0))
    np.testing.assert_allclose(down, [0.99, 1.0])
