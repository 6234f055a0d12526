"""Named views, stereo pairs and paths of a camera."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from oitbench.errors import SceneError, UsageError
from oitbench.fingerprints.scene import scene_fingerprint
from oitbench.modeling.mesh import quad
from oitbench.scene import Camera, Material, Object, Scene
from oitbench.scene.paths import between, orbit, stereo
from oitbench.stability.layers import random_lists, scene_of

MAIN = Camera((1.0, 2.0, 5.0), (0.5, 0.0, 0.0), near=0.2)
PLAN = Camera((0.0, 9.0, 0.0), height=3.0)
PANE = Object("pane", quad((0, 0, 0), (1, 0, 0), (0, 1, 0)), Material(0.5))


def scene(**fields: object) -> Scene:
    return Scene("pane", MAIN, (PANE,), **fields)  # type: ignore[arg-type]


def test_a_scene_has_its_views_and_a_stereo_pair() -> None:
    found = scene(views={"plan": PLAN})
    assert found.view_names == ("main", "plan", "left", "right")
    assert found.from_view("main") is found
    assert found.from_view("plan").camera is PLAN
    assert (found.from_view("left").camera, found.from_view("right").camera) == stereo(MAIN)
    assert scene(views={"left": PLAN}).from_view("left").camera is PLAN
    assert replace(found, camera=PLAN).view_names == ("main", "plan")
    with pytest.raises(UsageError, match="unknown view of pane 'plam'; did you mean plan"):
        found.from_view("plam")
    lists = scene_of(random_lists(2))
    assert lists.view_names == ("main",)
    with pytest.raises(SceneError, match="one view"):
        replace(lists, views={"plan": PLAN})


@pytest.mark.parametrize("name", ["main", "", "Plan", "a@b", "a,b", "a b", "-a"])
def test_wrong_names_of_views_are_refused(name: str) -> None:
    with pytest.raises(SceneError, match="no view can be named"):
        scene(views={name: PLAN})


def test_only_the_camera_counts_for_the_fingerprint() -> None:
    plain = scene_fingerprint(scene())
    assert scene_fingerprint(scene(views={"plan": PLAN}, path=(PLAN,))) == plain
    assert scene_fingerprint(scene(views={"plan": PLAN}).from_view("plan")) != plain
    flat = replace(MAIN, height=2.0)
    assert scene_fingerprint(replace(scene(), camera=flat)) != plain


def test_views_have_the_unit_of_the_scene() -> None:
    found = scene(views={"plan": PLAN}, path=(MAIN,), meters_per_unit=0.01).in_meters()
    assert found.from_view("plan").camera.height == pytest.approx(0.03)
    assert found.path[0].position == pytest.approx((0.01, 0.02, 0.05))


def test_a_stereo_pair_has_horizontal_parallax_alone() -> None:
    left, right = stereo(MAIN, 0.3)
    np.testing.assert_allclose(left.axes, MAIN.axes, atol=1e-12)
    np.testing.assert_allclose(np.subtract(right.position, left.position), 0.3 * MAIN.axes[0])
    points = np.random.default_rng(1).normal(size=(20, 3))
    seen = [(points - np.asarray(eye.position)) @ eye.axes.T for eye in (left, right)]
    np.testing.assert_allclose(seen[0][:, 1:], seen[1][:, 1:], atol=1e-12)
    np.testing.assert_allclose(seen[0][:, 0] - seen[1][:, 0], 0.3)
    wide = math.dist(*(eye.position for eye in stereo(MAIN)))
    assert wide == pytest.approx(math.dist(MAIN.position, MAIN.target) / 30)
    for camera, distance in ((PLAN, None), (MAIN, 0.0), (MAIN, math.inf)):
        with pytest.raises(SceneError, match="stereo"):
            stereo(camera, distance)


def test_an_orbit_keeps_its_height_and_distance() -> None:
    frames = orbit(MAIN, 8)
    assert frames[0] is MAIN
    heights = [frame.position[1] for frame in frames]
    distances = [math.dist(frame.position, frame.target) for frame in frames]
    np.testing.assert_allclose(heights, 2.0, atol=1e-12)
    np.testing.assert_allclose(distances, distances[0])
    # A quarter turn, counterclockwise seen from above: from +z to +x.
    np.testing.assert_allclose(frames[2].position, (0.5 + 5.0, 2.0, -0.5), atol=1e-12)
    np.testing.assert_allclose(orbit(MAIN, 4, -0.5)[2].position, frames[-2].position, atol=1e-12)
    assert {frame.near for frame in frames} == {0.2}
    with pytest.raises(SceneError, match="orbit"):
        orbit(MAIN, 0)


def test_a_path_between_two_cameras_is_straight() -> None:
    last = Camera((3.0, 2.0, 1.0), (0.0, 1.0, 0.0), fov_y=1.0, near=0.4)
    frames = between(MAIN, last, 5)
    assert (frames[0], frames[-1], len(frames)) == (MAIN, last, 5)
    np.testing.assert_allclose(frames[2].position, (2.0, 2.0, 3.0))
    assert frames[1].near == pytest.approx(0.25)
    assert frames[2].far == math.inf
    flat = between(PLAN, replace(PLAN, height=5.0), 3)
    assert flat[1].height == pytest.approx(4.0)
    with pytest.raises(SceneError, match="two of a kind"):
        between(MAIN, PLAN, 3)
    with pytest.raises(SceneError, match="two frames"):
        between(MAIN, last, 1)
