"""Chess: one object for each color, men in the centers of squares, and a room around them."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.scene import SpotLight
from oitbench.scene.texturing import constant
from tests.scenes.helpers import build, named, seen, view_distances


def test_all_men_of_a_color_are_one_object() -> None:
    scene = build("chess[detail=0.1]")
    assert [item.name for item in scene.transparent] == ["clear men", "red men"]
    assert all(item.material.refracts for item in scene.transparent)
    red, clear = (named(scene, f"{color} men") for color in ("red", "clear"))
    assert constant(red.material.transmission)[0] > 2 * constant(red.material.transmission)[1]
    assert min(constant(clear.material.transmission)) > 0.85
    # Neither color is in front of the other.
    spans = [view_distances(scene, item.mesh) for item in (red, clear)]
    assert spans[0].min() < spans[1].max()
    assert spans[1].min() < spans[0].max()


def test_men_stand_in_the_centers_of_different_squares() -> None:
    scene = build("chess[detail=0.1]")
    feet = []
    for item in scene.transparent:
        positions = item.mesh.positions
        low = positions[:, 1] == positions[:, 1].min()
        parts = np.unique((positions[low][:, [0, 2]] / 0.048 + 4) // 1, axis=0)
        feet.append(parts)
        offset = (positions[low][:, [0, 2]] / 0.048 + 4) % 1
        assert (np.abs(offset - 0.5) < 0.45).all()
    assert [len(part) for part in feet] == [8, 8]
    squares = np.concatenate(feet)
    assert len(np.unique(squares, axis=0)) == 16
    assert squares.min() >= 0
    assert squares.max() <= 7


def test_the_lamp_is_behind_the_board_and_reaches_every_man() -> None:
    scene = build("chess[detail=0.1]")
    (lamp,) = scene.beams
    assert isinstance(lamp, SpotLight)
    axis = np.subtract(lamp.target, lamp.position)
    assert axis[1] < 0 < axis[2]
    for item in scene.transparent:
        rays = item.mesh.positions - np.asarray(lamp.position)
        cosine = rays @ axis / np.linalg.norm(rays, axis=1) / np.linalg.norm(axis)
        assert (np.arccos(cosine) < 0.9 * lamp.angle / 2).all()


def test_men_are_as_large_as_in_life_and_the_room_is_behind_them() -> None:
    scene = build("chess[detail=0.1]")
    tops = [item.mesh.positions[:, 1].max() for item in scene.transparent]
    assert tops == pytest.approx([0.09, 0.09], abs=0.005)
    men = max(view_distances(scene, item.mesh).max() for item in scene.transparent)
    for name in ("windows", "furniture", "walls"):
        mesh = named(scene, name).mesh
        visible = (np.abs(seen(scene.camera, mesh.positions)) < 1).all(axis=1)
        distances = view_distances(scene, mesh)
        assert name == "walls" or visible.any()
        assert (distances[visible] > men).all()
