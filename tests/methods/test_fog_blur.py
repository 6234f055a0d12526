"""Blur by fog, and fog in blocks of pixels."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.modeling.mesh import quad
from oitbench.scene import (
    WHITE,
    EnvironmentLight,
    Material,
    Object,
    Scene,
    sample_density,
)
from tests.helpers import opened, render
from tests.methods.foggy import (
    AMBIENT,
    FAR_CAMERA,
    FLOAT,
    FOG,
    HIGH,
    LOW,
    SIZE,
    STEPS,
    foggy,
    moved_bytes,
    targets,
    wall,
)
from tests.models import fog as model
from tests.models import phenomenological


@pytest.mark.parametrize("count", [STEPS, 40])
def test_fog_blurs_as_much_as_any_number_of_planes(device: Device, count: int) -> None:
    """The view is so narrow that all rays are parallel to its axis."""
    medium = replace(FOG, collimation=0.3)
    scene = foggy(medium, (EnvironmentLight(AMBIENT),), camera=FAR_CAMERA)
    slices = model.march(FAR_CAMERA, medium, SIZE, count, behind=3.0)
    material = Material(
        coverage=float(slices.coverage[0, 0, 0]),
        emission=tuple(np.multiply(medium.albedo, AMBIENT)),
        collimation=0.3,
    )
    sheets = [
        Object(f"sheet {z}", quad((0, 0, -z), (1, 0, 0), (0, 1, 0)), material)
        for z in slices.z[:, 0, 0].tolist()
    ]
    planes = Scene("planes", FAR_CAMERA, (wall(), *sheets))
    name = f"phenomenological[precision=float,weight=optical,steps={count}]"
    found, expected = targets(device, scene, name), targets(device, planes, name)
    assert expected[1][..., 3].min() > 1
    np.testing.assert_allclose(found[0], expected[0], rtol=1e-4)
    np.testing.assert_allclose(found[1], expected[1], rtol=1e-4)
    few = targets(device, scene)
    np.testing.assert_allclose(few[1][..., 3], expected[1][..., 3], rtol=0.02)


@pytest.mark.parametrize("steps", [16, 64, 512])
def test_the_blur_of_fog_does_not_depend_on_the_number_of_steps(device: Device, steps: int) -> None:
    """Variance is an integral over optical depth."""
    scene = foggy(replace(FOG, collimation=0.3), camera=FAR_CAMERA)
    name = f"phenomenological[precision=float,steps={steps}]"
    found = targets(device, scene, name)[1][..., 3]
    count = 20000
    z = 0.8 + (np.arange(count) + 0.5) * (3.0 - 0.8) / count
    focal = SIZE[1] / 2 / math.tan(FAR_CAMERA.fov_y / 2)
    density = phenomenological.medium_blur(focal, 0.3, z, 3.0) ** 2
    expected = (density * FOG.extinction * (3.0 - 0.8) / count).sum()
    np.testing.assert_allclose(found, expected, rtol=5e-3)


def test_weak_blur_of_fog_is_stored_in_8_bits(device: Device) -> None:
    """The least one of an 8-bit variance is 63/sqrt(255) pixels."""
    for collimation, least in ((0.99, 1 / 255), (1.0, 0.0)):
        scene = foggy(replace(FOG, collimation=collimation))
        effects = scene.effects | Effect.DIFFUSION
        _, beta = targets(device, scene, "phenomenological", effects=effects)
        np.testing.assert_array_equal(beta[..., 3], np.float32(least))


def coarse(steps: int = STEPS) -> str:
    return f"phenomenological[precision=float,steps={steps},subsample=4]"


@pytest.mark.parametrize("size", [(64, 48), (67, 50)])
def test_fog_can_be_marched_once_per_block(device: Device, size: tuple[int, int]) -> None:
    """The center of a block is that of its middle pixels; 67 and 50 pixels end within a block."""
    density = sample_density(
        lambda p: np.maximum(1 + 0.5 * p[..., 0] - 0.3 * p[..., 1], 0), LOW, HIGH, (65, 65, 2)
    )
    scene = foggy(replace(FOG, density=density, collimation=0.3), (EnvironmentLight(AMBIENT),))
    passed = {}
    for name in (coarse(512), coarse(512).replace("subsample=4", "subsample=1")):
        with opened(device, scene, name, size) as frame:
            frame.render()
            small = "subsample=4" in name
            passed[small] = frame.read("small_beta" if small else "beta")[::-1]
            assert "small_depth" not in frame.plan.targets
    rows, columns = size[1] // 4, size[0] // 4
    blocks = passed[False][: 4 * rows, : 4 * columns].reshape(rows, 4, columns, 4, 4)
    expected = blocks[:, 1:3, :, 1:3].mean(axis=(1, 3))
    assert np.ptp(expected[..., 0]) > 0.1
    # Half a pixel's shift changes transmittances by more.
    np.testing.assert_allclose(passed[True][:rows, :columns, :3], expected[..., :3], atol=1e-3)
    np.testing.assert_allclose(passed[True][:rows, :columns, 3], expected[..., 3], rtol=1e-2)


def test_coarse_fog_and_particles_share_their_blocks(device: Device) -> None:
    puff = Object(
        "puff",
        quad((0, 0, -2.0), (9, 0, 0), (0, 9, 0)),
        Material(coverage=0.4, emission=(0.2, 0.3, 0.5)),
        particles=True,
    )
    scene = foggy(lights=(EnvironmentLight(AMBIENT),), objects=(puff,), camera=FAR_CAMERA)
    full, blocks = (render(device, scene, name, size=SIZE) for name in (FLOAT, coarse()))
    np.testing.assert_allclose(blocks, full, atol=1e-5)


def test_coarse_fog_ends_at_the_surface_behind_each_block(device: Device) -> None:
    near = Object("near", quad((-9.0, 0, -1.5), (9, 0, 0), (0, 9, 0)), Material(emission=WHITE))
    scene = foggy(objects=(near,), camera=FAR_CAMERA)
    full, blocks = (render(device, scene, name, size=SIZE) for name in (FLOAT, coarse()))
    assert np.ptp(full[..., 0]) > 0.1
    np.testing.assert_allclose(blocks, full, atol=0.005)


def test_coarse_fog_is_blended_once_per_block(device: Device) -> None:
    blocks = 5 * 4
    with opened(device, foggy(), "phenomenological[subsample=4]", SIZE) as frame:
        moved = moved_bytes(frame, "fog small=1")
    assert moved == {"blend": 11 * blocks, "write": 11 * blocks, "read": 4 * blocks}


def test_without_fog_and_particles_there_are_no_blocks(device: Device) -> None:
    without = foggy().effects & ~Effect.VOLUME
    for scene, effects in ((foggy(), without), (foggy(None), foggy(None).effects)):
        with opened(device, scene, coarse(), SIZE, effects=effects) as frame:
            assert not [name for name in frame.plan.targets if name.startswith("small_")]
            assert [step.name for step in frame.plan.passes] == ["gather", "resolve"]
