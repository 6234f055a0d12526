"""Ray-marched fog against planes, closed forms and a model in double precision."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest

from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.measure.oracle import composite
from oitbench.modeling.mesh import quad
from oitbench.scene import (
    RGB,
    WHITE,
    Array,
    Camera,
    DirectionalLight,
    EnvironmentLight,
    Floats,
    FragmentLists,
    Light,
    Material,
    Medium,
    Object,
    Scene,
    SpotLight,
    sample_density,
)
from tests.helpers import BACKGROUND, opened, render
from tests.methods.foggy import (
    AMBIENT,
    CAMERA,
    FAR_CAMERA,
    FLOAT,
    FOG,
    HIGH,
    LAMP,
    LOW,
    SIZE,
    STEPS,
    SUN,
    foggy,
    moved_bytes,
    targets,
)
from tests.models import fog as model
from tests.models import phenomenological
from tests.models.view import rays

RAMP = sample_density(lambda p: 0.5 + 0.1 * p[..., 0] - 0.15 * p[..., 2], LOW, HIGH, (5, 4, 3))


def sums(slices: model.Slices) -> tuple[Floats, Floats]:
    """Return the sum of weighted layers (h, w, 4) and the transmittance (h, w)."""
    depth = 1 - CAMERA.near / slices.z
    weight = phenomenological.depth_weight(slices.coverage, depth) * slices.coverage
    light = np.concatenate([slices.radiance, np.ones((*slices.z.shape, 1))], axis=-1)
    return (weight[..., None] * light).sum(axis=0), (1 - slices.coverage).prod(axis=0)


def of_filters(device: Device) -> float:
    """Return the relative error of densities of `RAMP` between cells.

    GPUs round the weights of linear filters to 8 bits. Light is weighted by coverage twice.
    """
    if device.software:
        return 0.0
    steps = sum(float(abs(np.diff(RAMP, axis=axis)).max()) for axis in range(3))
    return 2 * steps * 2.0**-9 / float(RAMP.min())


def passed(scene: Scene) -> Floats:
    """Return the transmittance of the fog of `scene`, in closed form for a constant density."""
    assert scene.medium is not None
    (only,) = model.march(scene.camera, scene.medium, SIZE, 1, behind=3.0).coverage
    return np.asarray(1 - only)


@pytest.mark.parametrize("g", [-0.7, 0.0, 0.3, 0.9])
def test_the_phase_function_is_normalized(g: float) -> None:
    cosine, weight = np.polynomial.legendre.leggauss(200)
    total = 2 * np.pi * (weight * model.phase(cosine, g)).sum()
    assert total == pytest.approx(1, abs=1e-9)
    mean = 2 * np.pi * (weight * cosine * model.phase(cosine, g)).sum()
    assert mean == pytest.approx(g, abs=1e-9)


@pytest.mark.parametrize(("beams", "bound"), [((), 1e-7), ((SUN,), 1e-7), ((LAMP,), 2e-6)])
def test_the_march_follows_the_model(
    device: Device, beams: tuple[DirectionalLight | SpotLight, ...], bound: float
) -> None:
    """The bound is larger at the rim of a cone: arc cosines of drivers have errors of 1e-4."""
    medium = replace(FOG, density=RAMP)
    scene = foggy(medium, (*beams, EnvironmentLight(AMBIENT)))
    accum, beta = targets(device, scene)
    expected = model.march(CAMERA, medium, SIZE, STEPS, 3.0, beams, AMBIENT)
    total, left = sums(expected)
    rounded = of_filters(device)
    np.testing.assert_allclose(accum, total, rtol=2e-5 + rounded, atol=bound)
    hidden = float(1 - left.min())
    np.testing.assert_allclose(
        beta[..., :3], np.repeat(left[..., None], 3, -1), atol=2e-6 + rounded * hidden
    )


def test_thin_fog_keeps_its_digits(device: Device) -> None:
    """The slices hide less than the last digit of the light that passes them."""
    medium = replace(FOG, extinction=FOG.extinction * 1e-6)
    accum, _ = targets(device, foggy(medium, (EnvironmentLight(AMBIENT),)))
    expected, _ = sums(model.march(CAMERA, medium, SIZE, STEPS, 3.0, (), AMBIENT))
    np.testing.assert_allclose(accum, expected, rtol=2e-5)


def test_fog_equals_a_plane_for_each_step(device: Device) -> None:
    medium = replace(FOG, density=RAMP)
    lights = (LAMP, EnvironmentLight(AMBIENT))
    found = render(device, foggy(medium, lights), FLOAT, size=SIZE)
    slices = model.march(CAMERA, medium, SIZE, STEPS, 3.0, (LAMP,), AMBIENT)
    planes = Scene("planes", CAMERA, lists=slices.lists(), background=BACKGROUND)
    assert found.std(axis=(0, 1)).min() > 0.005
    np.testing.assert_allclose(found, render(device, planes, FLOAT), atol=1e-4)


@pytest.mark.parametrize("light_steps", [1, 3])
def test_varying_fog_dims_beams_in_steps(device: Device, light_steps: int) -> None:
    medium = replace(FOG, density=RAMP)
    name = f"phenomenological[precision=float,steps={STEPS},light_steps={light_steps}]"
    accum, _ = targets(device, foggy(medium, (SUN,)), name)
    expected, _ = sums(
        model.march(CAMERA, medium, SIZE, STEPS, 3.0, (SUN,), light_steps=light_steps)
    )
    other, _ = sums(model.march(CAMERA, medium, SIZE, STEPS, 3.0, (SUN,)))
    np.testing.assert_allclose(accum, expected, rtol=2e-5 + of_filters(device), atol=1e-7)
    assert abs(expected / other - 1).max() > 5e-4


def test_the_longest_march_comes_to_its_end(device: Device) -> None:
    """Drivers end long loops; those toward a light must be short enough to be unrolled."""
    scene = foggy(replace(FOG, density=RAMP), (SUN, LAMP))
    short, long = (
        render(device, scene, f"phenomenological[precision=float,{steps}]", size=SIZE)
        for steps in ("steps=128,light_steps=8", "steps=4096,light_steps=32")
    )
    np.testing.assert_allclose(long.mean(axis=(0, 1)), short.mean(axis=(0, 1)), rtol=1e-3)


def test_uniform_fog_dims_beams_by_its_closed_form(device: Device) -> None:
    """The sun shines straight down into fog whose top is one meter above the line of sight."""
    medium = Medium(0.7, (-5, -5, -3.5), (5, 1, -0.8), albedo=FOG.albedo)
    down = DirectionalLight((0.0, -1.0, 0.0), (3.0, 2.0, 1.0))
    scene = foggy(medium, (down,), camera=FAR_CAMERA)
    found = render(device, scene, FLOAT, size=SIZE)
    left = math.exp(-0.7 * (3.0 - 0.8))
    light = np.multiply(FOG.albedo, down.irradiance) / (4 * math.pi) * math.exp(-0.7)
    expected = np.multiply(BACKGROUND, left) + light * (1 - left)
    np.testing.assert_allclose(found, np.broadcast_to(expected, found.shape), rtol=0.02)


def test_fog_dims_beams_on_their_way_to_surfaces(device: Device) -> None:
    """The fog lies between the lamp and a white wall, but not before the eye."""
    medium = Medium(0.7, (-9, 4, -9), (9, 6, 9))
    down = DirectionalLight((0.0, -1.0, -0.5), (3.0, 2.0, 1.0))
    white = Object("white", quad((0, 0, -3), (9, 0, 0), (0, 9, 0)), Material(albedo=WHITE))
    clear, found = (
        render(
            device, Scene("wall", CAMERA, (white,), lights=(down,), medium=one), FLOAT, size=SIZE
        )
        for one in (None, medium)
    )
    assert clear.min() > 0.1
    np.testing.assert_allclose(found, clear * math.exp(-0.7 * 2 * math.hypot(1, 0.5)), rtol=1e-3)


def test_ambient_light_of_a_medium_replaces_that_of_the_environment(device: Device) -> None:
    brown: RGB = (0.3, 0.2, 0.1)
    scene = foggy(replace(FOG, ambient=brown), (EnvironmentLight(AMBIENT),))
    left = passed(scene)[..., None]
    expected = BACKGROUND * left + np.multiply(FOG.albedo, brown) * (1 - left)
    np.testing.assert_allclose(render(device, scene, FLOAT, size=SIZE), expected, atol=1e-4)
    alone = foggy(replace(FOG, ambient=brown))
    np.testing.assert_allclose(render(device, alone, FLOAT, size=SIZE), expected, atol=1e-4)


@pytest.mark.parametrize("steps", [1, 4, 32])
def test_uniform_fog_equals_its_closed_form(device: Device, steps: int) -> None:
    scene = foggy(lights=(EnvironmentLight(AMBIENT),))
    found = render(device, scene, f"phenomenological[precision=float,steps={steps}]", size=SIZE)
    left = passed(scene)[..., None]
    light = np.multiply(FOG.albedo, AMBIENT)
    assert left.min() < 0.25
    np.testing.assert_allclose(found, BACKGROUND * left + light * (1 - left), atol=1e-4)


def test_half_precision_is_close_to_the_closed_form(device: Device) -> None:
    scene = foggy(lights=(EnvironmentLight(AMBIENT),))
    left = passed(scene)[..., None]
    expected = BACKGROUND * left + np.multiply(FOG.albedo, AMBIENT) * (1 - left)
    # Transmittance in 8 bits, and half floats for all other values.
    for precision, bound in (("half", 3e-3), ("paper", 5e-3)):
        name = f"phenomenological[precision={precision}]"
        np.testing.assert_allclose(render(device, scene, name, size=SIZE), expected, atol=bound)


def test_unlit_fog_absorbs_light(device: Device) -> None:
    scene = foggy()
    assert scene.effects & Effect.VOLUME
    found = render(device, scene, FLOAT, size=SIZE)
    np.testing.assert_allclose(found, BACKGROUND * passed(scene)[..., None], atol=1e-5)


def test_the_transmittance_contains_no_light_of_the_fog(device: Device) -> None:
    scene = foggy(lights=(SUN, EnvironmentLight(AMBIENT)))
    with opened(device, scene, FLOAT, SIZE) as frame:
        frame.render(transmittance=True)
        expected = np.repeat(passed(scene)[..., None], 3, -1)
        np.testing.assert_allclose(frame.image(), expected, atol=1e-5)


@pytest.mark.parametrize("z", [1.0, 5.0])
def test_fog_composes_with_glass(device: Device, z: float) -> None:
    """In front of the fog and in it, transmittances multiply and light adds up."""
    glass = Material(transmission=(0.9, 0.5, 0.2), emission=(0.1, 0.2, 0.3))
    pane = Object("pane", quad((0, 0, -z / 2), (9, 0, 0), (0, 9, 0)), glass)
    lights = (EnvironmentLight(AMBIENT),)
    both = targets(device, foggy(lights=lights, objects=(pane,)))
    fog = targets(device, foggy(lights=lights))
    alone = targets(device, foggy(None, lights, (pane,)))
    np.testing.assert_allclose(both[0], fog[0] + alone[0], rtol=1e-5)
    np.testing.assert_allclose(both[1][..., :3], fog[1][..., :3] * alone[1][..., :3], atol=1e-6)
    assert np.ptp(alone[1][0, 0, :3]) > 0.5


def test_a_sheet_in_fog_keeps_its_own_light(device: Device) -> None:
    """A known failure of one unordered pass, with the right value beside it."""
    emission, transmission = np.array([1.0, 0.2, 0.3]), np.array([0.9, 0.5, 0.2])
    glass = Material(transmission=(0.9, 0.5, 0.2), emission=(1.0, 0.2, 0.3), specular=0.0)
    z, light = 1.9, np.multiply(FOG.albedo, AMBIENT)  # the middle of the fog
    pane = Object("pane", quad((0, 0, -z), (1, 0, 0), (0, 1, 0)), glass)
    scene = foggy(lights=(EnvironmentLight(AMBIENT),), objects=(pane,), camera=FAR_CAMERA)
    half = math.exp(-FOG.extinction * 1.1)
    behind = light * (1 - half) + np.multiply(BACKGROUND, half)
    right = light * (1 - half) + half * (emission + transmission * behind)
    fog = model.march(FAR_CAMERA, FOG, SIZE, STEPS, 3.0, (), AMBIENT).lists()
    shape = (1, SIZE[1], SIZE[0])

    def with_sheet(slices: Array, value: npt.ArrayLike) -> Array:
        sheet = np.broadcast_to(np.asarray(value, dtype=np.float32), shape + slices.shape[3:])
        return np.ascontiguousarray(np.concatenate([slices, sheet]))

    lists = FragmentLists(
        with_sheet(fog.z, z),
        with_sheet(fog.coverage, 1.0),
        with_sheet(fog.radiance, emission),
        with_sheet(fog.transmission, transmission),
    )
    np.testing.assert_allclose(composite(lists, BACKGROUND)[0, 0], right, atol=1e-4)
    expected = phenomenological.composite(lists, BACKGROUND)
    found = render(device, scene, FLOAT, size=SIZE)
    np.testing.assert_allclose(found, expected, atol=1e-4)
    assert abs(found - right).max() > 0.1


def test_fog_ends_at_an_opaque_wall(device: Device) -> None:
    near = Object("near", quad((0, 0, -1.5), (9, 0, 0), (0, 9, 0)), Material(emission=WHITE))
    found = render(device, foggy(objects=(near,)), FLOAT, size=SIZE)
    (only,) = model.march(CAMERA, FOG, SIZE, 1, behind=1.5).coverage
    np.testing.assert_allclose(found, np.repeat(1 - only[..., None], 3, -1), atol=1e-5)


@pytest.mark.parametrize(
    ("low", "high"),
    [
        ((-9, -9, 0.5), (9, 9, 2)),
        ((-9, -9, -9), (9, 9, -3.1)),
        ((9, -9, -3), (10, 9, 0)),
        ((-9, -9, -0.09), (9, 9, 1)),
    ],
    ids=["behind the eye", "behind the wall", "beside the view", "in front of the near plane"],
)
def test_a_box_out_of_view_changes_nothing(device: Device, low: RGB, high: RGB) -> None:
    lights = (SUN, EnvironmentLight(AMBIENT))
    clear = render(device, foggy(None, lights), FLOAT, size=SIZE)
    found = render(device, foggy(Medium(5.0, low, high), lights), FLOAT, size=SIZE)
    np.testing.assert_array_equal(found, clear)


def test_the_camera_can_be_in_the_fog(device: Device) -> None:
    scene = foggy(Medium(0.5, (-9, -9, -9), (9, 9, 9)))
    length = np.linalg.norm(rays(CAMERA, SIZE), axis=-1)
    expected = np.exp(-0.5 * (3.0 - CAMERA.near) * length)[..., None] * BACKGROUND
    np.testing.assert_allclose(render(device, scene, FLOAT, size=SIZE), expected, atol=1e-5)


def test_a_grid_of_one_value_equals_that_density(device: Device) -> None:
    lights = (LAMP, EnvironmentLight(AMBIENT))
    ones, halves = (np.full((3, 4, 5), value, dtype=np.float32) for value in (1.0, 0.5))
    constant = render(device, foggy(lights=lights), FLOAT, size=SIZE)
    full = render(device, foggy(replace(FOG, density=ones), lights), FLOAT, size=SIZE)
    np.testing.assert_array_equal(full, constant)
    thin = render(device, foggy(replace(FOG, extinction=0.35), lights), FLOAT, size=SIZE)
    half = render(device, foggy(replace(FOG, density=halves), lights), FLOAT, size=SIZE)
    np.testing.assert_array_equal(half, thin)
    assert np.abs(half - full).max() > 0.05


@pytest.mark.parametrize("lights", [(), (SUN, EnvironmentLight(AMBIENT))], ids=["dark", "lit"])
def test_a_scene_without_fog_does_not_change(device: Device, lights: tuple[Light, ...]) -> None:
    # The unit box, which is the default of the shader, is in view.
    scene = foggy(None, lights, camera=Camera((0.5, 0.5, 1.5), (0.5, 0.5, 0)))
    plain = render(device, scene, FLOAT, size=SIZE)
    forced = scene.effects | Effect.VOLUME
    found = render(device, scene, FLOAT, size=SIZE, effects=forced)
    np.testing.assert_array_equal(found, plain)


def test_fog_that_is_not_requested_is_not_rendered(device: Device) -> None:
    lights = (SUN, EnvironmentLight(AMBIENT))
    scene = foggy(lights=lights)
    without = scene.effects & ~Effect.VOLUME
    with opened(device, scene, FLOAT, SIZE, effects=without) as frame:
        assert "fog" not in [step.name for step in frame.plan.passes]
        frame.render()
        clear = render(device, foggy(None, lights), FLOAT, size=SIZE)
        np.testing.assert_array_equal(frame.image(), clear)


def test_light_through_a_slit_lights_a_sheet_of_fog(device: Device) -> None:
    """Light through a gap in a roof lights only the fog below the gap."""
    roof = [
        Object(f"roof {x}", quad((x, 3, -10), (1, 0, 0), (0, 0, -3)), Material())
        for x in (-1.2, 1.2)
    ]
    medium = Medium(0.3, (-2, -1, -12), (2, 1, -8), albedo=WHITE, anisotropy=0.4)
    down = DirectionalLight((0, -1, 0), (3.0, 2.0, 1.0))
    camera, size = Camera((0, 0, 0), (0, 0, -1), fov_y=math.radians(1)), (80, 4)
    scene = Scene("slit", camera, tuple(roof), lights=(down,), medium=medium)
    found = render(device, scene, FLOAT, size=size)
    total, left = sums(
        model.march(
            camera, medium, size, STEPS, lights=(down,),
            visibility=lambda points: np.abs(points[..., :1]) < 0.2,
        )
    )  # fmt: skip
    expected = (1 - left[..., None]) * total[..., :3] / np.maximum(total[..., 3:], 1e-5)
    # Only rays on one side of the edge of the shadow, which has the width of a texel.
    x = np.abs(rays(camera, size)[..., 0])
    lit, dark = 12 * x < 0.19, 8 * x > 0.21
    assert lit.sum() > 20
    assert dark.sum() > 100
    np.testing.assert_allclose(found[lit | dark], expected[lit | dark], atol=1e-5)
    assert expected[lit].min() > 0.02
    assert expected[dark].max() == 0


def test_a_colored_pane_tints_the_light_in_the_fog(device: Device) -> None:
    pane = Material(transmission=(1.0, 0.25, 0.0), specular=0.0)
    objects = (
        Object("pane", quad((0, 3, -10), (2, 0, 0), (0, 0, -3)), pane),
        Object("floor", quad((0, -1, -10), (2, 0, 0), (0, 0, -3)), Material(), casts=False),
    )
    medium = Medium(0.3, (-2, -1, -12), (2, 1, -8), albedo=WHITE)
    camera = Camera((0, 0, 0), (0, 0, -1), fov_y=math.radians(3))
    lights = (DirectionalLight((0, -1, 0)),)
    scene = Scene("pane", camera, objects, lights=lights, medium=medium)
    mean = render(device, scene, FLOAT, size=SIZE).mean(axis=(0, 1))
    # A quarter of the green light passes the pane, and no blue light.
    np.testing.assert_allclose(mean / mean[0], (1, 1 / 4, 0), atol=0.002)


def test_fog_is_brighter_toward_the_light(device: Device) -> None:
    """Positive anisotropy scatters forward, toward the eye; thin fog dims both lights alike."""
    bright, thin = {}, replace(FOG, extinction=0.01)
    for z in (1.0, -1.0):
        scene = foggy(thin, (DirectionalLight((0.0, -0.1, z), (50.0, 50.0, 50.0)),))
        bright[z] = render(device, scene, FLOAT, size=SIZE) - BACKGROUND * passed(scene)[..., None]
    ratio = bright[1.0][7, 10, 0] / bright[-1.0][7, 10, 0]
    expected = model.phase(1, FOG.anisotropy) / model.phase(-1, FOG.anisotropy)
    assert ratio == pytest.approx(float(expected), rel=0.1)


def test_neighboring_pixels_sample_different_parts_of_a_slice() -> None:
    part = model.jitter((16, 8))
    blocks = part.reshape(2, 4, 4, 4).swapaxes(1, 2).reshape(8, 16)
    np.testing.assert_allclose(np.diff(np.sort(blocks, axis=-1), axis=-1), 1 / 16, atol=1e-9)
    quarters = part.reshape(4, 2, 8, 2).swapaxes(1, 2).reshape(32, 4)
    np.testing.assert_allclose(np.diff(np.sort(quarters, axis=-1), axis=-1), 1 / 4, atol=1e-9)
    assert len(np.unique(np.round(16 * blocks.min(axis=-1), 6))) == 8


def test_fog_is_blended_once_per_pixel(device: Device) -> None:
    pixels = SIZE[0] * SIZE[1]
    name = "phenomenological[steps=64]"
    with opened(device, foggy(lights=(EnvironmentLight(AMBIENT),)), name, SIZE) as frame:
        moved = moved_bytes(frame, "fog")
    # 64 bits of sums and 24 of transmittance, each read and written; 32 bits of depth are read.
    assert moved == {"blend": 11 * pixels, "write": 11 * pixels, "read": 4 * pixels}
