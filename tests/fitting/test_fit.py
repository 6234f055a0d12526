"""Errors on views, and fits of methods to them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from oitbench.errors import SceneError, UsageError
from oitbench.fitting.views import Views, seen_from
from oitbench.fitting.worker import FitMethod, Fitted, fit
from oitbench.gl.device import Device
from oitbench.image import files
from oitbench.modeling.mesh import quad
from oitbench.scene import Camera, Material, Object, Scene
from tests.helpers import BLUE, GREEN, RED, collection, method, random_lists, render, scene_of

SIZE = (8, 8)


def panes(*colors: tuple[float, float, float], half: float = 99) -> Scene:
    """Return panes at 2, 3, 4 ... m, large ones unless `half` a side is given, in meters."""
    objects = tuple(
        Object(
            f"pane {i}", quad((0, 0, -z), (half, 0, 0), (0, half, 0)), Material(0.6, emission=color)
        )
        for i, (z, color) in enumerate(zip(range(2, 9), colors, strict=False))
    )
    return Scene("panes", Camera((0, 0, 0), (0, 0, -3)), objects, exposure=1.0)


def request(label: str, fixed: list[str], evaluations: int = 25) -> FitMethod:
    return FitMethod(label, fixed, ["panes"], SIZE, 4, 5.0, evaluations)


def test_views_are_on_a_circle_about_the_target() -> None:
    scene = panes(RED)
    seen = seen_from(scene, 4, 10.0)
    assert seen[0].camera == scene.camera
    around = [np.subtract(item.camera.position, item.camera.target) for item in seen]
    angles = [math.degrees(math.acos(arm @ around[0] / 9)) for arm in around[1:]]
    assert angles == pytest.approx([10, 20, 30])
    with pytest.raises(UsageError, match="has no views to hold out"):
        seen_from(scene_of(random_lists(2)), 4, 10.0)


def test_errors_are_those_of_displayed_pictures_of_every_other_view(device: Device) -> None:
    seen = seen_from(panes(RED, GREEN, half=0.7), 4, 20.0)
    chosen, exact = method("weighted_average"), collection().truth()
    squares = []
    for item in seen:
        pictures = [render(device, item, one, size=SIZE) for one in (chosen, exact)]
        found, truth = (files.to_srgb(picture, item.exposure) for picture in pictures)
        squares.append(np.mean((found - truth) ** 2))
    assert abs(squares[0] + squares[2] - squares[1] - squares[3]) > 0.01 * sum(squares)
    with Views(device, seen, exact, SIZE) as views:
        assert views.training(chosen) == pytest.approx((squares[0] + squares[2]) / 2, rel=1e-4)
        assert views.held_out(chosen) == pytest.approx((squares[1] + squares[3]) / 2, rel=1e-4)
        assert views.training(exact) == 0


def fitted(device: Device, scene: Scene, asked: FitMethod) -> Fitted:
    seen = seen_from(scene, asked.views, asked.degrees)
    with Views(device, seen, collection().truth(), SIZE) as views:
        return fit(collection(), asked, {"panes": views}, lambda step: None)


def test_a_fit_lowers_the_error_also_on_views_held_out(device: Device) -> None:
    fixed = ["weight", "far_range", "far_power", "near_range"]
    start = "weighted_blended[weight=fitted,near_power=1,near_range=3,far_range=1000,far_power=6]"
    answer = fitted(device, panes(RED, BLUE, GREEN), request(start, fixed))
    (errors,) = answer.errors
    for before, after in (errors.training, errors.held_out):
        assert after < before / 2
    best = method(answer.label)
    assert float(best.values["near_power"]) > 1
    assert [best.values[name] for name in fixed] == [method(start).values[name] for name in fixed]
    assert 3 <= answer.evaluations <= 25


def test_a_method_without_errors_cannot_be_fitted(device: Device) -> None:
    behind = Object("pane", quad((0, 0, 50), (1, 0, 0), (0, 1, 0)), Material(0.6, emission=RED))
    asked = request("hybrid[k=4,node=16f]", ["k", "node"])
    with pytest.raises(SceneError, match="is exact in all views"):
        fitted(device, replace(panes(RED), objects=(behind,)), asked)
