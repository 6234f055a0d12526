"""The rays of random refracted references pass through their sub-pixels at random."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest

from oitbench.modeling.mesh import sphere
from oitbench.path_traced.export.view import View
from oitbench.path_traced.matched.render import matched
from oitbench.path_traced.references import pieces, rendering
from oitbench.scene import (
    Camera,
    DirectionalLight,
    EnvironmentLight,
    Light,
    Material,
    Object,
    Scene,
)
from oitbench.truths import MATCHED
from tests.path_traced.agreement import needs_mitsuba
from tests.path_traced.stored import wanted

SUN = DirectionalLight((0.0, -1.0, 0.0))
CAMERAS = (Camera((1.0, 2.0, 5.0), fov_y=math.radians(40)), Camera((1.0, 2.0, 5.0), height=3.0))


@pytest.mark.parametrize("camera", CAMERAS)
def test_jittered_rays_stay_in_their_sub_pixels(camera: Camera) -> None:
    jittered = places(camera, (7, 0, 0))
    apart = jittered - places(camera)
    assert (np.abs(apart) <= 0.5).all()
    assert 0.2 < np.abs(apart).mean() < 0.3
    np.testing.assert_array_equal(jittered, places(camera, (7, 0, 0)))
    assert (jittered != places(camera, (8, 0, 0))).all()


def places(
    camera: Camera, seed: tuple[int, ...] = ()
) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Return where rays cross the plane one meter before the camera, in sub-pixels."""
    view = View(camera, 6, 4)
    origins, directions = view.rays(0, view.width * view.height, seed)
    right, up, back = camera.axes
    offset = origins - np.asarray(camera.position)
    away = (1 + offset @ back) / (directions @ -back)
    at = offset + away[:, None] * directions
    return np.stack([at @ right / view.step[0], at @ up / view.step[1]])


@needs_mitsuba
def test_each_sample_has_its_own_jitter(monkeypatch: pytest.MonkeyPatch) -> None:
    seeds = []
    original = View.rays

    def rays(view: View, first: int, last: int, seed: Sequence[int] = ()) -> object:
        seeds.append(tuple(seed))
        return original(view, first, last, seed)

    monkeypatch.setattr(View, "rays", rays)
    for part in range(2):
        matched(ball(), (4, 4), 1, samples=2, part=part, jitter=True)
    assert len(set(seeds)) == 4
    matched(ball(), (4, 4), 1, samples=1)
    assert seeds[-1] == ()


@needs_mitsuba
@pytest.mark.parametrize("lit", [False, True])
def test_only_random_refraction_is_jittered(lit: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = ball(SUN if lit else EnvironmentLight())
    found = []
    monkeypatch.setattr(pieces, "matched", lambda *_, jitter, **__: found.append(jitter))
    pieces.render_part(scene, rendering.plan_rendering(wanted(scene, MATCHED)), 3)
    assert found == [lit]


def ball(light: Light = SUN) -> Scene:
    """Return a glass ball."""
    material = Material(transmission=(0.9, 0.9, 0.9), index=1.5, solid=True)
    item = Object("ball", sphere((0.0, 0.0, 0.0), 0.5, 8, 4), material)
    return Scene("window", Camera((0.0, 0.0, 4.0)), (item,), lights=(light,))
