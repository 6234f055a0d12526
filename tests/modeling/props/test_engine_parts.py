"""Parts of an engine: closed, of the size that they state, and made to fit each other."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from oitbench.modeling.props.engine_parts import (
    belt,
    bolt,
    camshaft,
    connecting_rod,
    crank_web,
    crankshaft,
    generator,
    liner,
    piston,
    pulley,
    shell,
    spring,
    strip,
    valve,
    wheel,
)
from oitbench.scene import Mesh
from tests.meshes import boundary, bounds, has_unit_normals, hits, signed_volume

LOOP = [(0.0, 0.0, 40.0), (100.0, 0.0, 20.0)]
PARTS: dict[str, Callable[[float], Mesh]] = {
    "piston": lambda detail: piston(40, detail),
    "liner": lambda detail: liner(40, 45, 0, 100, detail),
    "rod": lambda detail: connecting_rod(135, 24, detail),
    "web": lambda detail: crank_web(42, detail),
    "crankshaft": lambda detail: crankshaft(42, 24, 92, np.array([0.0, math.pi]), detail),
    "valve": valve,
    "spring": lambda detail: spring(0, 40, 10, 6, detail),
    "camshaft": lambda detail: camshaft(100, np.array([0.0]), np.array([0.0]), detail),
    "wheel": lambda detail: wheel(40, 64, 11, 17, detail),
    "bolt": lambda detail: bolt(30, 4, detail),
    "shell": lambda detail: shell(LOOP, 5, 50, detail),
    "pulley": lambda detail: pulley(40, 19, detail),
    "belt": lambda detail: belt(LOOP, 1, 4, 13, detail),
    "generator": generator,
    "strip": lambda detail: strip((0, 0, 0), (14, 5, 100)),
}


@pytest.mark.parametrize("detail", [0.05, 1.0])
@pytest.mark.parametrize("name", PARTS)
def test_parts_are_closed_and_can_be_merged(name: str, detail: float) -> None:
    mesh = PARTS[name](detail)
    assert not len(boundary(mesh))
    assert signed_volume(mesh) > 0
    assert has_unit_normals(mesh)
    assert mesh.uvs is None


def test_a_crankpin_is_at_its_throw_and_opposite_to_the_counterweight() -> None:
    low, high = bounds(crank_web(42, 4.0))
    assert high[1] == pytest.approx(42 + 31, abs=0.1)
    assert low[1] == pytest.approx(-81, abs=0.5)
    low, high = bounds(crankshaft(42, 24, 92, np.array([math.pi / 2]), 4.0))
    assert high[0] == pytest.approx(42 + 31, abs=0.2)  # clockwise from straight up is +x
    assert low[2] == pytest.approx(-high[2])


def test_the_bores_of_a_rod_are_open_and_apart_by_its_length() -> None:
    rod = connecting_rod(135, 24, 1.0)
    for y in (0.1, 135.1):
        assert not len(hits(rod, (0.1, y, 50), (0, 0, -1)))
    assert len(hits(rod, (0.1, 30.1, 50), (0, 0, -1))) == 2
    assert not len(hits(rod, (0.1, 80.1, 50), (0, 0, -1)))  # the slot of the shank


def test_a_spring_has_its_height_and_winds_around_a_valve() -> None:
    coil = spring(38, 80, 10.5, 6, 1.0)
    radii = np.hypot(coil.positions[:, 0], coil.positions[:, 2])
    assert radii.min() > 3.2  # the stem
    assert radii.max() == pytest.approx(12.4, abs=0.1)
    assert bounds(coil)[0][1] == pytest.approx(38, abs=2)
    assert bounds(coil)[1][1] == pytest.approx(80, abs=2)


def test_a_belt_keeps_its_distance_from_pulleys() -> None:
    ring = belt(LOOP, 1, 4, 13, 4.0).positions
    gap = np.hypot(ring[:, 0], ring[:, 1]) - 40
    assert gap.min() == pytest.approx(1, abs=0.05)
    assert bounds(belt(LOOP, 1, 4, 13, 4.0))[1][0] == pytest.approx(125)


def test_fewer_triangles_make_coarser_teeth() -> None:
    coarse, fine = (wheel(110, 134, 15, 20, detail) for detail in (0.1, 1.0))
    assert len(fine.triangles) > 2 * len(coarse.triangles)
    assert bounds(coarse)[1][0] == pytest.approx(bounds(fine)[1][0], rel=0.01)
