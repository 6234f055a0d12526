"""Smoke yard: dense smoke at the drum, vehicles with windows, a fence of wire, and shadows."""

from __future__ import annotations

import numpy as np

from oitbench.scene import Sprites, Texture
from tests.scenes.helpers import build, named, particles, view_distances

SMALL = "smoke_yard[detail=0.1]"


def test_all_kinds_of_layers_are_there() -> None:
    names = {item.name for item in build(SMALL).transparent}
    assert names == {
        "plume", "drift", "veil", "bushes", "fence", "workshop windows", "windows of the van",
        "windows of the sedan",
    }  # fmt: skip


def test_smoke_is_before_and_behind_windows() -> None:
    scene = build(SMALL)
    veil = view_distances(scene, named(scene, "veil").mesh)
    panes = view_distances(scene, named(scene, "workshop windows").mesh).mean()
    assert veil.min() < panes < veil.max()
    van = view_distances(scene, named(scene, "windows of the van").mesh)
    plume = view_distances(scene, named(scene, "plume").mesh)
    drift = view_distances(scene, named(scene, "drift").mesh)
    assert plume.max() > van.mean()
    assert drift.min() < van.mean()


def test_nearly_all_smoke_is_behind_the_fence() -> None:
    scene = build(SMALL)
    fence = named(scene, "fence").mesh.positions[:, 2]
    assert np.ptp(fence) == 0
    for item in particles(scene):
        assert (item.mesh.positions[:, 2] < fence[0]).mean() > 0.9
    assert view_distances(scene, named(scene, "fence").mesh).min() > scene.camera.near


def test_hundreds_of_particles_rise_from_the_drum() -> None:
    mesh = named(build("smoke_yard"), "plume").mesh
    assert isinstance(mesh, Sprites)
    centers = np.asarray(mesh.centers)
    drum = named(build("smoke_yard"), "drums").mesh.positions
    mouth = np.array([0.0, drum[:, 1].max(), -7.5])
    assert (np.linalg.norm(centers - mouth, axis=1) < 0.35).sum() > 300
    assert (centers[:, 1] > mouth[1] - 0.3).all()


def test_smoke_in_the_shadow_of_smoke_is_darker_and_needs_no_shadow_rays() -> None:
    scene = build("smoke_yard")
    for item in particles(scene):
        assert not item.receives_shadows
    mesh = named(scene, "plume").mesh
    assert isinstance(mesh, Sprites)
    light, places = np.asarray(mesh.albedos)[:, 0], np.asarray(mesh.centers)
    head = places[:, 1] > 2.6
    toward_sun = places[head] @ [-0.62, 0.70, 0.36]
    assert np.corrcoef(toward_sun, light[head])[0, 1] > 0.4
    assert light.min() >= 0.3
    assert light.max() > 0.8


def test_wire_covers_a_small_part_of_the_fence() -> None:
    mask = named(build(SMALL), "fence").material.coverage
    assert isinstance(mask, Texture)
    assert 0.1 < mask.texels.mean() < 0.3
