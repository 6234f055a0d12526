"""Water and smoke: water that touches its glass, and smoke and panes behind the water."""

from __future__ import annotations

import numpy as np

from oitbench.scene import Object
from tests.meshes import bounds, hits
from tests.scenes.helpers import build, center, named, particles, sprite_centers

VESSELS = {"water": "tank", "water of the tumbler": "tumbler"}


def surfaces(water: Object, glass: Object) -> list[str]:
    """Return the surfaces of both that a horizontal ray from the left meets below the water."""
    low, high = bounds(water.mesh)
    origin = [bounds(glass.mesh)[0][0] - 0.1, (low[1] + 2 * high[1]) / 3, center(water)[2] + 1e-3]
    met = [(at, "water") for at in hits(water.mesh, origin, [1, 0, 0])]
    met += [(at, "glass") for at in hits(glass.mesh, origin, [1, 0, 0])]
    return [name for _, name in sorted(met)]


def test_water_reaches_into_glass_of_a_higher_priority() -> None:
    scene = build("water_and_smoke[detail=0.3]")
    for liquid, vessel in VESSELS.items():
        water, glass = named(scene, liquid), named(scene, vessel)
        assert glass.priority > water.priority
        assert 1 < water.material.index < glass.material.index
        # Water begins inside the left wall and ends inside the right one: no air is between.
        expected = ["glass", "water", "glass", "glass", "water", "glass"]
        assert surfaces(water, glass) == expected
        assert (bounds(water.mesh)[0] > bounds(glass.mesh)[0]).all()
        assert (bounds(water.mesh)[1] < bounds(glass.mesh)[1]).all()


def test_weeds_pebbles_and_fish_are_in_the_water() -> None:
    scene = build("water_and_smoke")
    low, high = bounds(named(scene, "tank").mesh)
    low, high = low + 0.008, np.array([high[0] - 0.008, 0.205, high[2] - 0.008])
    for name in ("weeds", "pebbles", "fish", "sand"):
        inner = bounds(named(scene, name).mesh)
        assert (inner[0] > low).all(), name
        assert (inner[1] < high).all(), name


def test_smoke_and_panes_show_through_the_water_and_beside_it() -> None:
    scene = build("water_and_smoke")
    eye, water = scene.camera.position, named(scene, "water").mesh
    (smoke,) = particles(scene)
    middles = sprite_centers(smoke)[::4]
    through = [
        bool(len(hits(water, eye, at - eye)) and hits(water, eye, at - eye)[0] < 1)
        for at in middles
    ]
    assert 0.25 < np.mean(through) < 0.75
    for name in ("amber pane", "teal pane"):
        corners = named(scene, name).mesh.positions
        shown = [bool(len(hits(water, eye, at - np.asarray(eye)))) for at in corners]
        assert any(shown)
        assert not all(shown)
    # Smoke is before one pane and behind another.
    behind = middles[:, 2] < center(named(scene, "amber pane"))[2]
    assert 0.02 < behind.mean() < 0.98


def test_another_seed_moves_smoke_and_weeds() -> None:
    one, other = (build(f"water_and_smoke[detail=0.1,seed={seed}]") for seed in (1, 2))
    for name in ("smoke", "weeds", "pebbles"):
        assert not np.array_equal(
            named(one, name).mesh.positions, named(other, name).mesh.positions
        )
