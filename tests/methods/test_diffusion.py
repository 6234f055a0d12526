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
from oitbench.path_traced.optics.materials import spread as path_traced_spread
from oitbench.scene import Material, Object, Scene
from tests.helpers import collection, opened
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
@pytest.mark.parametrize(("k0", "k1"), [(model.K0, model.K1), (0.25, 0.05)])
def test_blur_equals_its_formula(device: Device, collimation: float, k0: float, k1: float) -> None:
    """McGuire & Mara 2017, equation 7."""
    name = with_parameter(f"k0={k0},k1={k1}")
    with opened(device, sheet_scene(frosted(collimation)), name, SIZE) as frame:
        expected = model.blur(FOCAL, collimation, 1.0, 2.0, 4.0, k0, k1)
        np.testing.assert_allclose(blurs(frame), expected, rtol=1e-4)


def edge(collimation: float, behind: float = 4.0) -> Scene:
    """Return a frosted pane 2 m before a wall that is bright on its right half."""
    bright = Object(
        "bright", quad((5, 0, -behind), (5, 0, 0), (0, 5, 0)), Material(emission=(1.0, 1.0, 1.0))
    )
    dark = Object("dark", quad((-5, 0, -behind), (5, 0, 0), (0, 5, 0)), Material())
    pane = sheet_scene(frosted(collimation)).objects[1]
    return Scene("edge", CAMERA, (bright, dark, pane))


def spread(device: Device, scene: Scene, parameter: str, size: tuple[int, int]) -> Image:
    """Return the weights by which an edge is spread over pixels, along one row."""
    with opened(device, scene, with_parameter(f"modulation=none,{parameter}"), size) as frame:
        frame.render()
        row = frame.image()[size[1] // 2, :, 0].astype(np.float64)
    assert row[0] < 1e-6
    assert row[-1] > 1 - 1e-6
    return np.asarray(np.diff(row))


@pytest.mark.parametrize(("kernel", "factor"), [("disk", 1.0), ("gaussian", 1.0), ("listing", 0.5)])
def test_the_deviation_of_a_blur_is_that_of_equation_7(
    device: Device, kernel: str, factor: float
) -> None:
    """That of the published disk is half of it."""
    size = (576, 288)  # the lattice of taps is fine beside a blur of 12 pixels
    weights = spread(device, edge(0.8), f"kernel={kernel},radius=1", size)
    x = np.arange(len(weights))
    mean = (weights * x).sum()
    deviation = np.sqrt((weights * (x - mean) ** 2).sum())
    focal = size[1] / 2 / np.tan(CAMERA.fov_y / 2)
    assert deviation == pytest.approx(factor * model.blur(focal, 0.8, 1.0, 2.0, 4.0), rel=0.03)


@pytest.mark.parametrize("kernel", ["disk", "gaussian", "listing"])
@pytest.mark.parametrize(
    ("parameter", "height", "reach"),
    [
        ("radius=0.1", 60, 6),
        ("radius=0.1", 120, 12),
        ("limit=listing", 96, 16),
        ("limit=listing", 192, 16),
    ],
)
def test_a_blur_ends_at_its_largest_radius(
    device: Device, kernel: str, parameter: str, height: int, reach: int
) -> None:
    weights = spread(device, edge(0.3), f"kernel={kernel},k0=0.8,{parameter}", (3 * height, height))
    (used,) = np.nonzero(weights > 1e-6)
    assert used.max() - used.min() == 2 * reach


def test_blurs_agree_with_the_path_tracer_at_two_and_a_half_meters() -> None:
    """A pane at that distance from the eye, and a background as far behind the pane."""
    for collimation in (0.0, 0.5, 0.9):
        # The deviation of a uniform disk along an axis is half of its radius.
        slope = path_traced_spread(collimation) / 2
        expected = 100.0 * slope * 2.5 / (2.5 + 2.5)
        assert model.blur(100.0, collimation, 1.0, 2.5, 5.0) == pytest.approx(expected)
        # By slopes as in a medium, they agree at all distances.
        for z, gap in ((0.1, 9.0), (1.0, 0.3), (2.5, 2.5)):
            expected = 100.0 * slope * gap / (z + gap)
            assert model.medium_blur(100.0, collimation, z, z + gap) == pytest.approx(expected)
    assert collection().methods["phenomenological"].parameters["k0"].default == model.K0


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
    medium = model.medium_blur(FOCAL, 0.5, 2.0, 4.0) / model.blur(FOCAL, 0.5, 1.0, 2.0, 4.0)
    cases = (
        ("alpha", 1.0, 1.0), ("net", 1.0, 0.25), ("optical", 1.0, medium),
        ("alpha", 0.2, 0.2), ("net", 0.2, 0.05), ("optical", 0.2, medium * np.sqrt(-np.log(0.8))),
    )  # fmt: skip
    for weight, coverage, factor in cases:
        scene = sheet_scene(frosted(0.5, coverage=coverage, transmission=(0.75, 0.75, 0.75)))
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


@pytest.mark.parametrize("kernel", ["disk", "gaussian", "listing"])
def test_blurred_pictures_follow_the_model(device: Device, kernel: str) -> None:
    """A frosted pane that also refracts covers half of the wall of random texels."""
    glass = replace(frosted(0.6, coverage=0.8), index=1.2, solid=True)
    pane = Object("pane", quad((0.15, 0, -0.5), (0.15, 0, 0.05), (0, 0.5, 0)), glass)
    scene = Scene("half", CAMERA, (wall(), pane))
    name = with_parameter(f"modulation=none,kernel={kernel},radius=0.5")
    with opened(device, scene, name, SIZE) as frame:
        frame.render()
        found, opaque = frame.image().astype(np.float64), frame.read("opaque_color")[..., :3]
        beta, delta = frame.read("beta"), frame.read("delta").astype(np.float64) * (1, -1)
    spread = np.sqrt(beta[..., 3].astype(np.float64))
    expected = beta[..., :3] * model.gather(
        opaque.astype(np.float64), spread, delta, radius=0.5 * SIZE[1], kernel=kernel
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
