"""Solid props are closed, have outward normals, and become finer with detail."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from oitbench.modeling.props import chessmen
from oitbench.modeling.props.glassware import ice_cube, tank, tumbler, wine_glass
from oitbench.scene import Mesh
from tests.meshes import agreement, boundary, has_unit_normals, signed_volume

TUMBLER = tumbler(0.03, 0.037, 0.095, 0.003, 0.009)
WINE_GLASS = wine_glass(0.043, 0.175, 0.0022)
SOLIDS: dict[str, Callable[[float], Mesh]] = {
    "tumbler": TUMBLER.glass,
    "drink in tumbler": lambda detail: TUMBLER.filling(0.06, 0.0004, detail),
    "wine glass": WINE_GLASS.glass,
    "drink in wine glass": lambda detail: WINE_GLASS.filling(0.113, 0.0004, detail),
    "ice": lambda detail: ice_cube((0.03, 0.02, 0.025), 0.004, detail),
    **chessmen.PIECES,
}


def test_a_tank_is_watertight_with_outward_normals() -> None:
    mesh = tank((0.4, 0.25, 0.2), 0.01)
    assert not len(boundary(mesh))
    assert (agreement(mesh) > 0).all()


@pytest.mark.parametrize("detail", [0.05, 0.3, 1.0])
@pytest.mark.parametrize("name", SOLIDS)
def test_solids_are_watertight_with_outward_normals(name: str, detail: float) -> None:
    mesh = SOLIDS[name](detail)
    assert not len(boundary(mesh))
    assert signed_volume(mesh) > 0
    assert has_unit_normals(mesh)


@pytest.mark.parametrize("name", SOLIDS)
def test_normals_agree_with_the_winding(name: str) -> None:
    assert (agreement(SOLIDS[name](1.0)) > 0).all()


@pytest.mark.parametrize("name", SOLIDS)
def test_detail_adds_triangles(name: str) -> None:
    coarse, fine = (len(SOLIDS[name](detail).triangles) for detail in (0.1, 1.0))
    assert fine > 3 * coarse
