"""Power plant: pipes at right angles, gratings, and shells that cover more at a slant."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.scene import Texture
from tests.meshes import bounds
from tests.scenes.helpers import build, named

SMALL = "power_plant[detail=0.1]"


def test_all_but_the_ground_is_partly_transparent() -> None:
    scene = build(SMALL)
    assert [item.name for item in scene.opaque] == ["ground"]
    assert len(scene.transparent) >= 10


def test_thousands_of_parts_stand_on_the_ground() -> None:
    scene = build("power_plant")
    assert sum(len(item.mesh.triangles) for item in scene.transparent) > 200_000
    for item in scene.transparent:
        low, high = bounds(item.mesh)
        assert low[1] > -0.2
        assert high[1] < 20


def test_pipes_run_along_the_axes() -> None:
    mesh = named(build("power_plant"), "steam pipes").mesh
    assert mesh.normals is not None
    corners = mesh.positions[mesh.triangles]
    longest = np.linalg.norm(np.diff(corners, axis=1), axis=2).argmax(axis=1)
    edges = np.diff(corners, axis=1)[np.arange(len(corners)), longest]
    lengths = np.linalg.norm(edges, axis=1)
    long = lengths > 1.0
    straightness = np.abs(edges[long]).max(axis=1) / lengths[long]
    assert long.sum() > 1000
    assert np.quantile(straightness, 0.1) > 0.98


def test_shells_cover_alpha_straight_on_and_more_at_a_slant() -> None:
    scene = build("power_plant[detail=0.1,alpha=0.3]")
    item = named(scene, "vessels")
    mesh, most = item.mesh, item.material.coverage
    assert isinstance(most, float)
    assert mesh.coverage is not None
    assert mesh.normals is not None
    covers = most * mesh.coverage
    to_eye = np.asarray(scene.camera.position) - mesh.positions
    to_eye /= np.linalg.norm(to_eye, axis=1, keepdims=True)
    cosine = np.abs((mesh.normals * to_eye).sum(axis=1))
    assert covers[cosine > 0.995].mean() == pytest.approx(0.18, abs=0.002)
    slanted = np.abs(cosine - 0.5) < 0.01
    assert covers[slanted].mean() == pytest.approx(1 - 0.82**2, abs=0.01)


def test_walkways_are_gratings() -> None:
    mask = named(build(SMALL), "walkways").material.coverage
    assert isinstance(mask, Texture)
    assert 0.3 < mask.texels.mean() < 0.6
