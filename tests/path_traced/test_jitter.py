"""The rays of random refracted references pass through their sub-pixels at random."""

from __future__ import annotations

import math

import numpy as np
import pytest

from oitbench.modeling.mesh import sphere
from oitbench.path_traced.export.view import View
from oitbench.path_traced.references import rendering
from oitbench.scene import Camera, DirectionalLight, EnvironmentLight, Material, Object, Scene
from oitbench.truths import MATCHED
from tests.path_traced.agreement import needs_mitsuba
from tests.path_traced.stored import wanted

CAMERAS = (Camera((1.0, 2.0, 5.0), fov_y=math.radians(40)), Camera((1.0, 2.0, 5.0), height=3.0))


@pytest.mark.parametrize("camera", CAMERAS)
def test_jittered_rays_stay_in_their_sub_pixels(camera: Camera) -> None:
    view = View(camera, 6, 4)
    jittered = View(camera, 6, 4, jitter=7)
    apart = np.subtract(places(jittered), places(view))
    assert (np.abs(apart) <= 0.5).all()
    assert 0.2 < np.abs(apart).mean() < 0.3
    np.testing.assert_array_equal(places(jittered), places(View(camera, 6, 4, jitter=7)))
    assert (places(jittered) != places(View(camera, 6, 4, jitter=8))).all()


def places(view: View) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Return where rays cross the plane one meter before the camera, in sub-pixels."""
    origins, directions = view.rays(0, view.width * view.height)
    right, up, back = view.camera.axes
    offset = origins - np.asarray(view.camera.position)
    away = (1 + offset @ back) / (directions @ -back)
    at = offset + away[:, None] * directions
    return np.stack([at @ right / view.step[0], at @ up / view.step[1]])


@needs_mitsuba
@pytest.mark.parametrize("lit", [False, True])
def test_only_random_refraction_is_jittered(lit: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    material = Material(transmission=(0.9, 0.9, 0.9), index=1.5, solid=True)
    light = DirectionalLight((0.0, -1.0, 0.0)) if lit else EnvironmentLight()
    ball = Object("ball", sphere((0.0, 0.0, 0.0), 0.5, 8, 4), material)
    scene = Scene("window", Camera((0.0, 0.0, 4.0)), (ball,), lights=(light,))
    found = []
    monkeypatch.setattr(rendering, "matched", lambda *_, jitter, **__: found.append(jitter))
    rendering.render_part(scene, rendering.plan_rendering(wanted(scene, MATCHED)), 3)
    assert found == [lit]
