"""Caustic spheres: solids that differ only in their index, in the cone of the spot light."""

from __future__ import annotations

import itertools

import numpy as np

from oitbench.scene import SpotLight
from oitbench.scene.texturing import constant
from tests.meshes import bounds, count_hits, hits
from tests.scenes.helpers import build, center, named


def test_solids_differ_only_in_their_index_and_hover_in_a_row() -> None:
    solids = build("caustic_spheres").transparent
    indices = [item.material.index for item in solids]
    assert indices[0] == 1.0
    assert indices == sorted(indices)
    assert len(set(indices)) == 3
    assert all(item.material.solid for item in solids)
    assert solids[0].material.reflectance == 0
    assert len({item.material.transmission for item in solids}) == 1
    assert (
        0.6
        < min(constant(solids[0].material.transmission))
        < max(constant(solids[0].material.transmission))
        < 0.95
    )
    spans = [bounds(item.mesh) for item in solids]
    assert all(one[1][0] < other[0][0] for one, other in itertools.pairwise(spans))
    assert all(0.1 < low[1] < 0.4 for low, _ in spans)


def test_the_spot_light_reaches_every_solid() -> None:
    scene = build("caustic_spheres")
    (spot,) = scene.beams
    assert isinstance(spot, SpotLight)
    axis = np.subtract(spot.target, spot.position)
    axis /= np.linalg.norm(axis)
    for item in scene.transparent:
        rays = item.mesh.positions - np.asarray(spot.position)
        cosine = (rays @ axis) / np.linalg.norm(rays, axis=1)
        assert np.arccos(cosine).max() < 0.9 * spot.angle / 2


def test_the_knot_is_not_a_ball() -> None:
    knot = named(build("caustic_spheres[detail=0.2]"), "knot of index 1.5")
    line = np.linspace(-0.4, 0.4, 16)
    before = center(knot) + np.array([0.0, 0.0, 2.0])
    origins = np.stack(np.meshgrid(line, line, [0.0]), axis=-1).reshape(-1, 3) + before
    assert count_hits(knot.mesh, origins, (0.0, 0.0, -1.0)).max() >= 4
    assert not len(hits(knot.mesh, before, (0.0, 0.0, -1.0)))
