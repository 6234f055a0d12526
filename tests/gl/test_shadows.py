"""Shadows of opaque, translucent and colored casters, and caustics."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.gl.frame import Image
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.modeling.mesh import quad, sphere
from oitbench.path_traced.matched.render import matched
from oitbench.scene import (
    BLACK,
    RGB,
    Camera,
    DirectionalLight,
    Material,
    Object,
    Scene,
    SpotLight,
    Texture,
)
from oitbench.scene.texturing import constant
from oitbench.shading import OCCLUDERS, PUBLISHED, SLICES, ShadingSettings
from tests.helpers import Empty, opened
from tests.models.shadows import occluder_light, published_light, traced_light
from tests.path_traced.agreement import needs_mitsuba

SIZE = (64, 64)
ABOVE = Camera(position=(0, 6, 0), target=(0, 0, 0), up=(0, 0, -1), fov_y=math.radians(20))
SUN = DirectionalLight((0.0, -1.0, 0.0), (math.pi, math.pi, math.pi))
ALL = Effect.SHADOWS | Effect.TRANSLUCENT_SHADOWS | Effect.COLORED_SHADOWS | Effect.CAUSTICS
WALKER = {1.3: 0.316, 1.5: 0.242, 2.0: 0.129}
"""Fraction of the absorbed light that a solid of this index removes at normal incidence."""


def level(name: str, height: float, half: float, material: Material, **more: Any) -> Object:
    return Object(name, quad((0, height, 0), (half, 0, 0), (0, 0, -half)), material, **more)


FLOOR = level("floor", 0.0, 3.0, Material(albedo=(1, 1, 1)), casts=False)


def under(pane: Material, height: float = 1.0, light: DirectionalLight | SpotLight = SUN) -> Scene:
    """Return a floor, of radiance one where it is lit, below a pane that shades its middle."""
    return Scene("shade", ABOVE, (FLOOR, level("pane", height, 1.5, pane)), lights=(light,))


def lit(
    device: Device, scene: Scene, effects: Effect = ALL, form: str = OCCLUDERS, **more: int
) -> Image:
    """Return the radiance of the opaque surfaces in the middle of the view."""
    settings = ShadingSettings(form, **more)
    running = scene.effects & effects
    with opened(device, scene, Empty(), SIZE, effects=running, settings=settings) as frame:
        frame.render()
        return frame.image()[16:48, 16:48]


def assert_mean(found: Image, mean: npt.ArrayLike, sigmas: float = 4) -> None:
    """Compare means; each texel of the map in view is an independent sample."""
    expected = np.asarray(mean, dtype=np.float64)
    texels = 500**2 / 4
    allowed = sigmas * np.sqrt(np.clip(expected * (1 - expected), 0, None) / texels) + 2e-3
    assert (abs(found.mean(axis=(0, 1)) - expected) <= allowed).all(), found.mean(axis=(0, 1))


@pytest.mark.parametrize("form", [PUBLISHED, OCCLUDERS, SLICES])
@pytest.mark.parametrize("height", [0.05, 0.5, 2.0])
@pytest.mark.parametrize("transmission", [(0.9, 0.5, 0.1), (0.3, 0.3, 0.3)])
def test_the_shadow_of_a_pane_has_its_transmittance_at_any_height(
    device: Device, transmission: RGB, height: float, form: str
) -> None:
    pane = Material(coverage=0.8, transmission=transmission)
    expected = 1 - 0.8 * (1 - np.asarray(transmission))
    assert_mean(lit(device, under(pane, height), form=form), expected)


@pytest.mark.parametrize("index", WALKER)
def test_solids_absorb_less_light_in_their_middle(device: Device, index: float) -> None:
    solid = Material(transmission=(0.5, 0.2, 0.8), specular=0.0, index=index, solid=True)
    removed = WALKER[index] * (1 - np.asarray(solid.transmission))
    assert_mean(lit(device, under(solid)), 1 - removed)
    without = ALL & ~Effect.CAUSTICS
    assert_mean(lit(device, under(solid), without), constant(solid.transmission))


def test_solids_absorb_more_light_at_their_rim(device: Device) -> None:
    glass = Material(transmission=(0.7, 0.7, 0.7), specular=0.0, index=1.5, solid=True)
    ball = Object("ball", sphere((0, 1.2, 0), 0.9, 64, 32), glass)
    scene = Scene("ball", ABOVE, (FLOOR, ball), lights=(SUN,))
    with opened(device, scene, Empty(), SIZE, effects=scene.effects & ALL) as frame:
        frame.render()
        shade = frame.image()[..., 0]
    middle = shade[30:34, 30:34].mean()
    # The shadow of the rim is 0.9 m from the middle of a view 2.1 m wide.
    rim = shade[32, int(32 + 0.84 * 64 / 2.116)]
    assert middle > 0.8
    assert rim < 0.55


def test_the_shadows_of_two_panes_multiply(device: Device) -> None:
    scene = under(Material(transmission=(0.9, 0.4, 0.6)))
    second = level("second", 1.7, 1.5, Material(transmission=(0.5, 0.8, 0.6)))
    found = lit(device, replace(scene, objects=(*scene.objects, second)))
    # Chebyshev's bound is not tight for three depths: at most a tenth of the light leaks.
    expected = np.multiply((0.9, 0.4, 0.6), (0.5, 0.8, 0.6))
    assert (found.mean(axis=(0, 1)) >= expected - 0.01).all()
    assert (found.mean(axis=(0, 1)) <= expected + 0.1).all()


def test_three_shadow_maps_of_a_gray_caster_equal_one(device: Device) -> None:
    scene = under(Material(transmission=(0.4, 0.4, 0.4)))
    one = lit(device, scene, form=SLICES)
    counts = []
    for forced in (Effect.NONE, Effect.COLORED_SHADOWS):
        effects = (scene.effects & ALL) | forced
        with opened(device, scene, Empty(), SIZE, effects=effects) as frame:
            frame.render()
            assert frame.lighting is not None
            counts += [maps.channels for maps in frame.lighting.maps if maps is not None]
            np.testing.assert_array_equal(frame.image()[16:48, 16:48], one)
    assert counts == [1, 3]


def test_casters_that_absorb_nothing_have_no_shadow(device: Device) -> None:
    clear = Material(transmission=(1, 1, 1), coverage=0.7)
    np.testing.assert_allclose(lit(device, under(clear)), 1.0, atol=1e-6)
    absent = Material(coverage=0.0)
    np.testing.assert_allclose(lit(device, under(absent)), 1.0, atol=1e-6)


def test_opaque_casters_absorb_all_light(device: Device) -> None:
    assert not lit(device, under(Material())).any()
    nearly = Material(coverage=1.0, transmission=(1e-6, 0.0, 0.0))
    assert lit(device, under(nearly)).max() < 1e-3


def test_without_translucent_shadows_a_caster_absorbs_all_or_nothing(device: Device) -> None:
    only = Effect.SHADOWS
    assert not lit(device, under(Material(coverage=0.6)), only).any()
    np.testing.assert_allclose(lit(device, under(Material(coverage=0.4)), only), 1.0, atol=1e-6)


def test_a_spot_light_casts_the_same_colored_shadow(device: Device) -> None:
    transmission = (0.9, 0.5, 0.2)
    spot = SpotLight((0, 5, 0), (0, 0, 0), (25, 25, 25), math.radians(50))
    bare = replace(under(Material(coverage=0.0)), lights=(spot,))
    ratio = lit(device, under(Material(transmission=transmission), 1.0, spot)) / lit(device, bare)
    assert_mean(ratio, transmission)


def test_shadows_do_not_swim_when_the_camera_moves(device: Device) -> None:
    """The camera moves to twice the distance and half the angle, and sees the same points."""
    scene = under(Material(transmission=(0.5, 0.5, 0.5)))
    far = math.atan(math.tan(ABOVE.fov_y / 2) / 2) * 2
    camera = replace(ABOVE, position=(0, 12, 0), fov_y=far)
    np.testing.assert_allclose(
        lit(device, scene), lit(device, replace(scene, camera=camera)), atol=2e-3
    )


@pytest.mark.parametrize(("form", "rms"), [(PUBLISHED, 0.038), (OCCLUDERS, 0.038), (SLICES, 0)])
def test_variance_maps_have_noise(device: Device, form: str, rms: float) -> None:
    """The tent leaves some of the noise of single texels, which is 0.5 where V is 0.5."""
    found = lit(device, under(Material(coverage=0.5)), form=form)[..., 0]
    np.testing.assert_allclose(np.sqrt(((found - 0.5) ** 2).mean()), rms, atol=0.004)


HEIGHTS = (2.0, 1.6, 1.2, 0.8)


def smoky(probe: float) -> Scene:
    """Return four layers of smoke, and an opaque probe below some of them."""
    smoke = Material(coverage=0.3, albedo=(1, 1, 1), isotropic=True)
    casters = [level(f"smoke {h}", h, 1.5, smoke) for h in HEIGHTS]
    below = level("probe", probe, 0.3, Material(albedo=(1, 1, 1)))
    return Scene("smoke", ABOVE, (FLOOR, below, *casters), lights=(SUN,))


@pytest.mark.parametrize("form", [PUBLISHED, OCCLUDERS, SLICES])
def test_smoke_shades_itself(device: Device, form: str) -> None:
    """Opaque probes midway between layers of smoke are lit as the model of the form says."""
    models: dict[str, Callable[[list[float], list[float], float], float]] = {
        PUBLISHED: published_light,
        OCCLUDERS: occluder_light,
        SLICES: traced_light,
    }
    for number, height in enumerate(HEIGHTS, start=1):
        probe = height - 0.2
        shown = float(lit(device, smoky(probe), form=form)[12:20, 12:20].mean())
        above = [-h for h in HEIGHTS[:number]]
        expected = models[form](above, [0.7] * number, -probe)
        np.testing.assert_allclose(shown, expected, atol=2e-3 if form == SLICES else 0.03)


def test_both_forms_of_moments_agree_for_the_surface_that_they_include() -> None:
    """Elsewhere, moments that include a far floor leak all light."""
    layers, taus = [-h for h in HEIGHTS], [0.7] * 4
    bound = occluder_light(layers, taus, -0.6)
    np.testing.assert_allclose(published_light(layers, taus, -0.6), bound)
    np.testing.assert_allclose(bound, 0.36, atol=0.01)
    np.testing.assert_allclose(traced_light(layers, taus, -0.6), 0.2401)
    assert published_light(layers, taus, 20.0, -0.6) == 1


@pytest.mark.parametrize("form", [PUBLISHED, OCCLUDERS, SLICES])
def test_layers_of_smoke_above_a_far_floor(device: Device, form: str) -> None:
    """The radiance of the layers, seen from the light, is the sum of what each receives."""
    smoke = Material(coverage=0.3, albedo=(1, 1, 1), isotropic=True)
    layers, taus = [-h for h in HEIGHTS], [0.7] * 4
    casters = tuple(level(f"smoke {h}", h, 1.5, smoke) for h in HEIGHTS)
    floor = level("floor", -20, 9, Material(), casts=False)
    scene = Scene("smoke", ABOVE, (floor, *casters), lights=(SUN,))
    effects, settings = scene.effects & ALL, ShadingSettings(form)
    with opened(device, scene, "a_buffer", SIZE, effects=effects, settings=settings) as frame:
        frame.render()
        shown = float(frame.image()[24:40, 24:40].mean())
    lights = {
        PUBLISHED: [published_light(layers, taus, 20, z) for z in layers],
        OCCLUDERS: [occluder_light(layers, taus, z, own=0.5) for z in layers],
        SLICES: [traced_light(layers, taus, z) for z in layers],
    }
    # An isotropic surface scatters a quarter of the irradiance over pi, here 1/4.
    total, expected = (
        sum(0.3 * 0.7**k * 0.25 * light for k, light in enumerate(lights[one]))
        for one in (SLICES, form)
    )
    np.testing.assert_allclose(shown, expected, rtol=0.005 if form == SLICES else 0.03)
    if form == PUBLISHED:
        assert expected > 1.1 * total


@pytest.mark.parametrize("form", [PUBLISHED, OCCLUDERS, SLICES])
@pytest.mark.parametrize("tilt", [0.0, 0.5, 1.0])
def test_sheets_do_not_shade_themselves(device: Device, form: str, tilt: float) -> None:
    sheet = Material(coverage=0.6, albedo=(1, 1, 1), specular=0.0)
    right = (1.5 * math.cos(tilt), 1.5 * math.sin(tilt), 0.0)
    pane = Object("pane", quad((0, 1, 0), right, (0, 0, -1.5)), sheet)
    # Another caster far below makes the slices thick.
    low = Object("low", quad((2, -3, 0), (0.1, 0, 0), (0, 0, -0.1)), sheet)
    scene = Scene("sheet", ABOVE, (pane, low), lights=(SUN,))
    effects, settings = scene.effects & ALL, ShadingSettings(form)
    with opened(device, scene, "a_buffer", SIZE, effects=effects, settings=settings) as frame:
        frame.render()
        shown = frame.image()[24:40, 24:40].mean()
    np.testing.assert_allclose(shown, 0.6 * math.cos(tilt), rtol=0.01)


def test_slices_hold_cutouts_smaller_than_their_texels(device: Device) -> None:
    """A pane of which a texture covers every other column lets half of the light pass."""
    texels = np.zeros((256, 256), dtype=np.float32)
    texels[:, ::2] = 1.0
    stripes = Material(coverage=Texture(texels), transmission=(0, 0, 0))
    pane = level("pane", 1.0, 1.5, Material())
    uvs = np.array([(0, 0), (1, 0), (0, 1), (1, 1)], dtype=np.float32)
    pane = Object("pane", replace(pane.mesh, uvs=uvs), stripes)
    scene = Scene("stripes", ABOVE, (FLOOR, pane), lights=(SUN,))
    found = lit(device, scene, form=SLICES, shadow_map=512)
    np.testing.assert_allclose(found.mean(), 0.5, atol=0.03)


HALF_CLEAR = Material(transmission=(0.5, 0.5, 0.5))


@needs_mitsuba
def test_objects_that_receive_no_shadows_are_lit_by_the_path_tracer_too() -> None:
    scene = under(HALF_CLEAR)
    floor, shade = scene.objects
    free = replace(scene, objects=(replace(floor, receives_shadows=False), shade))
    np.testing.assert_allclose(matched(free, (8, 8), 1)[2:6, 2:6], 0.5, atol=1e-6)
    np.testing.assert_allclose(matched(scene, (8, 8), 1)[2:6, 2:6], 0.25, atol=1e-6)


@pytest.mark.parametrize("form", [PUBLISHED, OCCLUDERS, SLICES])
def test_objects_that_receive_no_shadows_are_lit(device: Device, form: str) -> None:
    """The object still casts a shadow on others."""
    scene = under(HALF_CLEAR)
    floor, shade = scene.objects
    free = replace(scene, objects=(replace(floor, receives_shadows=False), shade))
    np.testing.assert_allclose(lit(device, free, form=form), 1.0, atol=1e-6)
    both = replace(scene, objects=(floor, replace(shade, receives_shadows=False)))
    assert_mean(lit(device, both, form=form), 0.5)


@pytest.mark.parametrize("form", [PUBLISHED, OCCLUDERS, SLICES])
@pytest.mark.parametrize("downsampling", [1, 2, 4, 8])
def test_downsampling_moves_no_shadow(device: Device, form: str, downsampling: int) -> None:
    """The edge of a shadow is blurred, and stays in the middle of the picture."""
    nearly = Material(coverage=0.999, transmission=(0, 0, 0))
    half = Object("half", quad((0.75, 1, 0), (0.75, 0, 0), (0, 0, -1.5)), nearly)
    # The map covers all casters, and so both sides of the edge.
    far = Object("far", quad((-2, 1, 0), (0.1, 0, 0), (0, 0, -1.5)), nearly)
    scene = Scene("edge", ABOVE, (FLOOR, half, far), lights=(SUN,))
    found = lit(device, scene, form=form, shadow_map=128, downsampling=downsampling, rays=8)
    np.testing.assert_allclose(found.mean(), 0.5, atol=0.008)


def test_empty_texels_of_a_shadow_map_are_lit(device: Device) -> None:
    """A probe in the gap between two panes is lit."""
    pane = Material(coverage=0.9)
    sides = [Object(f"pane {x}", quad((x, 1, 0), (0.2, 0, 0), (0, 0, -0.2)), pane) for x in (-3, 3)]
    # The first height is above the panes, in front of the near plane of the map.
    lit_pane = Material(albedo=(1, 1, 1), coverage=0.999)
    probe = level("probe", 1.5, 1.5, lit_pane, casts=False)
    for height in (1.5, 0.9):
        above = replace(probe, mesh=level("probe", height, 1.5, lit_pane).mesh)
        scene = Scene("gap", ABOVE, (above, *sides), lights=(SUN,))
        with opened(device, scene, "phenomenological[precision=float]", SIZE) as frame:
            frame.render()
            np.testing.assert_allclose(frame.image()[24:40, 24:40], 0.999, atol=2e-3)


def test_an_empty_frustum_casts_no_shadow(device: Device) -> None:
    scene = Scene("bare", ABOVE, (FLOOR,), lights=(SUN,))
    np.testing.assert_allclose(lit(device, scene), 1.0, atol=1e-6)
    behind = SpotLight((0, -1, 0), (0, -2, 0))
    picture = lit(device, under(Material(transmission=(0.5, 0.5, 0.5)), 1.0, behind))
    assert not picture.any()


def test_a_light_inside_glass_stays_finite(device: Device) -> None:
    glass = Material(transmission=(0.9, 0.9, 0.9), index=1.5, solid=True)
    ball = Object("ball", sphere((0, 1, 0), 0.5, 24, 12), glass)
    for place in ((0.0, 1.0, 0.0), (0.0, 1.5, 0.0)):
        lamp = SpotLight(place, (0, 0, 0), (1, 1, 1), math.radians(170))
        scene = Scene("lamp", ABOVE, (FLOOR, ball), lights=(lamp,))
        found = lit(device, scene)
        assert np.isfinite(found).all()
        assert (found >= 0).all()


def test_grazing_floors_have_no_acne(device: Device) -> None:
    low_sun = DirectionalLight((1.0, -0.15, 0.2), (1, 1, 1))
    post = Object("post", quad((0, 0.5, -2.5), (0.1, 0, 0), (0, 0.5, 0)), Material())
    far_pane = Object("pane", quad((-2, 0.5, 2), (0.1, 0, 0), (0, 0.5, 0)), Material(0.5))
    scene = Scene("low", ABOVE, (FLOOR, post, far_pane), lights=(low_sun,))
    found = lit(device, scene)
    np.testing.assert_allclose(found, found.max(), rtol=0.02)


def test_more_requested_effects_take_more_memory(device: Device) -> None:
    scene = under(Material(transmission=(0.9, 0.4, 0.6), index=1.5, solid=True))
    sizes = []
    for effects in (
        Effect.NONE,
        Effect.SHADOWS,
        Effect.SHADOWS | Effect.TRANSLUCENT_SHADOWS,
        ALL,
    ):
        with UploadedScene(device, scene) as uploaded:
            lighting = uploaded.lighting(effects)
            assert lighting is not None
            sizes.append(sum(size for _, size in lighting.memory()))
    assert sizes[0] == 0
    assert sizes == sorted(set(sizes))


def test_a_black_light_lights_nothing(device: Device) -> None:
    dark = DirectionalLight((0, -1, 0), BLACK)
    assert not lit(device, replace(under(Material(0.5)), lights=(dark,))).any()
