"""Courtyard: wine in its glasses, flames in their flues, and sun through the crown of a tree."""

from __future__ import annotations

import numpy as np

from oitbench.scene import DirectionalLight, SpotLight
from oitbench.scene.texturing import constant
from tests.meshes import bounds, count_hits, hits
from tests.scenes.helpers import build, center, named, view_rays

PLANTS = ("tree", "bough", "vine", "creeper", "blossoms", "lily", "laurel", "ivy")


def test_wine_reaches_into_its_glass() -> None:
    scene = build("courtyard[detail=0.5]")
    wine, glass = named(scene, "wine"), named(scene, "wine glasses")
    assert glass.priority > wine.priority
    red, green, _ = constant(wine.material.transmission)
    assert red > 5 * green
    near = wine.mesh.positions[wine.mesh.positions[:, 2] > -0.5]
    stem = near[near[:, 1] == near[:, 1].min()][0]
    origin = np.add(stem, (-0.1, 0.02, 0.0))
    met = [(at, "wine") for at in hits(wine.mesh, origin, [1, 0, 0]) if at < 0.2]
    met += [(at, "glass") for at in hits(glass.mesh, origin, [1, 0, 0]) if at < 0.2]
    assert [name for _, name in sorted(met)] == ["glass", "wine", "glass", "glass", "wine", "glass"]


def test_the_lamp_on_the_nearest_table_shines_from_its_flame_through_its_flue() -> None:
    scene = build("courtyard[detail=0.1]")
    (lamp,) = [light for light in scene.beams if isinstance(light, SpotLight)]
    flames = named(scene, "flames").mesh.positions
    assert np.linalg.norm(flames - np.asarray(lamp.position), axis=1).min() < 0.03
    around = [hits(named(scene, "flues").mesh, lamp.position, ray) for ray in np.eye(3)[[0, 2]]]
    assert all(len(met) and met[0] < 0.06 for met in around)
    assert not named(scene, "flues").material.solid
    assert np.argmax(lamp.intensity) == 0


def test_leaves_cover_partly_and_have_colors_of_their_own() -> None:
    scene = build("courtyard[detail=0.3]")
    for name in PLANTS:
        leaves = named(scene, name)
        assert leaves.material.binary_coverage
        assert leaves.material.transmission == (0, 0, 0)
        assert leaves.mesh.albedo is not None
        assert len(np.unique(leaves.mesh.albedo, axis=0)) > 10
        dominant = 0 if name == "blossoms" else 1
        assert (leaves.mesh.albedo.argmax(axis=1) == dominant).all()


def test_the_sun_draws_shafts_through_the_crown() -> None:
    scene = build("courtyard[detail=0.3]")
    (sun,) = [light for light in scene.beams if isinstance(light, DirectionalLight)]
    below = center(named(scene, "tree")) + 2.2 * np.asarray(sun.direction)
    points = below + np.random.default_rng(1).normal(size=(60, 3)) * [0.9, 0.1, 0.9]
    toward = -np.asarray(sun.direction)
    layers = count_hits(named(scene, "tree").mesh, points, toward)
    assert 0.05 < (layers == 0).mean() < 0.95
    clear = [not len(hits(named(scene, "arcades").mesh, point, toward)) for point in points]
    assert np.mean(clear) > 0.8


def test_all_kinds_of_transparency_are_in_the_picture() -> None:
    scene = build("courtyard[detail=0.3]")
    rays = view_rays(scene.camera, 48)
    for names in (PLANTS, ("wine glasses",), ("wine",)):
        layers = [
            count_hits(named(scene, name).mesh, scene.camera.position, rays) for name in names
        ]
        assert np.sum(layers) > 0, names
    low, high = bounds(named(scene, "wine glasses").mesh)
    assert low[1] > 0.7
    assert high[1] < 1.0
