"""Frosted door: people at two distances behind one pane, sharp objects in front of it."""

from __future__ import annotations

import numpy as np
import pytest

from tests.meshes import corners, hits
from tests.scenes.helpers import build, named


def test_people_are_at_two_distances_behind_one_pane() -> None:
    scene = build("frosted_door")
    (pane,) = scene.transparent
    assert np.ptp(pane.mesh.positions[:, 2]) == 0
    behind = {name: -named(scene, name).mesh.positions[:, 2].max() for name in ("woman", "man")}
    assert 0 < behind["woman"] < 0.05
    assert behind["man"] > 1.9
    assert -named(scene, "far window").mesh.positions[:, 2].max() > 2 * behind["man"]


def test_only_the_hand_is_near_the_glass() -> None:
    points = named(build("frosted_door"), "woman").mesh.positions
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
