"""Clouds: one in the shadow of another, in front of a blue sky."""

from __future__ import annotations

import numpy as np

from oitbench.scene import Texture
from tests.scenes.helpers import (
    SQUARE,
    build,
    layers_toward_light,
    named,
    seen,
    sprite_centers,
)


def test_the_left_cloud_shadows_a_part_of_the_center_one() -> None:
    scene = build("clouds")
    left, middle = (named(scene, f"{name} cloud") for name in ("left", "center"))
    layers = layers_toward_light(scene, left.mesh, sprite_centers(middle))
    assert 0.1 < (layers >= 3).mean() < 0.6
    assert not scene.opaque


def test_all_clouds_are_whole_in_a_square_picture() -> None:
    scene = build("clouds")
    for item in scene.transparent:
        assert (np.abs(seen(scene.camera, item.mesh.positions)) < SQUARE).all(), item.name


def test_clouds_are_in_front_of_a_blue_sky_with_a_brighter_horizon() -> None:
    scene = build("clouds")
    assert 2500 <= sum(len(item.mesh.triangles) // 2 for item in scene.transparent) <= 3000
    sky = scene.environment
    assert sky is not None
    assert isinstance(sky.radiance, Texture)
    texels = sky.radiance.texels
    zenith, horizon = texels[0, 0], texels[len(texels) // 2 - 1, 0]
    assert zenith[2] > 2 * zenith[0]
    assert horizon.mean() > 2 * zenith.mean()
