"""Glass bars: two grids of saturated colors that can be sorted by object."""

from __future__ import annotations

import itertools

from oitbench.scene.texturing import constant
from tests.scenes.helpers import build, starting, view_distances


def test_all_bars_of_the_front_grid_are_nearer_than_those_of_the_other() -> None:
    scene = build("glass_bars")
    far, near = (
        [float(view_distances(scene, item.mesh).mean()) for item in starting(scene, grid)]
        for grid in ("level", "upright")
    )
    assert len(near) == len(far) == 7
    assert max(near) < min(far)


def test_bars_of_one_grid_are_coplanar_and_do_not_overlap() -> None:
    scene = build("glass_bars")
    for grid, axis in (("upright", 0), ("level", 1)):
        bars = [item.mesh.positions for item in starting(scene, grid)]
        assert len({float(z) for bar in bars for z in bar[:, 2]}) == 1
        spans = sorted((float(bar[:, axis].min()), float(bar[:, axis].max())) for bar in bars)
        assert all(one[1] < other[0] for one, other in itertools.pairwise(spans))


def test_bars_without_reflection_emit_nothing_and_have_saturated_colors() -> None:
    for item in build("glass_bars[reflection=0]").transparent:
        assert item.material.emission == (0, 0, 0)
        assert item.material.coverage == 1
        assert (
            max(constant(item.material.transmission)) / min(constant(item.material.transmission))
            > 5
        )
