"""Frosted panes, tumblers, chess: each calls for its phenomena and is built so that they show."""

from __future__ import annotations

import itertools
from collections import Counter

import numpy as np
import pytest

from oitbench.effects import Effect
from oitbench.errors import UsageError
from oitbench.path_traced.export.checks import require_traceable
from oitbench.plugins import Collection
from oitbench.scene import DirectionalLight, Mesh, Object, Scene, SpotLight

COLLECTION = Collection.load()
CLEAR = Effect.COVERAGE | Effect.SHADOWS | Effect.TRANSLUCENT_SHADOWS
REFRACTING = (
    CLEAR
    | Effect.COLORED_TRANSMISSION
    | Effect.REFRACTION
    | Effect.COLORED_SHADOWS
    | Effect.CAUSTICS
)
EFFECTS = {
    "frosted_panes": CLEAR | Effect.DIFFUSION,
    "tumblers": REFRACTING,
    "chess": REFRACTING,
}
LEAST_GAP = 3e-4
"""Metres between surfaces of different solids."""


def build(text: str) -> Scene:
    return COLLECTION.build_scene(text)


def named(scene: Scene, prefix: str) -> list[Object]:
    return [item for item in scene.objects if item.name.startswith(prefix)]


def bounds(mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    return mesh.positions.min(axis=0), mesh.positions.max(axis=0)


def signed_volume(mesh: Mesh) -> float:
    a, b, c = mesh.positions.astype(np.float64)[mesh.triangles].swapaxes(0, 1)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def in_view(scene: Scene, points: np.ndarray, aspect: float = 4 / 3) -> np.ndarray:
    """Tell which points, shape (n, 3), lie within a picture of this aspect."""
    camera = scene.camera
    x, y, back = camera.axes @ (points - np.asarray(camera.position)).T
    reach = -back * np.tan(camera.fov_y / 2)
    return np.asarray((back < 0) & (np.abs(y) < reach) & (np.abs(x) < aspect * reach))


@pytest.mark.parametrize(("name", "effects"), EFFECTS.items())
def test_scenes_call_for_their_phenomena(name: str, effects: Effect) -> None:
    assert build(f"{name}[detail=0.1]").effects == effects


@pytest.mark.parametrize("name", EFFECTS)
def test_no_two_triangles_coincide(name: str) -> None:
    for detail in ("0.1", "1"):
        require_traceable(build(f"{name}[detail={detail}]"))


@pytest.mark.parametrize("name", EFFECTS)
def test_detail_adds_triangles_within_reason(name: str) -> None:
    small, large = (
        sum(len(item.mesh.triangles) for item in build(f"{name}[detail={detail}]").transparent)
        for detail in (0.1, 1)
    )
    assert large > 3 * small
    assert sum(len(item.mesh.triangles) for item in build(name).objects) < 60_000


@pytest.mark.parametrize("name", EFFECTS)
def test_floors_throw_no_shadow_and_glass_does(name: str) -> None:
    scene = build(f"{name}[detail=0.1]")
    assert all(item.casts for item in scene.transparent)
    floors = [item for item in scene.opaque if np.ptp(item.mesh.positions[:, 1]) == 0]
    assert floors
    assert not any(item.casts for item in floors)


@pytest.mark.parametrize("name", EFFECTS)
def test_all_that_is_transparent_is_in_the_picture(name: str) -> None:
    scene = build(f"{name}[detail=0.1]")
    for item in scene.transparent:
        assert in_view(scene, item.mesh.positions.astype(np.float64)).all(), item.name


@pytest.mark.parametrize("name", ["tumblers", "chess"])
@pytest.mark.parametrize("detail", ["0.1", "1"])
def test_solids_are_watertight_and_stand_clear_of_the_ground(name: str, detail: str) -> None:
    for item in build(f"{name}[detail={detail}]").transparent:
        assert item.material.refracts
        _, welded = np.unique(item.mesh.positions, axis=0, return_inverse=True)
        loops = welded.reshape(-1)[item.mesh.triangles]
        pairs = np.stack([loops, np.roll(loops, -1, axis=1)], axis=-1).reshape(-1, 2)
        counts = Counter((int(start), int(end)) for start, end in pairs)
        assert all(count == 1 and counts[edge[::-1]] == 1 for edge, count in counts.items())
        assert signed_volume(item.mesh) > 0
        assert item.mesh.positions[:, 1].min() >= LEAST_GAP


# frosted_panes


def test_collimation_falls_from_left_to_right() -> None:
    scene = build("frosted_panes[detail=0.1]")
    panes = sorted(named(scene, "pane "), key=lambda item: float(item.mesh.positions[:, 0].mean()))
    collimations = [item.material.collimation for item in panes]
    assert collimations == [1.0, 0.9, 0.75, 0.5, 0.25]
    assert all(not item.material.solid for item in panes)
    spans = [bounds(item.mesh) for item in panes]
    assert all(one[1][0] < other[0][0] for one, other in itertools.pairwise(spans))


@pytest.mark.parametrize("distance", ["0.4", "1"])
def test_each_box_touches_its_pane_and_each_teapot_stands_behind_it(distance: str) -> None:
    scene = build(f"frosted_panes[detail=0.1,distance={distance}]")
    for number, pane in enumerate(named(scene, "pane ")):
        low, high = bounds(pane.mesh)
        boxes = named(scene, f"light squares of box {number}")
        boxes += named(scene, f"dark squares of box {number}")
        front = max(float(bounds(item.mesh)[1][2]) for item in boxes)
        assert 0 < low[2] - front <= 0.0015
        assert all((bounds(item.mesh)[0][:2] >= low[:2] - 1e-6).all() for item in boxes)
        assert all((bounds(item.mesh)[1][:2] < high[:2]).all() for item in boxes)
        (pot,) = named(scene, f"teapot {number}")
        assert bounds(pot.mesh)[1][2] < low[2]
        middle = (bounds(pot.mesh)[0] + bounds(pot.mesh)[1]) / 2
        assert low[0] < middle[0] < high[0]


def test_teapots_are_alike_and_the_distance_moves_them() -> None:
    near, far = (
        named(build(f"frosted_panes[detail=0.1,distance={distance}]"), "teapot")
        for distance in ("0.5", "1")
    )
    first = near[0].mesh
    for item in near[1:]:
        offset = item.mesh.positions - first.positions
        np.testing.assert_allclose(offset, np.broadcast_to(offset[0], offset.shape), atol=1e-5)
    np.testing.assert_allclose(
        far[0].mesh.positions - first.positions, [(0, 0, -0.5)] * len(first.positions), atol=1e-5
    )


def test_panes_are_grey() -> None:
    for item in build("frosted_panes[detail=0.1]").transparent:
        assert not item.material.tints


# tumblers


def test_tumblers_are_of_glass_ice_and_colored_drinks() -> None:
    scene = build("tumblers[detail=0.1]")
    indices = Counter(item.material.index for item in scene.transparent)
    assert set(indices) == {1.31, 1.33, 1.5}
    drinks = [item for item in scene.transparent if item.material.index == 1.33]
    assert len(drinks) == 3
    for item in drinks:
        assert max(item.material.transmission) > 3 * min(item.material.transmission)


def test_each_drink_is_within_its_glass_and_apart_from_it() -> None:
    scene = build("tumblers")
    glasses = [item for item in scene.transparent if item.material.index == 1.5]
    for drink in (item for item in scene.transparent if item.material.index == 1.33):
        low, high = bounds(drink.mesh)
        around = [
            item
            for item in glasses
            if (bounds(item.mesh)[0] < low).all() and (bounds(item.mesh)[1] > high).all()
        ]
        (glass,) = around
        offset = drink.mesh.positions[:, None, :] - glass.mesh.positions[None]
        assert np.linalg.norm(offset, axis=-1).min() > LEAST_GAP


def test_ice_stays_within_its_glass() -> None:
    scene = build("tumblers")
    (ice,) = named(scene, "ice")
    (glass,) = named(scene, "rocks glass")
    low, high = bounds(glass.mesh)
    middle = (low + high) / 2
    inside = ((ice.mesh.positions > low) & (ice.mesh.positions < high)).all(axis=1)
    assert 0.7 < inside.mean() < 0.8
    wall = glass.mesh.positions
    inner = np.hypot(wall[:, 0] - middle[0], wall[:, 2] - middle[2])
    at_floor = inner[(wall[:, 1] > low[1] + 0.1)].min()
    reach = np.hypot(*(ice.mesh.positions[inside][:, [0, 2]] - middle[[0, 2]]).T)
    assert reach.max() < at_floor


def test_the_spot_throws_shadows_towards_the_viewer() -> None:
    scene = build("tumblers[detail=0.1]")
    (spot,) = scene.beams
    assert isinstance(spot, SpotLight)
    assert spot.position[2] < min(
        float(item.mesh.positions[:, 2].min()) for item in scene.transparent
    )
    axis = np.subtract(spot.target, spot.position)
    for item in scene.transparent:
        ray = item.mesh.positions - np.asarray(spot.position)
        cosine = ray @ axis / np.linalg.norm(ray, axis=1) / np.linalg.norm(axis)
        assert (np.arccos(cosine) < 0.9 * spot.angle / 2).all()


# chess


def test_all_men_of_a_color_are_one_object() -> None:
    scene = build("chess[detail=0.1]")
    assert [item.name for item in scene.transparent] == ["clear men", "red men"]
    red, clear = (named(scene, f"{color} men")[0] for color in ("red", "clear"))
    assert red.material.transmission[0] > 2 * red.material.transmission[1]
    assert min(clear.material.transmission) > 0.85
    # Neither color lies before the other one.
    spans = [scene.camera.view_distance(item.mesh.positions) for item in (red, clear)]
    assert spans[0].min() < spans[1].max()
    assert spans[1].min() < spans[0].max()


def test_men_stand_apart_in_the_middles_of_squares() -> None:
    scene = build("chess[detail=0.1]")
    feet = []
    for item in scene.transparent:
        positions = item.mesh.positions
        low = positions[:, 1] == positions[:, 1].min()
        parts = np.unique((positions[low][:, [0, 2]] / 0.48 + 4) // 1, axis=0)
        feet.append(parts)
        offset = (positions[low][:, [0, 2]] / 0.48 + 4) % 1
        assert (np.abs(offset - 0.5) < 0.45).all()
    assert [len(part) for part in feet] == [8, 8]
    squares = np.concatenate(feet)
    assert len(np.unique(squares, axis=0)) == 16
    assert squares.min() >= 0
    assert squares.max() <= 7


def test_the_light_comes_from_behind_the_board() -> None:
    (sun,) = build("chess[detail=0.1]").beams
    assert isinstance(sun, DirectionalLight)
    assert sun.direction[1] < 0 < sun.direction[2]


@pytest.mark.parametrize(
    ("text", "culprit"),
    [
        ("frosted_panes[distance=0.1]", "distance"),
        ("tumblers[detail=-1]", "detail"),
        ("chess[detail=nan]", "detail"),
    ],
)
def test_wrong_parameters_are_refused_by_name(text: str, culprit: str) -> None:
    with pytest.raises(UsageError, match=culprit):
        build(text)
