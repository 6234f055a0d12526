"""The contract of all scenes: surfaces, light, smoke and fog.

Each scene also has a file of its own tests.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from oitbench.modeling.particles import puff
from oitbench.scene import BLACK, Object, SpotLight, Texture
from oitbench.scene.texturing import constant
from tests.meshes import agreement, boundary, coincident, corners, face_normals, hits, signed_volume
from tests.scenes.cases import CASES, FULL, SMALL, name_of, small
from tests.scenes.helpers import (
    COLLECTION,
    build,
    nearest_visible,
    particles,
    seen,
    toward_light,
    with_detail,
)

GLOWING = {
    "chess": {"windows"},
    "courtyard": {"flames"},
    "foggy_street": {"bulbs", "warm windows", "cool windows"},
    "frosted_door": {"far window"},
    "glow": {
        "coals",
        "embers",
        "flames 0",
        "flames 1",
        *(f"{part} {letter}" for part in ("neon", "halo") for letter in "OIT"),
    },
}
"""The objects that emit light in scenes with a directional or a spot light."""
HIDING_GROUND = ("shadow_trio", "smoke_and_glass", "smoke_ball")
FADING_GROUND = ("bottles",)
"""Scenes whose rough reflections need a sky without an edge."""
"""Scenes outdoors, or on a large table, that have a sky."""
ROOMS = (
    "chess", "courtyard", "foggy_street", "foliage", "frosted_door", "frosted_panes",
    "glow", "light_shafts", "water_and_smoke",
)  # fmt: skip
"""Scenes with walls that cast no shadow."""
LEAST_IN_VIEW = {
    "courtyard": 0.75,
    "foliage": 0.98,
    "smoke_and_glass": 0.8,
    "water_and_smoke": 0.95,
}
"""Fraction of each transparent object's vertices in the picture; 1 for other scenes."""
FREE_OF_NEAR_PLANE = ("fragment_lists", "layer_stack")
"""Scenes without geometry, or whose layers begin at a distance that is a parameter."""
FOG_BEGINS = 0.1
"""Near plane in meters of a scene with fog around the camera."""
LEAST_GAP = 3e-4
"""Least distance between a solid and the ground, meters."""


def is_flat_floor(item: Object) -> bool:
    return bool(np.ptp(item.mesh.positions[:, 1]) == 0)


def emits(item: Object) -> bool:
    emission = item.material.emission
    return isinstance(emission, Texture) or any(emission)


# Surfaces


@pytest.mark.parametrize("detail", [SMALL, FULL])
@pytest.mark.parametrize("case", CASES)
def test_no_two_triangles_coincide(case: str, detail: float) -> None:
    """A ray meets only one of two coincident triangles, so that path tracing would be wrong."""
    scene = build(with_detail(case, detail))
    if scene.objects:
        assert coincident([item.mesh for item in scene.objects]) == 0


@pytest.mark.parametrize("case", CASES)
def test_the_camera_sees_all_transparent_objects(case: str) -> None:
    scene, name = small(case), name_of(case)
    for item in scene.transparent:
        places = seen(scene.camera, item.mesh.positions)
        if name == "layer_stack":  # the planes are larger than the picture
            assert (places.min(axis=0) < -1).all()
            assert (places.max(axis=0) > 1).all()
        else:
            inside = (np.abs(places) <= 1).all(axis=1)
            assert inside.mean() >= LEAST_IN_VIEW.get(name, 1.0), item.name


@pytest.mark.parametrize("detail", [SMALL, FULL])
@pytest.mark.parametrize("case", CASES)
def test_solids_are_watertight_with_outward_normals(case: str, detail: float) -> None:
    for item in build(with_detail(case, detail)).objects:
        if item.material.solid:
            assert not len(boundary(item.mesh)), item.name
            assert signed_volume(item.mesh) > 1e-5
            assert (agreement(item.mesh).sum(axis=1) > 0).all()
            assert item.mesh.positions[:, 1].min() >= LEAST_GAP


