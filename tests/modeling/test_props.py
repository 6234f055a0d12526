"""Shared models: solids are closed and turned outwards, and the teapot is the one in Utah."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable

import numpy as np
import pytest

from oitbench.modeling.patterns import checkered_box, checkers
from oitbench.modeling.profiles import outline
from oitbench.modeling.props import chessmen, teapot
from oitbench.modeling.props.glassware import Vessel, ice_cube, tumbler, wine_glass
from oitbench.modeling.solids import closed, loft, turned
from oitbench.modeling.surroundings import Window, room
from oitbench.scene import Mesh, Texture

DETAILS = (0.05, 0.3, 1.0)
GLASSES: dict[str, tuple[Vessel, float]] = {
    "tumbler": (tumbler(0.03, 0.037, 0.095, 0.003, 0.009), 0.06),
    "wine glass": (wine_glass(0.043, 0.175, 0.0022), 0.113),
}
GAP = 0.0004
Build = Callable[[float], Mesh]
SOLIDS: list[tuple[str, Build]] = [
    *((name, lambda detail, name=name: GLASSES[name][0].glass(detail)) for name in GLASSES),
    *((f"drink in {name}", lambda detail, name=name: filling(name, detail)) for name in GLASSES),
    ("ice", lambda detail: ice_cube((0.03, 0.02, 0.025), 0.004, detail)),
    *chessmen.PIECES.items(),
]


def filling(name: str, detail: float) -> Mesh:
    vessel, level = GLASSES[name]
    return vessel.filling(level, GAP, detail)


def corners(mesh: Mesh) -> np.ndarray:
    return mesh.positions.astype(np.float64)[mesh.triangles]


def signed_volume(mesh: Mesh) -> float:
    a, b, c = corners(mesh).swapaxes(0, 1)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def edges(mesh: Mesh) -> Counter[tuple[int, int]]:
    """Count the directed edges of the mesh, with vertices at one place made one."""
    _, welded = np.unique(mesh.positions, axis=0, return_inverse=True)
    loops = welded.reshape(-1)[mesh.triangles]
    pairs = np.stack([loops, np.roll(loops, -1, axis=1)], axis=-1).reshape(-1, 2)
    return Counter((int(start), int(end)) for start, end in pairs)


def agreement(mesh: Mesh) -> np.ndarray:
    """Return face normal · vertex normal at each corner of each triangle, up to scale."""
    a, b, c = corners(mesh).swapaxes(0, 1)
    assert mesh.normals is not None
    return np.asarray(np.einsum("ij,ikj->ik", np.cross(b - a, c - a), mesh.normals[mesh.triangles]))


# Solids


@pytest.mark.parametrize("detail", DETAILS)
@pytest.mark.parametrize(("name", "build"), SOLIDS, ids=[name for name, _ in SOLIDS])
def test_solids_are_watertight_and_turned_outwards(name: str, build: Build, detail: float) -> None:
    mesh = build(detail)
    counts = edges(mesh)
    assert all(count == 1 and counts[edge[::-1]] == 1 for edge, count in counts.items()), name
    assert signed_volume(mesh) > 0
    assert mesh.normals is not None
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1, atol=1e-5)


@pytest.mark.parametrize(("name", "build"), SOLIDS, ids=[name for name, _ in SOLIDS])
def test_normals_of_solids_are_on_the_side_of_the_winding(name: str, build: Build) -> None:
    assert (agreement(build(1.0)) > 0).all(), name


@pytest.mark.parametrize(("name", "build"), SOLIDS, ids=[name for name, _ in SOLIDS])
def test_detail_adds_triangles_to_solids(name: str, build: Build) -> None:
    small, large = (len(build(detail).triangles) for detail in (0.1, 1.0))
    assert large > 3 * small, name


@pytest.mark.parametrize("name", GLASSES)
def test_a_glass_holds_its_drink_without_touching_it(name: str) -> None:
    vessel, level = GLASSES[name]
    wall = outline(vessel.inside, 1.0)
    drink = filling(name, 1.0).positions.astype(np.float64)
    radii = np.hypot(drink[:, 0], drink[:, 2])
    assert drink[:, 1].max() == pytest.approx(level)
    start, end = wall[:-1, None], wall[1:, None]
    points = np.stack([radii, drink[:, 1]], axis=1)[None]
    along = ((points - start) * (end - start)).sum(-1) / ((end - start) ** 2).sum(-1)
    nearest = start + np.clip(along, 0, 1)[..., None] * (end - start)
    distance = np.linalg.norm(points - nearest, axis=-1).min(axis=0)
    # The bottom's middle is a corner of the profile, and on its slope the gap is a little smaller.
    assert distance.min() > 0.75 * GAP
    assert (radii < np.interp(drink[:, 1], wall[::-1, 1], wall[::-1, 0]) + 1e-9).all()


def test_a_tumbler_has_the_volume_of_its_wall() -> None:
    mesh = tumbler(0.03, 0.03, 0.1, 0.003, 0.01).glass(16.0)
    cylinders = math.pi * (0.03**2 * 0.1 - 0.027**2 * 0.09)
    # Rounded edges take a little away at the foot and the rim, and add a little within.
    assert signed_volume(mesh) == pytest.approx(cylinders, rel=0.02)


def test_ice_keeps_its_size_and_its_rounding() -> None:
    mesh = ice_cube((0.03, 0.02, 0.025), 0.004, 1.0)
    np.testing.assert_allclose(np.ptp(mesh.positions, axis=0), (0.03, 0.02, 0.025), rtol=1e-5)
    core = np.clip(mesh.positions, *(np.outer((-1, 1), (0.011, 0.006, 0.0085))))
    np.testing.assert_allclose(np.linalg.norm(mesh.positions - core, axis=1), 0.004, rtol=1e-3)


def test_fillets_are_arcs_that_meet_the_edges_smoothly() -> None:
    curve = outline([(0.0, 0.0, 0.0), (2.0, 0.0, 0.5), (2.0, 3.0, 0.0)], 1.0)
    arc = curve[1:-1]
    np.testing.assert_allclose(np.linalg.norm(arc - (1.5, 0.5), axis=1), 0.5, rtol=1e-12)
    np.testing.assert_allclose(arc[[0, -1]], [(1.5, 0), (2, 0.5)], atol=1e-12)


def test_fillets_that_overlap_are_refused() -> None:
    with pytest.raises(ValueError, match="edge 1 of an outline overlap"):
        outline([(0, 0, 0), (1, 0, 0.6), (1, 1, 0.6), (0, 1, 0)], 1.0)


def test_open_solids_are_refused() -> None:
    with pytest.raises(ValueError, match="must be points"):
        turned(np.array([(0.5, 0.0), (0.5, 1.0), (0.0, 1.0)]), 8)


def test_a_loft_turns_elliptic_rings() -> None:
    rings = np.array([(0, 0, 0, 0, 0), (-1, 0, 3, 0, 0.5), (-1, 2, 3, 2, 0.5), (1, 2, 1, 2, 0)])
    mesh = loft(rings.astype(np.float64), 256)
    assert signed_volume(mesh) == pytest.approx(math.pi * 2 * 0.5 * 2, rel=1e-3)


def test_the_least_closed_grid_is_two_cones() -> None:
    angle = np.arange(4) * math.pi / 2
    waist = np.stack([np.cos(angle), np.ones(4), -np.sin(angle)], axis=1)
    mesh = closed(np.stack([np.zeros((4, 3)), waist, np.tile([0.0, 2, 0], (4, 1))]))
    assert len(mesh.triangles) == 8
    assert signed_volume(mesh) == pytest.approx(4 / 3)


# Chess men


def test_men_stand_on_the_board_in_order_of_rank() -> None:
    heights = {}
    for name in chessmen.PIECES:
        mesh = chessmen.piece(name, 0.09, 0.3)
        assert mesh.positions[:, 1].min() == 0
        heights[name] = float(mesh.positions[:, 1].max())
    assert heights["king"] == pytest.approx(0.09)
    assert sorted(heights, key=heights.__getitem__) == [
        "pawn",
        "rook",
        "knight",
        "bishop",
        "queen",
        "king",
    ]


def test_the_knight_looks_ahead_and_the_others_look_round() -> None:
    for name in ("pawn", "bishop", "queen"):
        radii = np.hypot(*chessmen.piece(name, 1.0, 0.3).positions[:, [0, 2]].T)
        assert len(np.unique(radii.round(5))) < len(radii) / 4
    head = chessmen.piece("knight", 1.0, 1.0).positions
    high = head[head[:, 1] > 0.38]
    assert high[:, 0].max() > 0.2
    assert high[:, 0].min() > -0.15
    assert np.abs(high[:, 2]).max() < 0.08


def test_a_rook_has_its_notches() -> None:
    mesh = chessmen.piece("rook", 1.0, 1.0)
    rim = mesh.positions[np.hypot(mesh.positions[:, 0], mesh.positions[:, 2]) > 0.11]
    angle = np.arctan2(rim[:, 2], rim[:, 0]).round(4)
    tops = np.array([rim[angle == a, 1].max() for a in np.unique(angle)]) > 0.56
    assert (tops != np.roll(tops, 1)).sum() == 2 * chessmen.NOTCHES


# Teapot


def test_the_teapot_has_32_patches_that_share_control_points() -> None:
    control = teapot.patches()
    assert control.shape == (32, 4, 4, 3)
    # 17 rings of 12 and 3 points on the axis; 7 rings of 6 for either tube, of which one point, the
    # foot of the handle, is on the body too.
    distinct = np.unique(control.reshape(-1, 3).round(6), axis=0)
    assert len(distinct) == 17 * 12 + 3 + 2 * 7 * 6 - 1


def test_the_teapot_has_its_size_and_faces_its_spout() -> None:
    mesh = teapot.teapot(3.15, 1.0)
    low, high = mesh.positions.min(axis=0), mesh.positions.max(axis=0)
    np.testing.assert_allclose([low[1], high[1]], [0, 3.15], atol=1e-6)
    np.testing.assert_allclose([low[0], low[2], high[2]], [-3, -2, 2], atol=1e-6)
    assert high[0] == pytest.approx(3.434, abs=0.002)
    half = teapot.teapot(0.315, 1.0)
    np.testing.assert_allclose(half.positions * 10, mesh.positions, atol=1e-5)


def test_the_teapot_keeps_its_volume() -> None:
    # Of body, lid, handle and spout together, in cubic units: no control point moves unseen.
    assert signed_volume(teapot.teapot(3.15, 1.0)) == pytest.approx(25.6806, rel=1e-4)


@pytest.mark.parametrize("detail", [1.0, 4.0])
def test_the_teapot_is_turned_outwards(detail: float) -> None:
    mesh = teapot.teapot(1.0, detail)
    assert (agreement(mesh) > 0).all()
    assert signed_volume(mesh) > 0


def test_the_teapot_is_closed_but_for_its_rim_lid_and_tubes() -> None:
    mesh = teapot.teapot(3.15, 1.0)
    counts = edges(mesh)
    boundary = {start for (start, end) in counts if counts[end, start] == 0}
    places = np.unique(mesh.positions, axis=0)[sorted(boundary)]
    radii = np.hypot(places[:, 0], places[:, 2])
    rings = (np.abs(radii - 1.3) < 0.01) | (np.abs(radii - 1.4) < 0.01)
    assert np.abs(places[rings, 1] - 2.4).max() < 1e-5
    # What is left are the ends of the handle, the mouth of the spout and where it starts.
    assert set(np.sign(places[~rings, 0])) == {-1.0, 1.0}
    assert (radii[~rings] > 1.45).all()


def test_detail_adds_triangles_to_the_teapot() -> None:
    assert len(teapot.teapot(1.0, 1.0).triangles) == 4032
    assert len(teapot.teapot(1.0, 0.25).triangles) < 4032 / 3


# Patterns


def test_checkers_alternate_and_share_their_vertices() -> None:
    even, odd = checkers((0, 0, 0), (1.5, 0, 0), (0, 1, 0), 3, 2)
    assert len(even.triangles) == len(odd.triangles) == 6
    assert {tuple(p) for p in odd.positions} < {
        (x, y, 0.0) for x in (-1.5, -0.5, 0.5, 1.5) for y in (-1.0, 0.0, 1.0)
    }
    np.testing.assert_allclose(corners(even)[:2].mean(axis=(0, 1)), (-1, -0.5, 0), atol=1e-6)
    assert (agreement(even) > 0).all()


def test_a_checkered_box_is_a_closed_box_of_two_colors() -> None:
    even, odd = checkered_box((1, 2, 3), (0.5, 1.0, 2.0), 4)
    assert len(even.triangles) == len(odd.triangles) == 6 * 16
    assert signed_volume(even) + signed_volume(odd) == pytest.approx(1.0, rel=1e-5)


def test_a_room_has_its_colors_and_its_window_where_they_are_asked_for() -> None:
    window = Window(math.radians(90), math.radians(30), 0.4, 0.4, (9.0, 8.0, 7.0))
    light = room((1, 2, 3), (4, 5, 6), (7, 8, 9), [window])
    assert isinstance(light.radiance, Texture)
    texels = light.radiance.texels
    assert texels.shape == (64, 128, 3)
    np.testing.assert_allclose(texels[0, 0], (1, 2, 3), atol=0.01)
    np.testing.assert_allclose(texels[-1, 0], (7, 8, 9), atol=0.01)
    np.testing.assert_allclose(texels[32, 0], (4, 5, 6), atol=0.01)
    # To the right of straight ahead (column 64) by a quarter of the turn, 30° above level.
    np.testing.assert_allclose(texels[21, 96], (9, 8, 7), atol=1e-5)


def test_a_window_behind_is_whole() -> None:
    window = Window(math.radians(175), 0.0, 0.5, 0.5, (2, 2, 2))
    light = room((1, 1, 1), (1, 1, 1), (1, 1, 1), [window])
    assert isinstance(light.radiance, Texture)
    texels = light.radiance.texels
    bright = texels[32, :, 0] > 1.5
    assert bright[0]
    assert bright[-1]
    assert bright.sum() == pytest.approx(0.5 / (2 * math.pi) * 128, abs=2)
