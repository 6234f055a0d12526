"""Smoke ball: particles in random order, and a cube in the smoke, above it or beside it."""

from __future__ import annotations

import numpy as np
import pytest

from tests.meshes import bounds
from tests.scenes.helpers import (
    build,
    layers_toward_light,
    named,
    particles,
    sprite_centers,
    toward_light,
)


def test_smoke_is_one_object_of_a_thousand_particles_in_random_order() -> None:
    scene = build("smoke_ball")
    (smoke,) = scene.transparent
    assert smoke.particles
    assert len(smoke.mesh.triangles) == 2000
    depth = scene.camera.view_distance(sprite_centers(smoke))
    assert abs(np.corrcoef(np.arange(1000), depth)[0, 1]) < 0.1


@pytest.mark.parametrize(("cube", "inside"), [("inside", True), ("above", False)])
def test_the_cube_is_in_the_smoke_or_between_smoke_and_sun(cube: str, inside: bool) -> None:
    scene = build(f"smoke_ball[cube={cube}]")
    (smoke,) = particles(scene)
    block = named(scene, "cube").mesh
    low, high = bounds(block)
    middles = sprite_centers(smoke)
    within = ((middles > low) & (middles < high)).all(axis=1).sum()
    assert (20 < within < 500) if inside else within == 0
    shaded = layers_toward_light(scene, block, middles) > 0
    # The shadow goes through a part of the smoke, from its sunny side to its far one.
    assert 0.05 < shaded.mean() < 0.5
    if not inside:
        along = middles @ toward_light(scene)
        assert np.ptp(along[shaded]) > 0.8 * np.ptp(along)


def test_a_cube_beside_the_smoke_casts_no_shadow_on_it() -> None:
    scene = build("smoke_ball[cube=away]")
    (smoke,) = particles(scene)
    assert (layers_toward_light(scene, named(scene, "cube").mesh, sprite_centers(smoke)) == 0).all()