@pytest.mark.parametrize("case", CASES)
def test_masks_have_an_empty_border_and_baked_light_is_in_range(case: str) -> None:
    scene = small(case)
    for item in scene.objects:
        mask, radiance = item.material.coverage, item.mesh.radiance
        if isinstance(mask, Texture):
            inner = mask.texels[3:-3, 3:-3]
            assert mask.texels.sum() == pytest.approx(float(inner.sum()))
            assert inner.max() > 0.1
        if radiance is not None:
            assert (radiance >= 0).all()
            assert item not in scene.opaque or radiance.max() * 2**scene.exposure <= 1.05
            assert item not in scene.opaque or radiance.mean() * 2**scene.exposure > 0.05


@pytest.mark.parametrize("name", COLLECTION.scenes)
def test_the_near_plane_is_close_in_front_of_all_that_is_visible(name: str) -> None:
    """Window depth, by which some methods weigh layers, is spent on the content."""
    scene = build(with_detail(name, SMALL))
    if name in FREE_OF_NEAR_PLANE:
        return
    near = scene.camera.near
    assert near == COLLECTION.scenes[name].parameters["near"].default
    nearest = min(nearest_visible(scene.camera, item.mesh) for item in scene.objects)
    assert near < nearest
    assert near == FOG_BEGINS if scene.medium else nearest < 1.5 * near


@pytest.mark.parametrize("name", COLLECTION.scenes)
def test_the_near_plane_is_a_parameter_in_meters(name: str) -> None:
    if build(with_detail(name, SMALL)).objects:
        assert build(f"{name}[detail={SMALL},near=0.05]").camera.near == pytest.approx(0.05)


# Light


@pytest.mark.parametrize("case", CASES)
def test_surfaces_are_lit_or_have_light_baked_in_but_not_both(case: str) -> None:
    scene = small(case)
    if not scene.objects:
        return
    baked = {item.mesh.radiance is not None for item in scene.objects}
    assert len(baked) == 1
    assert baked == {False} or not scene.beams
    for item in scene.objects:
        material = item.material
        assert item.mesh.normals is not None
        lit = bool(scene.lights) and (any(constant(material.albedo)) or material.reflectance > 0)
        assert not (lit and item.mesh.radiance is not None)
        assert lit or emits(item) or material.transmission != BLACK
        assert scene.lights or not any(constant(material.albedo))


@pytest.mark.parametrize("case", CASES)
def test_the_environment_lights_the_shadows_and_few_objects_emit_light(case: str) -> None:
    scene = small(case)
    if not scene.beams:
        return
    assert scene.environment is not None
    assert {item.name for item in scene.objects if emits(item)} == GLOWING.get(name_of(case), set())
    if len(scene.beams) == 1:
        # Inclined light casts shadows beside the casters, where they are visible.
        assert 0.4 < toward_light(scene)[1] < 0.97


