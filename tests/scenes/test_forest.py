"""Forest: cards of five kinds beside a path, twigs as textures, and mist over the distance."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.scene import Scene, Texture
from tests.scenes.helpers import build, named, view_distances

SMALL = "forest[detail=0.1]"
KINDS = {"beech", "birch", "saplings", "ferns", "grass"}


def test_foliage_is_five_kinds_of_cards_with_smooth_edges() -> None:
    scene = build(SMALL)
    assert {item.name for item in scene.transparent} == KINDS
    for item in scene.transparent:
        mask = item.material.coverage
        assert isinstance(mask, Texture)
        assert isinstance(item.material.emission, Texture)
        partial = ((mask.texels > 0) & (mask.texels < 1)).mean()
        assert 0.02 < partial < 0.35
        assert mask.texels.max() == 1


def test_the_path_is_free_of_trees_and_undergrowth() -> None:
    scene = build(SMALL)
    for name in ("saplings", "ferns", "grass"):
        points = named(scene, name).mesh.positions
        near = points[(points[:, 2] > -9) & (points[:, 1] < 0.5)]
        assert (np.abs(near[:, 0] - 0.35) < 0.3).mean() < 0.05
    trunks = named(scene, "trees").mesh.positions
    low = trunks[(trunks[:, 1] < 1.5) & (trunks[:, 2] > -40)]
    path = 0.35 - 0.9 * np.sin(low[:, 2] / 9) * np.clip(-low[:, 2] / 10, 0, 1)
    assert np.abs(low[:, 0] - path).min() > 0.7


def test_mist_takes_the_contrast_of_far_wood() -> None:
    scene = build(SMALL)
    trees = named(scene, "trees").mesh
    assert trees.radiance is not None
    light, away = trees.radiance.mean(axis=1), view_distances(scene, trees)
    near, far = light[away < 12], light[away > 55]
    assert near.mean() < 0.6 * far.mean()
    assert near.std() / near.mean() > 2 * far.std() / far.mean()


def test_the_sun_dapples_the_ground() -> None:
    scene = build("forest[detail=0.25]")
    ground = named(scene, "ground").mesh
    assert ground.radiance is not None
    near = view_distances(scene, ground) < 12
    light = ground.radiance[near].mean(axis=1)
    assert np.quantile(light, 0.95) > 3 * np.quantile(light, 0.2)


def test_cards_stand_before_the_mist_and_above_the_ground() -> None:
    scene = build(SMALL)
    sky = view_distances(scene, named(scene, "sky").mesh).min()
    for item in scene.transparent:
        assert view_distances(scene, item.mesh).max() < sky
        assert np.quantile(item.mesh.positions[:, 1], 0.05) > -0.2


@pytest.mark.parametrize("detail", [0.1, 0.4])
def test_fewer_and_larger_cards_shade_as_much(detail: float) -> None:
    """The mean radiance of leaves, over vertices, is that of the whole forest."""
    fewer, whole = (leaf_light(build(f"forest[detail={value}]")) for value in (detail, 1))
    np.testing.assert_allclose(fewer, whole, rtol=0.05)


def leaf_light(scene: Scene) -> float:
    shades = [item.mesh.radiance for item in scene.transparent if item.mesh.radiance is not None]
    return float(np.concatenate(shades).mean())
