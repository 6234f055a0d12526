"""Foggy street: fog that thickens with distance, lamps that recede, a tree and lit windows."""

from __future__ import annotations

import numpy as np

from oitbench.scene import Scene, SpotLight
from tests.scenes.helpers import build, named, view_distances


def optical_depth(scene: Scene, distance: float) -> float:
    """Return that of the fog along the street from the camera, from the cells on the way."""
    fog = scene.medium
    assert fog is not None
    assert fog.density is not None
    steps = -(np.arange(1000) + 0.5) / 1000 * distance
    points = np.asarray(scene.camera.position) + np.stack([0 * steps, 0 * steps, steps], axis=1)
    span = np.subtract(fog.high, fog.low)
    cells = ((points - fog.low) / span * fog.density.shape[::-1]).astype(int)
    passed = fog.density[cells[:, 2], cells[:, 1], cells[:, 0]]
    return float(passed.mean() * distance * fog.extinction)


def test_the_woman_is_near_and_the_man_deep_in_the_fog() -> None:
    scene = build("foggy_street")
    woman, man = (
        float(view_distances(scene, named(scene, name).mesh).mean()) for name in ("woman", "man")
    )
    assert man > 2 * woman
    assert optical_depth(scene, woman) < 0.25
    assert optical_depth(scene, man) > 2.5 * optical_depth(scene, woman)
    assert optical_depth(scene, 60.0) > 2


def test_lamps_recede_and_shine_down_from_below_their_bulbs() -> None:
    scene = build("foggy_street")
    bulbs = named(scene, "bulbs").mesh
    assert np.ptp(view_distances(scene, bulbs)) > 40
    spots = [light for light in scene.beams if isinstance(light, SpotLight)]
    assert len(spots) == len(scene.beams) == 2
    for light in spots:
        gap = np.linalg.norm(bulbs.positions - np.asarray(light.position), axis=1)
        assert 0 < gap.min() < 0.1
        assert light.target[1] < light.position[1]


def test_leaves_cover_partly_and_transmit_nothing() -> None:
    (leaves,) = build("foggy_street").transparent
    assert leaves.material.binary_coverage
    assert leaves.material.transmission == (0, 0, 0)


def test_another_seed_lights_other_windows() -> None:
    one, other = (
        named(build(f"foggy_street[detail=0.1,seed={seed}]"), "warm windows") for seed in (1, 2)
    )
    assert not np.array_equal(one.mesh.positions, other.mesh.positions)
