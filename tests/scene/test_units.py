"""Conversions of scenes to meters, and to coordinates relative to the camera."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from oitbench.errors import SceneError
from oitbench.modeling.mesh import quad
from oitbench.scene import Camera, DirectionalLight, Material, Medium, Object, Scene, SpotLight

SUN = DirectionalLight((0.0, -1.0, 0.0), (3.0, 3.0, 3.0))
GLASS = Material(coverage=0.5)


def written(**parts: Any) -> Scene:
    """Return a scene in millimeters."""
    sheet = Object("sheet", quad((0, 0, -2000), (500, 0, 0), (0, 500, 0)), GLASS)
    content: dict[str, Any] = {
        "camera": Camera((1000, 2000, 3000), (0, 0, -500), near=50, far=9000),
        "objects": (sheet,),
        "lights": (SUN, SpotLight((0, 4000, 0), (0, 0, 100), (5.0, 6.0, 7.0))),
        "medium": Medium(2e-4, (-1000, 0, -3000), (1000, 500, 0)),
        "ambient_occlusion": 250.0,
        "meters_per_unit": 1e-3,
    }
    return Scene("mm", **(content | parts))


def test_all_lengths_become_meters() -> None:
    scene = written().in_meters()
    camera, (sun, spot), medium = scene.camera, scene.lights, scene.medium
    assert medium is not None
    assert isinstance(spot, SpotLight)
    assert camera.position == pytest.approx((1, 2, 3))
    assert camera.target == pytest.approx((0, 0, -0.5))
    assert (camera.near, camera.far) == pytest.approx((0.05, 9))
    assert spot.position == pytest.approx((0, 4, 0))
    assert spot.target == pytest.approx((0, 0, 0.1))
    assert medium.low == pytest.approx((-1, 0, -3))
    assert medium.high == pytest.approx((1, 0.5, 0))
    assert medium.extinction == pytest.approx(0.2)
    assert scene.ambient_occlusion == pytest.approx(0.25)
    assert scene.objects[0].mesh.positions[0] == pytest.approx((-0.5, -0.5, -2))
    # No length is in these.
    assert sun is SUN
    assert spot.intensity == (5, 6, 7)
    assert camera.fov_y == written().camera.fov_y


def test_the_camera_becomes_the_origin_in_double_precision() -> None:
    far = 1e9 + 0.25
    sheet = Object("sheet", quad((far + 1000, 2000, 1000), (500, 0, 0), (0, 500, 0)), GLASS)
    camera = Camera((far + 1000, 2000, 3000), (far, 0, -500), far=math.inf)
    scene = written(camera=camera, objects=(sheet,)).seen_from_camera()
    assert scene.camera.position == (0, 0, 0)
    assert scene.camera.target == pytest.approx((-1, -2, -3.5), abs=1e-9)
    assert scene.camera.far == math.inf
    np.testing.assert_allclose(scene.objects[0].mesh.positions[0], (-0.5, -0.5, -2), atol=1e-9)
    assert scene.medium is not None
    assert scene.medium.low[0] == pytest.approx(-1e6 - 2.00025, rel=1e-12)


def test_only_a_far_scene_is_moved_for_the_path_tracer() -> None:
    near = written()
    assert near.near_origin().camera.position == pytest.approx((1, 2, 3))
    camera = Camera((1e6, 0, 0), (1e6, 0, -500))
    assert written(camera=camera).near_origin().camera.position == (0, 0, 0)


@pytest.mark.parametrize("unit", [0.0, -1.0, math.inf, math.nan])
def test_a_unit_has_a_length(unit: float) -> None:
    with pytest.raises(SceneError, match="scene mm: meters_per_unit is"):
        written(meters_per_unit=unit)


def test_a_decal_names_another_object() -> None:
    sheet = written().objects[0]
    with pytest.raises(SceneError, match="object a: it is a decal of itself"):
        Object("a", sheet.mesh, GLASS, decal_of="a")
    decal = Object("decal", sheet.mesh, GLASS, decal_of="wall")
    with pytest.raises(SceneError, match="scene mm: decal is a decal of wall, which is missing"):
        written(objects=(sheet, decal))


def test_positions_have_double_precision() -> None:
    mesh = quad((1e6, 0, 0), (1e-6, 0, 0), (0, 1, 0))
    assert mesh.positions.dtype == np.float64
    assert np.ptp(mesh.positions[:, 0]) == pytest.approx(2e-6, rel=1e-3)
