"""Light shafts: the sun enters only through windows, and colored light reaches the floor."""

from __future__ import annotations

import numpy as np

from oitbench.modeling.placement import merge
from oitbench.scene import Mesh, Scene
from tests.meshes import bounds, count_hits, hits
from tests.scenes.helpers import build, named, seen, toward_light


def casters(scene: Scene) -> Mesh:
    return merge([item.mesh for item in scene.opaque if item.casts])


def test_the_sun_enters_only_through_the_windows() -> None:
    scene = build("light_shafts[detail=0.3]")
    blocking, toward = casters(scene), toward_light(scene)
    assert toward[2] < 0  # the sun is in front of the camera
    random = np.random.default_rng(7)
    lit = 0
    for _ in range(300):
        point = random.uniform((-3.9, 0.05, -11.9), (3.9, 6.1, 1.0))
        if len(hits(blocking, point, toward)):
            continue
        lit += 1
        side, end = ((4.25 - point[0]) / toward[0], (-12.25 - point[2]) / toward[2])
        x, y, z = point + min(side, end) * toward
        assert 1.1 < y < 4.95
        across = (z + 12) % 3 - 1.5 if side < end else x % 4 - 2
        assert np.abs(across) < 0.65
    assert 0.03 < lit / 300 < 0.4


def test_colored_light_falls_on_the_floor_in_front_of_the_camera() -> None:
    scene = build("light_shafts")
    blocking, toward = casters(scene), toward_light(scene)
    for name in ("blue glass", "gold glass"):
        low, high = (corner.astype(np.float64) for corner in bounds(named(scene, name).mesh))
        lit = []
        for u in np.linspace(0.1, 0.9, 9):
            for v in np.linspace(0.1, 0.9, 5):
                point = low + (high - low) * [0, v, u]
                floor = point - toward * (point[1] / toward[1])
                if not len(hits(blocking, floor + 1e-3 * toward, toward)):
                    lit.append(floor)
        assert lit
        assert (np.abs(seen(scene.camera, lit)) < 1).all(axis=1).any()


def test_the_statue_is_partly_in_shadow() -> None:
    scene = build("light_shafts[detail=0.3]")
    blocking, toward = casters(scene), toward_light(scene)
    statue = named(scene, "statue").mesh
    assert statue.normals is not None
    facing = np.flatnonzero(statue.normals @ toward > 0.3)[::10]
    starts = statue.positions[facing] + 0.01 * statue.normals[facing]
    # Its parts overlap: some vertices are inside it.
    starts = starts[count_hits(statue, starts, toward) == 0]
    lit = np.mean([not len(hits(blocking, start, toward)) for start in starts])
    assert len(starts) > 20
    assert 0.15 < lit < 0.85
