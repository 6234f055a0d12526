"""Tumblers: drinks and ice inside their glasses, in the cone of the spot light."""

from __future__ import annotations

import numpy as np

from oitbench.scene import SpotLight
from oitbench.scene.texturing import constant
from tests.meshes import bounds
from tests.scenes.helpers import build, named

LEAST_GAP = 3e-4
"""Distance between a drink and its glass, meters."""


def test_everything_transparent_is_refracting_glass_ice_or_a_colored_drink() -> None:
    scene = build("tumblers[detail=0.1]")
    assert {item.material.index for item in scene.transparent} == {1.31, 1.33, 1.5}
    assert all(item.material.refracts for item in scene.transparent)
    drinks = [item for item in scene.transparent if item.material.index == 1.33]
    assert len(drinks) == 3
    for item in drinks:
        assert max(constant(item.material.transmission)) > 3 * min(
            constant(item.material.transmission)
        )


def test_each_drink_is_inside_one_glass_and_apart_from_it() -> None:
    scene = build("tumblers[detail=0.3]")
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
    ice, glass = (named(scene, name).mesh for name in ("ice", "rocks glass"))
    low, high = bounds(glass)
    middle = (low + high) / 2
    inside = ((ice.positions > low) & (ice.positions < high)).all(axis=1)
    assert 0.7 < inside.mean() < 0.8
    wall = glass.positions
    inner = np.hypot(wall[:, 0] - middle[0], wall[:, 2] - middle[2])
    at_floor = inner[(wall[:, 1] > low[1] + 0.01)].min()
    reach = np.hypot(*(ice.positions[inside][:, [0, 2]] - middle[[0, 2]]).T)
    assert reach.max() < at_floor


def test_the_spot_light_casts_shadows_toward_the_viewer() -> None:
    scene = build("tumblers[detail=0.1]")
    (spot,) = scene.beams
    assert isinstance(spot, SpotLight)
    axis = np.subtract(spot.target, spot.position)
    for item in scene.transparent:
        assert spot.position[2] < item.mesh.positions[:, 2].min()
        ray = item.mesh.positions - np.asarray(spot.position)
        cosine = ray @ axis / np.linalg.norm(ray, axis=1) / np.linalg.norm(axis)
        assert (np.arccos(cosine) < 0.9 * spot.angle / 2).all()
