"""Frosted panes: the panes differ only in collimation, which falls from left to right."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from tests.meshes import bounds
from tests.scenes.helpers import build, named, seen, starting


def test_collimation_falls_from_left_to_right() -> None:
    panes = starting(build("frosted_panes[detail=0.1]"), "pane ")
    panes.sort(key=lambda item: float(item.mesh.positions[:, 0].mean()))
    collimations = [item.material.collimation for item in panes]
    assert collimations[0] == 1.0
    assert collimations == sorted(set(collimations), reverse=True)
    assert len(panes) == 5
    assert all(not item.material.solid for item in panes)
    assert not any(item.material.tints for item in panes)
    spans = [bounds(item.mesh) for item in panes]
    assert all(one[1][0] < other[0][0] for one, other in itertools.pairwise(spans))


def test_each_teapot_is_seen_through_its_own_pane_and_fills_most_of_it() -> None:
    scene = build("frosted_panes[detail=0.1]")
    for number in range(5):
        pane, pot = (
            seen(scene.camera, named(scene, f"{kind} {number}").mesh.positions)
            for kind in ("pane", "teapot")
        )
        left, right = pane[:, 0].min(), pane[:, 0].max()
        assert ((pot[:, 0] > left) & (pot[:, 0] < right)).mean() > 0.95
        assert np.ptp(pot[:, 0]) > 0.7 * (right - left)
        assert np.ptp(pot[:, 1]) > 0.12 * 2


@pytest.mark.parametrize("distance", ["0.4", "1"])
def test_each_box_touches_its_pane_and_each_teapot_is_behind_it(distance: str) -> None:
    scene = build(f"frosted_panes[detail=0.1,distance={distance}]")
    for number in range(5):
        low, high = bounds(named(scene, f"pane {number}").mesh)
        boxes = [named(scene, f"{shade} squares of box {number}") for shade in ("light", "dark")]
        front = max(float(bounds(item.mesh)[1][2]) for item in boxes)
        assert 0 < low[2] - front <= 0.0015
        assert all((bounds(item.mesh)[0][:2] >= low[:2] - 1e-6).all() for item in boxes)
        assert all((bounds(item.mesh)[1][:2] < high[:2]).all() for item in boxes)
        pot_low, pot_high = bounds(named(scene, f"teapot {number}").mesh)
        assert pot_high[2] < low[2]
        assert low[0] < (pot_low[0] + pot_high[0]) / 2 < high[0]


def test_teapots_are_equal_and_the_distance_moves_them() -> None:
    near, far = (
        starting(build(f"frosted_panes[detail=0.1,distance={distance}]"), "teapot")
        for distance in ("0.5", "1")
    )
    first = near[0].mesh
    for item in near[1:]:
        offset = item.mesh.positions - first.positions
        np.testing.assert_allclose(offset, np.broadcast_to(offset[0], offset.shape), atol=1e-5)
    np.testing.assert_allclose(
        far[0].mesh.positions - first.positions, [(0, 0, -0.5)] * len(first.positions), atol=1e-5
    )
