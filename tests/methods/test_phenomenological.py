"""The phenomenological method against its float64 model, stage by stage; its published sizes."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.gl.frame import Frame, Image
from oitbench.matrix.picture import render as picture
from oitbench.measure.accounting import memory
from oitbench.measure.oracle import transmittances
from oitbench.modeling.mesh import quad, sphere
from oitbench.scene import WHITE, Camera, Material, Object, Scene, Texture
from tests.helpers import (
    BACKGROUND,
    Layer,
    opened,
    random_lists,
    render,
    scene_of,
    stack,
)
from tests.models import phenomenological as model

SIZE = (48, 40)
CAMERA = Camera(position=(0, 0, 0), target=(0, 0, -1), fov_y=math.radians(40))
FLOAT = "phenomenological[precision=float]"
CLEAR = Material(transmission=WHITE, specular=0.0)


def wall(z: float = 4.0) -> Object:
    """Return a wall that fills the view with random texels."""
    texels = np.random.default_rng(3).random((32, 32, 3), dtype=np.float32)
    half = 1.3 * z * math.tan(CAMERA.fov_y / 2)
    emission = Material(emission=Texture(texels))
    return Object("wall", quad((0, 0, -z), (half, 0, 0), (0, half, 0)), emission)


def before_wall(
    material: Material, z: float = 2.0, behind: float = 4.0, tilt: float = 0.0
) -> Scene:
    """Return a sheet that fills the view, turned about the y axis by `tilt` radians."""
    half = 2.0 * z
    right = (half * math.cos(tilt), 0.0, half * math.sin(tilt))
    sheet = Object("sheet", quad((0, 0, -z), right, (0, half, 0)), material)
    return Scene("sheet", CAMERA, (wall(behind), sheet))


def focal(size: tuple[int, int] = SIZE) -> float:
    return size[1] / 2 / math.tan(CAMERA.fov_y / 2)


def rays(size: tuple[int, int] = SIZE) -> npt.NDArray[np.float64]:
    """Return directions through pixel centers with z = -1, (h, w, 3), top row first."""
    x = (np.arange(size[0]) + 0.5 - size[0] / 2) / focal(size)
    y = (size[1] / 2 - np.arange(size[1]) - 0.5) / focal(size)
    return np.stack([*np.meshgrid(x, y), -np.ones((size[1], size[0]))], axis=-1)


def read(frame: Frame, name: str) -> Image:
    frame.render()
    return frame.read(name)


@pytest.mark.parametrize("modulation", ["none", "i3d", "tvcg"])
@pytest.mark.parametrize("equation", ["eq5", "g3d"])
def test_lists_equal_the_model(device: Device, modulation: str, equation: str) -> None:
    lists = random_lists(8, tinted=True)
    name = f"phenomenological[precision=float,modulation={modulation},depth_weight={equation}]"
    expected = model.composite(lists, BACKGROUND, modulation, equation)
    np.testing.assert_allclose(render(device, lists, name), expected, rtol=0, atol=1e-4)


def test_beta_is_exact_and_orderless(device: Device) -> None:
    lists = random_lists(12, tinted=True)
    dark = replace(lists, radiance=np.zeros_like(lists.radiance))
    expected = np.asarray(BACKGROUND) * transmittances(lists).prod(axis=0)
    for seed in (None, 1, 2):
        found = render(device, dark, FLOAT, permutation=seed)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-5)


def test_gray_layers_of_one_kind_are_exact(device: Device) -> None:
    layer = Layer(3.0, 0.3, (0.9, 0.5, 0.1), (0.2, 0.2, 0.2))
    for count in (1, 7):
        lists = stack([layer] * count)
        passed = (1 - 0.3 * 0.8) ** count
        mean = np.multiply(layer.radiance, 1 / 0.8)  # a layer's light is alpha L, not o L
        expected = mean * (1 - passed) + np.multiply(BACKGROUND, passed)
        found = render(device, lists, FLOAT)
        np.testing.assert_allclose(found, np.broadcast_to(expected, found.shape), atol=1e-5)


@pytest.mark.parametrize("depth", [0.3, 1.0])
def test_opaque_layers_keep_their_brightness_by_the_later_formula(
    device: Device, depth: float
) -> None:
    lists = stack([Layer(depth, 1.0, (0.8, 0.4, 0.2))])
    for modulation, factor in (("none", 1.0), ("tvcg", 1.0), ("i3d", 0.5)):
        name = f"phenomenological[precision=float,modulation={modulation}]"
        expected = factor * np.array([0.8, 0.4, 0.2])
        np.testing.assert_allclose(render(device, lists, name)[0, 0], expected, atol=1e-5)


def test_colored_glass_tints_its_own_reflection(device: Device) -> None:
    """A known failure, as published: red glass with a white reflection of 0.1 shows no red."""
    lists = stack([Layer(2.0, 1.0, (0.1, 0.1, 0.1), (1.0, 0.0, 0.0))])
    scene = scene_of(lists, (0.0, 0.0, 0.0))
    plain = render(device, scene, "phenomenological[precision=float,modulation=none]")
    np.testing.assert_allclose(plain[0, 0], (0, 0.15, 0.15), atol=1e-5)
    modulated = render(device, scene, "phenomenological[precision=float,modulation=i3d]")
    np.testing.assert_allclose(modulated[0, 0], (0, 0.075, 0.075), atol=1e-5)


# figure 7


def test_colored_bars_match_sorted_two_pass() -> None:
    scene, size = "glass_bars[reflection=0]", (192, 192)
    pictures = {
        name: picture(scene, name, size, ssaa=1)[0]
        for name in ("sorted_two_pass", "phenomenological", "weighted_blended")
    }
    truth = pictures["sorted_two_pass"]
    assert abs(pictures["phenomenological"] - truth).max() <= 2 / 255
    assert abs(pictures["weighted_blended"] - truth).max() > 0.5
    assert abs(pictures["weighted_blended"] - truth).mean() > 0.02


# refraction


@pytest.mark.parametrize("tilt", [0.0, 0.4, -0.7])
@pytest.mark.parametrize("index", [1.31, 1.5, 2.4])
def test_offsets_follow_snell(device: Device, tilt: float, index: float) -> None:
    scene = before_wall(replace(CLEAR, index=index, solid=True), tilt=tilt)
    with opened(device, scene, f"{FLOAT[:-1]},reach=paper]", SIZE) as frame:
        found = read(frame, "delta").astype(np.float64) * (1, -1)  # rows run down
    ray = rays()
    normal = np.array([-math.sin(tilt), 0, math.cos(tilt)])
    position = ray * (-2.0 * normal[2] / (ray @ normal))[..., None]
    toward_eye = -ray / np.linalg.norm(ray, axis=-1, keepdims=True)
    direction = model.bent(toward_eye, np.broadcast_to(normal, ray.shape), 1 / index)
    # Back from the offset to the bent direction: its plane lies 2 m behind the surface.
    shifted = ray[..., :2] + found * (1, -1) / focal()
    target = np.concatenate([shifted, -np.ones((*ray.shape[:2], 1))], axis=-1)
    target *= 2.0 - position[..., 2:]
    recovered = target - position
    recovered /= np.linalg.norm(recovered, axis=-1, keepdims=True)
    np.testing.assert_allclose(recovered, direction, rtol=0, atol=1e-5)
    sines = [np.linalg.norm(np.cross(d, normal), axis=-1) for d in (recovered, toward_eye)]
    np.testing.assert_allclose(sines[0], sines[1] / index, rtol=0, atol=1e-5)


def test_no_index_and_no_tilt_bend_nothing(device: Device) -> None:
    forced = Effect.COVERAGE | Effect.REFRACTION
    with opened(device, before_wall(CLEAR, tilt=0.5), FLOAT, SIZE, effects=forced) as frame:
        assert not read(frame, "delta").any()
    # A sphere round the eye: every ray meets it head on.
    glass = replace(CLEAR, index=1.5, solid=True)
    bubble = Object("bubble", sphere((0, 0, 0), 2.0, 96, 48), glass)
    with opened(device, Scene("bubble", CAMERA, (wall(), bubble)), FLOAT, SIZE) as frame:
        assert abs(read(frame, "delta")).max() < 1e-3


def test_rays_bend_toward_the_background_or_two_meters(device: Device) -> None:
    glass = replace(CLEAR, index=1.5, solid=True)
    offsets = {}
    for behind in (3.0, 5.0):
        for reach in ("background", "paper"):
            scene = before_wall(glass, z=2.0, behind=behind, tilt=0.5)
            with opened(device, scene, f"{FLOAT[:-1]},reach={reach}]", SIZE) as frame:
                offsets[behind, reach] = read(frame, "delta")
    np.testing.assert_array_equal(offsets[3.0, "paper"], offsets[5.0, "paper"])
    assert abs(offsets[3.0, "background"]).max() < abs(offsets[5.0, "background"]).max()


@pytest.mark.parametrize("offset", ["alpha", "net", "normalized"])
def test_offsets_are_weighted_as_asked(device: Device, offset: str) -> None:
    glass = Material(
        coverage=0.5, transmission=(0.6, 0.6, 0.6), specular=0.0, index=1.5, solid=True
    )
    values = {}
    for coverage in (0.5, 1.0):
        scene = before_wall(replace(glass, coverage=coverage), tilt=0.4)
        with opened(device, scene, f"{FLOAT[:-1]},offset={offset}]", SIZE) as frame:
            delta = read(frame, "delta")
            values[coverage] = delta / frame.read("bending") if offset == "normalized" else delta
    part = {"alpha": 0.5, "net": 0.5, "normalized": 1.0}[offset]
    np.testing.assert_allclose(values[0.5], part * values[1.0], rtol=1e-5)
    scale = {"alpha": 1.0, "net": 0.4, "normalized": 1.0}[offset]
    with opened(device, before_wall(replace(glass, coverage=1.0), tilt=0.4), FLOAT, SIZE) as frame:
        np.testing.assert_allclose(values[1.0], scale * read(frame, "delta"), rtol=1e-4)


# diffusion


def frosted(collimation: float, **more: Any) -> Material:
    return replace(CLEAR, collimation=collimation, **more)


def blurs(frame: Frame) -> Image:
    return np.asarray(np.sqrt(read(frame, "beta")[..., 3]))


@pytest.mark.parametrize("collimation", [0.9, 0.25, 0.0])
def test_blur_follows_equation_seven(device: Device, collimation: float) -> None:
    with opened(device, before_wall(frosted(collimation)), FLOAT, SIZE) as frame:
        expected = model.blur(focal(), collimation, 1.0, 2.0, 4.0)
        np.testing.assert_allclose(blurs(frame), expected, rtol=1e-4)


def test_blur_vanishes_where_the_background_touches(device: Device) -> None:
    near, far = [], []
    for gap in (1e-4, 1e-2, 0.5, 2.0, 50.0):
        scene = before_wall(frosted(0.5), z=2.0, behind=2.0 + gap)
        with opened(device, scene, FLOAT, SIZE) as frame:
            near.append(float(blurs(frame).max()))
            far.append(float(model.blur(focal(), 0.5, 1.0, 2.0, 2.0 + gap)))
    np.testing.assert_allclose(near, far, rtol=5e-3, atol=1e-4)
    assert near == sorted(near)
    assert near[0] < 2e-3


def test_clear_glass_does_not_blur(device: Device) -> None:
    forced = Effect.COVERAGE | Effect.DIFFUSION
    with opened(device, before_wall(CLEAR), FLOAT, SIZE, effects=forced) as frame:
        assert not blurs(frame).any()


def test_variances_add(device: Device) -> None:
    scene = before_wall(frosted(0.5))
    second = Object("second", quad((0, 0, -3.0), (9, 0, 0), (0, 9, 0)), frosted(0.2, coverage=0.5))
    with opened(device, replace(scene, objects=(*scene.objects, second)), FLOAT, SIZE) as frame:
        parts = [model.blur(focal(), 0.5, 1.0, 2.0, 4.0), model.blur(focal(), 0.2, 0.5, 3.0, 4.0)]
        np.testing.assert_allclose(blurs(frame), np.hypot(*parts), rtol=1e-4)


def test_clear_frosted_glass_blurs_by_coverage_alone(device: Device) -> None:
    for weight, factor in (("alpha", 1.0), ("net", 0.25)):
        scene = before_wall(frosted(0.5, transmission=(0.75, 0.75, 0.75)))
        with opened(device, scene, f"{FLOAT[:-1]},weight={weight}]", SIZE) as frame:
            expected = factor * model.blur(focal(), 0.5, 1.0, 2.0, 4.0)
            np.testing.assert_allclose(blurs(frame), expected, rtol=1e-4)


def test_half_the_resolution_halves_blur_and_offset(device: Device) -> None:
    glass = replace(frosted(0.5), index=1.5, solid=True)
    found = []
    for size in (SIZE, (2 * SIZE[0], 2 * SIZE[1])):
        with opened(device, before_wall(glass, tilt=0.3), FLOAT, size) as frame:
            blur, delta = blurs(frame), frame.read("delta")
        scale = size[0] // SIZE[0]
        shape = (SIZE[1], scale, SIZE[0], scale, -1)
        found.append([x.reshape(shape).mean(axis=(1, 3)) / scale for x in (blur, delta)])
    for small, large in zip(*found, strict=True):
        np.testing.assert_allclose(small, large, rtol=2e-3, atol=1e-3)


@pytest.mark.parametrize("kernel", ["disk", "gaussian"])
def test_the_blurred_picture_equals_the_model(device: Device, kernel: str) -> None:
    """A frosted pane over half of the view, bending as well, before random texels."""
    glass = replace(frosted(0.6, coverage=0.8), index=1.2, solid=True)
    pane = Object("pane", quad((0.15, 0, -0.5), (0.15, 0, 0.05), (0, 0.5, 0)), glass)
    scene = Scene("half", CAMERA, (wall(), pane))
    name = f"phenomenological[precision=float,modulation=none,kernel={kernel}]"
    with opened(device, scene, name, SIZE) as frame:
        frame.render()
        found, opaque = frame.image().astype(np.float64), frame.read("opaque_color")[..., :3]
        beta, delta = frame.read("beta"), frame.read("delta").astype(np.float64) * (1, -1)
    spread = np.sqrt(beta[..., 3].astype(np.float64))
    expected = beta[..., :3] * model.gather(
        opaque.astype(np.float64), spread, delta, radius=16, kernel=kernel
    )
    assert spread.max() > 6
    # A tap at the very rim of the disk may fall either side by rounding.
    close = np.isclose(found, expected, rtol=0, atol=1e-4).all(axis=-1)
    assert close.mean() > 0.98
    assert abs(found - expected).max() < 0.05


def test_what_stands_before_a_frosted_pane_stays_sharp(device: Device) -> None:
    bar = Object(
        "bar", quad((0, 0, -1.5), (0.1, 0, 0), (0, 2, 0)), Material(emission=(9.0, 0.0, 0.0))
    )
    scene = before_wall(frosted(0.2))
    scene = replace(scene, objects=(*scene.objects, bar))
    with opened(device, scene, FLOAT, SIZE) as frame:
        frame.render()
        found, opaque = frame.image(), frame.read("opaque_color")[..., :3]
    bar_pixels = opaque[..., 0] > 5
    assert 0 < bar_pixels.sum() < bar_pixels.size / 2
    np.testing.assert_allclose(found[bar_pixels], opaque[bar_pixels], rtol=1e-6)
    assert found[~bar_pixels].max() < 1.01


# sizes and grace


@pytest.mark.parametrize(
    ("effects", "bits", "targets"),
    [
        (Effect.COVERAGE, 88, {"accum", "beta"}),
        (Effect.COVERAGE | Effect.DIFFUSION, 96, {"accum", "beta"}),
        (Effect.COVERAGE | Effect.REFRACTION, 104, {"accum", "beta", "delta"}),
        (
            Effect.COVERAGE | Effect.REFRACTION | Effect.DIFFUSION,
            112,
            {"accum", "beta", "delta"},
        ),
    ],
)
def test_a_pixel_has_the_published_bits(
    device: Device, effects: Effect, bits: int, targets: set[str]
) -> None:
    with opened(device, before_wall(CLEAR), "phenomenological", SIZE, effects=effects) as frame:
        account = memory(frame)
    assert account.bits_per_pixel == bits
    assert {term.resource for term in account.terms} == targets


@pytest.mark.parametrize("precision", ["paper", "half", "float"])
@pytest.mark.parametrize(
    "material",
    [
        Material(coverage=1.0, transmission=WHITE, index=1.0, collimation=0.0),
        Material(coverage=1.0, transmission=WHITE, index=1.5, collimation=0.0, solid=True),
        Material(coverage=1e-7, transmission=WHITE, index=2.4, solid=True, roughness=0.0),
        Material(coverage=0.999, emission=(6e4, 6e4, 6e4), collimation=0.5),
    ],
)
def test_extreme_constants_stay_finite(device: Device, precision: str, material: Material) -> None:
    name = f"phenomenological[precision={precision}]"
    on_near_plane = before_wall(material, z=CAMERA.near * (1 + 1e-6))
    inside = Scene(
        "inside", CAMERA, (wall(), Object("ball", sphere((0, 0, 0), 1.0, 24, 12), material))
    )
    everything = Effect.COVERAGE | Effect.REFRACTION | Effect.DIFFUSION
    for scene in (on_near_plane, inside, before_wall(material, tilt=1.5)):
        with opened(device, scene, name, SIZE, effects=everything) as frame:
            frame.render()
            found = frame.image()
        assert np.isfinite(found).all()
        assert (found >= 0).all()
