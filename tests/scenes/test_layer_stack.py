"""Layer stack: planes at given distances that fill the view."""

from __future__ import annotations

import math

import numpy as np
import pytest

from oitbench.errors import UsageError
from tests.scenes.helpers import build, view_distances


@pytest.mark.parametrize("order", ["shuffled", "near_first", "far_first"])
def test_planes_are_at_their_distances_in_any_order(order: str) -> None:
    scene = build(f"layer_stack[count=5,first=3,spacing=0.25,order={order}]")
    for item in scene.objects:
        index = int(item.name.removeprefix("plane "))
        np.testing.assert_allclose(view_distances(scene, item.mesh), 3 + 0.25 * index, rtol=1e-6)
    sequence = [item.name for item in scene.objects]
    assert sorted(sequence) == [f"plane {index}" for index in range(5)]
    assert (sequence == sorted(sequence)) == (order == "near_first")
    assert (sequence == sorted(sequence, reverse=True)) == (order == "far_first")


def test_planes_fill_a_view_of_aspect_four_to_one() -> None:
    scene = build("layer_stack[count=4,first=0.2,spacing=3]")
    for item in scene.objects:
        distance = float(view_distances(scene, item.mesh)[0])
        half = distance * math.tan(scene.camera.fov_y / 2)
        reach = np.abs(item.mesh.positions).max(axis=0)[:2]
        assert reach[1] > half
        assert reach[0] > 4 * half


def test_materials_follow_the_parameters() -> None:
    scene = build("layer_stack[alpha=0.3,radiance=20,transmission=gray,clarity=0.5,palette=white]")
    for item in scene.objects:
        assert item.material.coverage == 0.3
        assert item.material.emission == (20, 20, 20)
        assert item.material.transmission == (0.5, 0.5, 0.5)
    assert scene.background == (0.25, 0.25, 0.25)


def test_spacing_zero_makes_exact_ties() -> None:
    scene = build("layer_stack[count=3,spacing=0]")
    first, *rest = (item.mesh.positions for item in scene.objects)
    assert all(np.array_equal(first, other) for other in rest)


def test_planes_in_front_of_the_near_plane_are_refused() -> None:
    with pytest.raises(UsageError, match=r"first is 0\.1 m; it must lie beyond near = 0\.2 m"):
        build("layer_stack[first=0.1,near=0.2]")
