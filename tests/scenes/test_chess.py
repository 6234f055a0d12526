"""Chess: one object for each color, and men in the centers of different squares."""

from __future__ import annotations

import numpy as np

from oitbench.scene import DirectionalLight
from tests.scenes.helpers import build, named, view_distances


def test_all_men_of_a_color_are_one_object() -> None:
    scene = build("chess[detail=0.1]")
    assert [item.name for item in scene.transparent] == ["clear men", "red men"]
    assert all(item.material.refracts for item in scene.transparent)
    red, clear = (named(scene, f"{color} men") for color in ("red", "clear"))
    assert red.material.transmission[0] > 2 * red.material.transmission[1]
    assert min(clear.material.transmission) > 0.85
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
