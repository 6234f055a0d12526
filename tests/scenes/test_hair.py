"""Hair: thin strands from the scalp to the shoulders, outside of the bust, with baked light."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.modeling.props import bust
from oitbench.scene import Floats, Scene, Strands
from tests.scenes.helpers import build, named

SMALL = "hair[detail=0.02]"


def strands(scene: Scene) -> Strands:
    mesh = named(scene, "hair").mesh
    assert isinstance(mesh, Strands)
    return mesh


def curves(scene: Scene) -> Floats:
    return np.asarray(strands(scene).points)


def test_detail_one_is_fifty_thousand_strands() -> None:
    assert len(curves(build(SMALL))) == 1000


def test_fewer_strands_are_wider() -> None:
    lengths = [
        float(np.linalg.norm(np.diff(curves(build(text)), axis=1), axis=2).sum())
        * float(np.asarray(strands(build(text)).width))
        for text in (SMALL, "hair[detail=0.04]")
    ]
    assert lengths[0] == pytest.approx(lengths[1], rel=0.06)


def test_a_pixel_of_720_rows_is_covered_by_two_fifths_of_alpha() -> None:
    """Alpha 0.5 then gives the 0.2 of McGuire and Mara."""
    scene = build(SMALL)
    width = float(np.asarray(strands(scene).width)) * 0.02
    pixel = float(scene.camera.pixel_size(np.zeros((1, 3)), 720)[0])
    assert width / pixel == pytest.approx(0.4, rel=0.02)
    assert named(scene, "hair").material.coverage == 0.5


def test_strands_start_on_the_scalp_and_stay_outside_of_the_bust() -> None:
    points = curves(build(SMALL))
    center, radii = (np.asarray(part) for part in bust.CRANIUM)
    on_scalp = (((points[:, 0] - center) / radii) ** 2).sum(axis=1)
    np.testing.assert_allclose(on_scalp, 1, atol=1e-9)
    depth = bust.distance(points[:, 2:].reshape(-1, 3))
    assert np.quantile(depth, 0.01) > -0.004
    # They fall to the neck or to the shoulders.
    assert np.median(points[:, -1, 1]) < -0.08
    assert points[..., 1].min() > -0.36


def test_hair_does_not_cover_the_face() -> None:
    points = curves(build(SMALL)).reshape(-1, 3)
    face = (np.abs(points[:, 0]) < 0.025) & (np.abs(points[:, 1]) < 0.06) & (points[:, 2] > 0.06)
    assert face.mean() < 0.002


def test_hair_that_other_hair_hides_from_the_lamp_is_darker() -> None:
    mesh = strands(build(SMALL))
    light = np.asarray(mesh.radiances).mean(axis=2).ravel()
    toward = np.asarray(mesh.points).reshape(-1, 3) @ [-0.25, 0.75, 0.70]
    near, far = toward > np.quantile(toward, 0.8), toward < np.quantile(toward, 0.2)
    assert light[near].mean() > 1.5 * light[far].mean()


def test_other_views_look_from_the_front_and_from_the_side() -> None:
    scene = build(SMALL)
    front, side = (scene.from_view(name).camera.axes[2] for name in ("front", "side"))
    assert front @ [0, 0, 1] > 0.99
    assert side @ [-1, 0, 0] > 0.97
