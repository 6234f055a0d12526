"""Diffusion by phenomenological transparency: blur of the background."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.gl.frame import Frame, Image
from oitbench.modeling.mesh import quad
from oitbench.scene import Material, Object, Scene
from tests.helpers import opened
from tests.methods.sheets import (
    CAMERA,
    CLEAR,
    FLOAT,
    FOCAL,
    SIZE,
    read,
    sheet_scene,
    wall,
    with_parameter,
)
from tests.models import phenomenological as model


def frosted(collimation: float, **more: Any) -> Material:
    return replace(CLEAR, collimation=collimation, **more)


def blurs(frame: Frame) -> Image:
    return np.asarray(np.sqrt(read(frame, "beta")[..., 3]))


@pytest.mark.parametrize("collimation", [0.9, 0.25, 0.0])
def test_blur_equals_its_formula(device: Device, collimation: float) -> None:
    """McGuire & Mara 2017, equation 7."""
    with opened(device, sheet_scene(frosted(collimation)), FLOAT, SIZE) as frame:
        expected = model.blur(FOCAL, collimation, 1.0, 2.0, 4.0)
        np.testing.assert_allclose(blurs(frame), expected, rtol=1e-4)


def test_blur_vanishes_where_the_background_touches_the_glass(device: Device) -> None:
    near, far = [], []
    for gap in (1e-4, 1e-2, 0.5, 2.0, 50.0):
        scene = sheet_scene(frosted(0.5), z=2.0, behind=2.0 + gap)
        with opened(device, scene, FLOAT, SIZE) as frame:
            near.append(float(blurs(frame).max()))
            far.append(float(model.blur(FOCAL, 0.5, 1.0, 2.0, 2.0 + gap)))
    np.testing.assert_allclose(near, far, rtol=5e-3, atol=1e-4)
    assert near == sorted(near)
    assert near[0] < 2e-3


def test_clear_glass_does_not_blur(device: Device) -> None:
    forced = Effect.COVERAGE | Effect.DIFFUSION
    with opened(device, sheet_scene(CLEAR), FLOAT, SIZE, effects=forced) as frame:
        assert not blurs(frame).any()


def test_variances_of_layers_add(device: Device) -> None:
    scene = sheet_scene(frosted(0.5))
    second = Object("second", quad((0, 0, -3.0), (9, 0, 0), (0, 9, 0)), frosted(0.2, coverage=0.5))
    with opened(device, replace(scene, objects=(*scene.objects, second)), FLOAT, SIZE) as frame:
        parts = [model.blur(FOCAL, 0.5, 1.0, 2.0, 4.0), model.blur(FOCAL, 0.2, 0.5, 3.0, 4.0)]
        np.testing.assert_allclose(blurs(frame), np.hypot(*parts), rtol=1e-4)


def test_blur_is_weighted_by_the_chosen_rule(device: Device) -> None:
    for weight, factor in (("alpha", 1.0), ("net", 0.25)):
        scene = sheet_scene(frosted(0.5, transmission=(0.75, 0.75, 0.75)))
        with opened(device, scene, with_parameter(f"weight={weight}"), SIZE) as frame:
            expected = factor * model.blur(FOCAL, 0.5, 1.0, 2.0, 4.0)
            np.testing.assert_allclose(blurs(frame), expected, rtol=1e-4)


def test_half_the_resolution_halves_blur_and_offset(device: Device) -> None:
    glass = replace(frosted(0.5), index=1.5, solid=True)
    found = []
    for size in (SIZE, (2 * SIZE[0], 2 * SIZE[1])):
        with opened(device, sheet_scene(glass, tilt=0.3), FLOAT, size) as frame:
            blur, delta = blurs(frame), frame.read("delta")
        scale = size[0] // SIZE[0]
        shape = (SIZE[1], scale, SIZE[0], scale, -1)
        found.append([x.reshape(shape).mean(axis=(1, 3)) / scale for x in (blur, delta)])
    for small, large in zip(*found, strict=True):
        np.testing.assert_allclose(small, large, rtol=2e-3, atol=1e-3)


@pytest.mark.parametrize("kernel", ["disk", "gaussian"])
def test_blurred_pictures_follow_the_model(device: Device, kernel: str) -> None:
    """A frosted pane that also refracts covers half of the wall of random texels."""
    glass = replace(frosted(0.6, coverage=0.8), index=1.2, solid=True)
    pane = Object("pane", quad((0.15, 0, -0.5), (0.15, 0, 0.05), (0, 0.5, 0)), glass)
    scene = Scene("half", CAMERA, (wall(), pane))
    name = with_parameter(f"modulation=none,kernel={kernel}")
    with opened(device, scene, name, SIZE) as frame:
        frame.render()
        found, opaque = frame.image().astype(np.float64), frame.read("opaque_color")[..., :3]
        beta, delta = frame.read("beta"), frame.read("delta").astype(np.float64) * (1, -1)
    spread = np.sqrt(beta[..., 3].astype(np.float64))
    expected = beta[..., :3] * model.gather(
        opaque.astype(np.float64), spread, delta, radius=16, kernel=kernel
    )
    assert spread.max() > 6
    # Rounding decides whether taps at the rim of the disk count.
    close = np.isclose(found, expected, rtol=0, atol=1e-4).all(axis=-1)
    assert close.mean() > 0.98
    assert abs(found - expected).max() < 0.05


def test_objects_in_front_of_a_frosted_pane_stay_sharp(device: Device) -> None:
    bar = Object(
        "bar", quad((0, 0, -1.5), (0.1, 0, 0), (0, 2, 0)), Material(emission=(9.0, 0.0, 0.0))
    )
    scene = sheet_scene(frosted(0.2))
    scene = replace(scene, objects=(*scene.objects, bar))
    with opened(device, scene, FLOAT, SIZE) as frame:
        frame.render()
        found, opaque = frame.image(), frame.read("opaque_color")[..., :3]
    bar_pixels = opaque[..., 0] > 5
    assert 0 < bar_pixels.sum() < bar_pixels.size / 2
    np.testing.assert_allclose(found[bar_pixels], opaque[bar_pixels], rtol=1e-6)
    assert found[~bar_pixels].max() < 1.01
