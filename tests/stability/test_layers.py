"""Fragment lists for experiments."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.stability.layers import BLUE, RED, SIDE, Layer, columns, random_lists, scene_of, stack


def test_a_stack_is_the_same_in_every_pixel() -> None:
    lists = stack([Layer(2.0, 0.5, RED), Layer(1.0, 0.25, BLUE, (0.1, 0.2, 0.3))], 3)
    assert lists.z.shape == (2, 3, 3)
    assert (lists.z == np.array([2, 1])[:, None, None]).all()
    assert (lists.radiance[1] == BLUE).all()
    assert lists.transmission[1, 2, 2] == pytest.approx((0.1, 0.2, 0.3))
    assert stack([Layer(1.0, 1.0)]).z.shape == (1, SIDE, SIDE)


def test_columns_hold_one_list_each() -> None:
    lists = columns([[Layer(2.0, 0.5, RED)], [Layer(3.0, 1.0, BLUE)]])
    assert lists.z.tolist() == [[[2.0, 3.0]]]
    assert lists.coverage.tolist() == [[[0.5, 1.0]]]
    assert lists.radiance.tolist() == [[[list(RED), list(BLUE)]]]


@pytest.mark.parametrize("tinted", [False, True])
def test_random_planes_are_repeatable(tinted: bool) -> None:
    lists, again = (random_lists(5, tinted=tinted, side=4) for _ in range(2))
    other = random_lists(5, tinted=tinted, seed=2, side=4)
    np.testing.assert_array_equal(lists.radiance, again.radiance)
    assert (lists.radiance != other.radiance).any()
    assert sorted(lists.z[:, 0, 0]) == pytest.approx([2, 3, 4, 5, 6])
    assert (lists.z == lists.z[:, :1, :1]).all()
    assert ((lists.coverage >= 0.2) & (lists.coverage < 0.8)).all()
    assert lists.transmission.any() == tinted


def test_a_scene_consists_of_its_lists() -> None:
    lists = random_lists(2)
    scene = scene_of(lists, RED, near=0.5)
    assert scene.lists is lists
    assert (scene.background, scene.camera.near, scene.objects) == (RED, 0.5, ())