@pytest.mark.parametrize("name", HIDING_GROUND)
def test_no_sky_shines_from_below_a_ground_that_hides_it(name: str) -> None:
    """Light does not pass the ground, so that no surface may receive the sky below the horizon."""
    sky = build(with_detail(name, SMALL)).environment
    assert sky is not None
    texels = sky.texels
    below = texels[len(texels) // 2 + 2 :]
    assert below.max() == 0
    assert texels[: len(texels) // 2].min() > 0


@pytest.mark.parametrize("name", FADING_GROUND)
def test_a_sky_fades_below_a_ground(name: str) -> None:
    sky = build(with_detail(name, SMALL)).environment
    assert sky is not None
    column = sky.texels[len(sky.texels) // 2 + 2 :, 0]
    assert (np.diff(column, axis=0) < 0).all()
    assert column[-1].max() < 0.02 * column[0].max()


@pytest.mark.parametrize("case", CASES)
def test_clear_glass_is_gray(case: str) -> None:
    """Colored clear glass would reflect the complementary color, which it does not transmit."""
    for item in small(case).transparent:
        transmission = constant(item.material.transmission)
        if min(transmission) > 0.8:
            assert len(set(transmission)) == 1, item.name


@pytest.mark.parametrize("case", CASES)
def test_spot_lights_are_not_inside_casters(case: str) -> None:
    scene = small(case)
    opaque = [item.mesh for item in scene.opaque if item.casts]
    for light in scene.beams:
        if isinstance(light, SpotLight):
            ray = np.subtract(light.target, light.position)
            for mesh in opaque:
                assert (hits(mesh, light.position, ray)[:1] > 0.1).all()


@pytest.mark.parametrize("case", CASES)
def test_floors_cast_no_shadow_and_other_objects_do(case: str) -> None:
    scene = small(case)
    if not scene.beams:
        return
    assert all(item.casts for item in scene.transparent)
    for item in scene.opaque:
        if is_flat_floor(item):
            assert not item.casts
        elif name_of(case) not in ROOMS:
            assert item.casts


# Smoke


@pytest.mark.parametrize("case", CASES)
def test_the_optical_depth_of_smoke_does_not_depend_on_detail(case: str) -> None:
    if not particles(small(case)):
        return
    thickness = []
    for detail in (0.5, 1, 2):
        total = 0.0
        for item in particles(build(with_detail(case, detail))):
            assert isinstance(item.material.coverage, Texture)
            area = np.linalg.norm(face_normals(item.mesh), axis=1).sum() / 2
            alpha = float(item.material.coverage.texels.max() / puff(1.0).texels.max())
            total -= float(area) * math.log(1 - alpha)
        thickness.append(total)
    np.testing.assert_allclose(thickness, thickness[1], rtol=0.08)


@pytest.mark.parametrize("case", CASES)
def test_smoke_is_isotropic_and_faces_camera_and_light_equally(case: str) -> None:
    scene = small(case)
    for item in particles(scene):
        assert item.material.isotropic
        assert min(constant(item.material.albedo)) >= 0.9
        assert item.mesh.normals is not None
        normal = item.mesh.normals[0].astype(np.float64)
        to_camera = abs(float(normal @ scene.camera.axes[2]))
        to_light = abs(float(normal @ toward_light(scene)))
        assert to_camera == pytest.approx(to_light, abs=1e-5)
        assert to_camera > 0.7


# Fog


@pytest.mark.parametrize("case", CASES)
def test_the_camera_is_in_the_fog_and_no_surface_coincides_with_a_face_of_its_box(
    case: str,
) -> None:
    scene = small(case)
    fog = scene.medium
    if fog is None:
        return
    assert (np.subtract(scene.camera.position, fog.low) > 0).all()
    assert (np.subtract(fog.high, scene.camera.position) > 0).all()
    for item in scene.objects:
        points = corners(item.mesh)
        for face in (fog.low, fog.high):
            assert not (np.abs(points - np.asarray(face)) < 1e-3).all(axis=1).any(), item.name


@pytest.mark.parametrize("case", CASES)
def test_fog_has_an_ambient_radiance_of_its_own_from_the_warm_surfaces_around(case: str) -> None:
    scene = small(case)
    if scene.medium is None:
        return
    assert scene.medium.ambient is not None
    assert scene.environment is not None
    red, green, blue = scene.medium.ambient
    assert red > green > blue
    sky = scene.environment.texels.mean(axis=(0, 1))
    assert red / blue > 1.1 * sky[0] / sky[2]


@pytest.mark.parametrize("case", CASES)
def test_the_extinction_of_the_fog_is_a_parameter(case: str) -> None:
    if small(case).medium is None:
        return
    fog = build(f"{name_of(case)}[detail={SMALL},extinction=0.02]").medium
    assert fog is not None
    assert fog.extinction == 0.02


@pytest.mark.parametrize("case", CASES)
def test_densities_vary_and_are_rarely_clipped(case: str) -> None:
    fog = small(case).medium
    if fog is None or fog.density is None:
        return
    assert 0.3 < fog.density.max() <= 1
    assert fog.density.max() > 2 * fog.density.min()
    # Clipped densities would show as uniform banks of fog.
    assert (fog.density == 1).mean() < 0.01
