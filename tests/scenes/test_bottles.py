"""Bottles: four walls along a ray, no correct order of objects, shadows toward the viewer."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from oitbench.scene.texturing import constant
from tests.meshes import hits
from tests.scenes.helpers import build, center, named, shadow_on_ground, view_distances


@pytest.mark.parametrize("name", ["ruby", "emerald", "amber", "sapphire"])
def test_a_ray_through_a_bottle_meets_four_walls(name: str) -> None:
    mesh = named(build("bottles[detail=0.3]"), name).mesh
    middle = mesh.positions.mean(axis=0) * [1, 0, 1] + [0.0031, 0.07, 0]
    assert len(hits(mesh, middle + np.array([0, 0.003, 1]), (0, -0.003, -1))) == 4


def test_bottles_overlap_in_depth() -> None:
    scene = build("bottles[detail=0.1]")
    spans = sorted(
        (float(z.min()), float(z.max()))
        for z in (view_distances(scene, item.mesh) for item in scene.transparent)
    )
    assert any(one[1] > other[0] for one, other in itertools.pairwise(spans))


def test_the_inner_wall_is_inside_the_outer_one() -> None:
    mesh = named(build("bottles[detail=0.3]"), "emerald").mesh
    half = len(mesh.positions) // 2
    foot = np.array([mesh.positions[0, 0], 0, mesh.positions[0, 2]])
    outer, inner = (
        np.hypot(*(part - foot)[:, [0, 2]].T) for part in np.split(mesh.positions, [half])
    )
    assert inner.max() == pytest.approx(outer.max() - 0.0025, abs=2e-4)


def test_plastic_is_a_glossy_thin_film() -> None:
    for item in build("bottles[detail=0.1]").transparent:
        material = item.material
        assert not material.solid
        assert not material.refracts
        assert 0 < material.reflectance <= 0.1
        assert 0 < max(constant(material.albedo)) < 0.1
        assert max(constant(material.transmission)) / min(constant(material.transmission)) > 1.5


def test_shadows_fall_toward_the_viewer() -> None:
    scene = build("bottles[detail=0.1]")
    for item in scene.transparent:
        shadow = shadow_on_ground(scene, item)
        assert scene.camera.view_distance(shadow) < scene.camera.view_distance(center(item))
