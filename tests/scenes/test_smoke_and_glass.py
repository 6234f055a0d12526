"""Smoke and glass: nearly all fragments are smoke, with glass in the middle of it."""

from __future__ import annotations

from tests.meshes import count_hits
from tests.scenes.helpers import build, center, particles, sprite_centers, view_rays


def test_most_fragments_are_smoke() -> None:
    scene = build("smoke_and_glass")
    rays = view_rays(scene.camera, 12)
    layers = {
        item.name: count_hits(item.mesh, scene.camera.position, rays) for item in scene.transparent
    }
    smoke = layers.pop("smoke")
    assert smoke.mean() > 20
    assert (smoke > 10).mean() > 0.9
    assert smoke.sum() > 15 * sum(counts.sum() for counts in layers.values())
    assert all(counts.max() > 0 for counts in layers.values())


def test_glass_is_sheets_and_refracting_solids_at_full_resolution() -> None:
    glass = [item for item in build("smoke_and_glass").transparent if not item.particles]
    assert sum(item.material.refracts for item in glass) >= 2
    assert sum(not item.material.solid and item.material.tints for item in glass) >= 2


def test_glass_is_partly_in_front_of_and_partly_in_the_smoke() -> None:
    scene = build("smoke_and_glass")
    (smoke,) = particles(scene)
    distance = scene.camera.view_distance(sprite_centers(smoke))
    for item in scene.transparent:
        if not item.particles:
            depth = float(scene.camera.view_distance(center(item)))
            assert 0.03 < (distance < depth).mean() < 0.97
