"""Frosted door: people at two distances behind one pane, sharp objects in front of it."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.scene import Floats, Scene, SpotLight
from tests.meshes import corners, hits
from tests.scenes.helpers import build, named


def person(scene: Scene, name: str) -> Floats:
    """Return the vertices of a person's clothes, skin and hair, shape (n, 3)."""
    parts = [name, f"{name}'s skin", f"{name}'s hair"]
    return np.concatenate([named(scene, part).mesh.positions for part in parts])


def test_no_cone_of_light_ends_on_the_walls_above_the_panels() -> None:
    scene = build("frosted_door[detail=1]")
    lamp, fill, _ = scene.beams
    assert isinstance(lamp, SpotLight)
    assert isinstance(fill, SpotLight)
    points = named(scene, "corridor walls").mesh.positions
    points = points[(points[:, 1] > 0.9) & (points[:, 2] < -1)]
    for light, reached in ((lamp, False), (fill, True)):
        axis = np.subtract(light.target, light.position)
        rays = points - np.asarray(light.position)
        angle = np.arccos(rays @ axis / np.linalg.norm(rays, axis=1) / np.linalg.norm(axis))
        # The ceiling just behind the lamp is not in its cone either.
        assert ((angle < 0.9 * light.angle / 2) if reached else (angle > light.angle / 2)).all()


def test_people_are_at_two_distances_behind_one_pane() -> None:
    scene = build("frosted_door")
    (pane,) = scene.transparent
    assert np.ptp(pane.mesh.positions[:, 2]) == 0
    behind = {name: -person(scene, name)[:, 2].max() for name in ("woman", "man")}
    assert 0 < behind["woman"] < 0.05
    assert behind["man"] > 1.9
    assert -named(scene, "far window").mesh.positions[:, 2].max() > 2 * behind["man"]


def test_only_the_hand_is_near_the_glass() -> None:
    points = person(build("frosted_door"), "woman")
    near = points[points[:, 2] > -0.09]
    assert np.ptp(near[:, 1]) < 0.3
    assert (points[:, 2] < -0.2).mean() > 0.5


@pytest.mark.parametrize("name", ["lettering", "frame", "office wall"])
def test_sharp_objects_are_in_front_of_the_pane(name: str) -> None:
    scene = build("frosted_door[detail=0.1]")
    mesh, eye = named(scene, name).mesh, np.asarray(scene.camera.position)
    pane = named(scene, "pane").mesh.positions
    for triangle in corners(mesh):
        middle = triangle.mean(axis=0)
        at = eye + (middle - eye) * (eye[2] / (eye[2] - middle[2]))
        through = (at[:2] > pane[:, :2].min(axis=0)).all() and (
            at[:2] < pane[:, :2].max(axis=0)
        ).all()
        # A triangle behind the plane of the pane is hidden by the front of its own mesh.
        assert not through or middle[2] > 0 or len(hits(mesh, eye, middle - eye)) > 1


def test_lettering_covers_only_the_pane() -> None:
    scene = build("frosted_door")
    letters, pane = named(scene, "lettering").mesh.positions, named(scene, "pane").mesh.positions
    assert 0 < letters[:, 2].min() <= letters[:, 2].max() < 0.02
    for axis in (0, 1):
        assert pane[:, axis].min() < letters[:, axis].min()
        assert letters[:, axis].max() < pane[:, axis].max()
