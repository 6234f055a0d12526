"""Shadow trio: a cloud and a ball side by side, with visible shadows."""

from __future__ import annotations

import numpy as np

from oitbench.modeling.placement import merge
from tests.meshes import bounds, hits
from tests.scenes.helpers import SQUARE, build, named, seen, shadow_on_ground, toward_light


def test_shadows_are_visible() -> None:
    scene = build("shadow_trio")
    for item in scene.transparent:
        shadow = shadow_on_ground(scene, item)
        assert seen(scene.camera, [shadow])[0, 1] > -0.8
        # Its shadow is whole in a square picture.
        edge = item.mesh.positions - toward_light(scene) * (
            item.mesh.positions[:, 1:2] / toward_light(scene)[1]
        )
        assert (np.abs(seen(scene.camera, edge)) < SQUARE).all()
        ray = shadow - scene.camera.position
        for other in scene.transparent:
            assert not len(hits(other.mesh, scene.camera.position, ray))
        floor = merge(
            [tiles.mesh for tiles in (named(scene, "pale tiles"), named(scene, "dark tiles"))]
        )
        assert len(hits(floor, scene.camera.position, ray)) == 1


def test_cloud_and_ball_are_side_by_side_above_the_floor() -> None:
    scene = build("shadow_trio")
    (low, high), (ball_low, _) = (bounds(named(scene, name).mesh) for name in ("cloud", "ball"))
    assert high[0] < ball_low[0]
    assert min(low[1], ball_low[1]) > 0.2
