"""The contract of all scenes. A scene's own file tests what is particular to that scene."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from oitbench.effects import Effect
from oitbench.errors import UsageError
from oitbench.modeling.particles import puff
from oitbench.modeling.placement import merge
from oitbench.parameters import Parameter, text
from oitbench.scene import BLACK, Object, Scene, SpotLight, Texture
from tests.meshes import agreement, boundary, coincident, corners, face_normals, hits, signed_volume
from tests.scenes.helpers import COLLECTION, build, particles, seen, toward_light, with_detail

SMALL, FULL = 0.1, 1.0
"""Values of the parameter `detail`."""
SHADOWED = Effect.SHADOWS | Effect.TRANSLUCENT_SHADOWS
GRAY = Effect.COVERAGE
COLORED = GRAY | Effect.COLORED_TRANSMISSION
COLORED_CASTERS = COLORED | SHADOWED | Effect.COLORED_SHADOWS
REFRACTING = COLORED_CASTERS | Effect.REFRACTION | Effect.CAUSTICS
EFFECTS = {
    "atrium_fog": Effect.VOLUME,
    "bottles": COLORED_CASTERS,
    "caustic_spheres": REFRACTING,
    "chess": REFRACTING,
    "clouds": GRAY | Effect.TRANSLUCENT_SHADOWS,
    "foggy_street": GRAY | SHADOWED | Effect.DIFFUSION | Effect.VOLUME,
    "foggy_street[collimation=1]": GRAY | SHADOWED | Effect.VOLUME,
    "foliage": GRAY,
    "foliage[light=sky]": GRAY | SHADOWED | Effect.AMBIENT_OCCLUSION | Effect.INFERRED_AO,
    "fragment_lists": GRAY,
    "fragment_lists[tinted=true]": COLORED,
    "frosted_door": COLORED_CASTERS | Effect.DIFFUSION,
    "frosted_door[collimation=1]": COLORED_CASTERS,
    "frosted_panes": GRAY | SHADOWED | Effect.DIFFUSION,
    "glass_bars": COLORED,
    "layer_stack": GRAY,
    "layer_stack[transmission=grey]": GRAY,
    "layer_stack[transmission=colored]": COLORED,
    "light_shafts": COLORED_CASTERS | Effect.VOLUME,
    "shadow_trio": REFRACTING,
    "smoke_and_glass": REFRACTING,
    "smoke_ball": GRAY | SHADOWED,
    "smoke_ball[cube=above]": GRAY | SHADOWED,
    "tumblers": REFRACTING,
}
"""The effects that each scene requests, and that its variants do."""
CASES = sorted({*EFFECTS, *COLLECTION.scenes})
GLOWING = {
    "foggy_street": {"bulbs", "warm windows", "cool windows"},
    "frosted_door": {"far window"},
}
"""The objects that emit light in scenes with a directional or a spot light."""
ROOMS = ("foggy_street", "foliage", "frosted_door", "frosted_panes", "light_shafts")
"""Scenes with walls that cast no shadow."""
MOST_TRIANGLES = {"bottles": 160_000, "foliage": 140_000}
"""Limits that differ from 60,000."""
LEAST_IN_VIEW = {"clouds": 0.99, "foliage": 0.98, "smoke_and_glass": 0.8}
"""Fraction of each transparent object's vertices in the picture; 1 for other scenes."""
FRACTION = ("-0.1", "1.5", "nan")
IMPOSSIBLE = {
    **dict.fromkeys(("alpha", "alpha_high", "alpha_low", "clarity", "collimation"), FRACTION),
    **dict.fromkeys(("coverage", "reflection"), FRACTION),
    **dict.fromkeys(("count", "height", "layers", "width"), ("0", "1.5")),
    "detail": ("-1", "nan", "101"),
    "distance": ("0.1", "nan"),
    "extinction": ("-1", "nan"),
    "seed": ("-1", "0.5"),
}
"""Values that no parameter of this name may accept."""
LEAST_GAP = 3e-4
"""Least distance between a solid and the ground, meters."""


def name_of(case: str) -> str:
    return case.partition("[")[0]


def small(case: str) -> Scene:
    return build(with_detail(case, SMALL))


def leaves(value: Any) -> Iterator[np.ndarray]:
    """Yield all numbers and texts of a scene as arrays, in a fixed order."""
    if dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            yield from leaves(getattr(value, field.name))
    elif isinstance(value, tuple):
        for item in value:
            yield from leaves(item)
    elif isinstance(value, Effect):
        yield np.asarray(value.value)
    elif value is not None:
        yield np.asarray(value)


def transparent_triangles(scene: Scene) -> int:
    return sum(len(item.mesh.triangles) for item in scene.transparent)


def all_triangles(scene: Scene) -> int:
    """Return the number of triangles, or of fragments for a scene without geometry."""
    if scene.lists is not None:
        return scene.lists.z.size
    return sum(len(item.mesh.triangles) for item in scene.objects)


def is_flat_floor(item: Object) -> bool:
    return bool(np.ptp(item.mesh.positions[:, 1]) == 0)


def emits(item: Object) -> bool:
    emission = item.material.emission
    return isinstance(emission, Texture) or any(emission)


# Every scene


@pytest.mark.parametrize("case", CASES)
def test_a_scene_builds_and_repeats_exactly(case: str) -> None:
    label = with_detail(case, SMALL)
    first, second = (COLLECTION.build_scene(label) for _ in range(2))
    assert first.name.startswith(name_of(case))
    assert first.transparent or first.lists is not None or first.medium is not None
    for one, other in zip(leaves(first), leaves(second), strict=True):
        assert one.dtype == other.dtype
        np.testing.assert_array_equal(one, other)
        # Only the far plane of the camera may be infinite.
        assert one.dtype.kind not in "fiu" or np.isfinite(one).all() or one == math.inf


@pytest.mark.parametrize("name", COLLECTION.scenes)
def test_a_scene_documents_itself_and_its_parameters(name: str) -> None:
    plugin = COLLECTION.scenes[name]
    assert re.match(r"[^\n]{20,100}\.\n", plugin.doc)
    assert "detail" in plugin.parameters
    assert all(parameter.help for parameter in plugin.parameters.values())
    documented = re.findall(r"^([a-z_, ]+) : (?:float|int|str|bool)$", plugin.doc, re.MULTILINE)
    assert sorted(", ".join(documented).split(", ")) == sorted(plugin.parameters)


@pytest.mark.parametrize("detail", [SMALL, FULL])
@pytest.mark.parametrize("case", CASES)
def test_a_scene_requests_the_effects_that_it_claims(case: str, detail: float) -> None:
    effects = build(with_detail(case, detail)).effects
    assert effects
    assert effects == EFFECTS.get(case, effects)


@pytest.mark.parametrize(
    "name", [name for name, plugin in COLLECTION.scenes.items() if "seed" in plugin.parameters]
)
def test_another_seed_gives_another_scene(name: str) -> None:
    one, other = (build(f"{name}[detail={SMALL},seed={seed}]") for seed in (1, 2))
    changed = [not np.array_equal(*pair) for pair in zip(leaves(one), leaves(other), strict=True)]
    assert sum(changed) > 1  # not only the name
    for before, after in zip(particles(one), particles(other), strict=True):
        assert not np.array_equal(before.mesh.positions, after.mesh.positions)


def wrong_values(name: str, parameter: Parameter) -> Iterator[str]:
    """Yield values that the parameter must refuse."""
    yield from IMPOSSIBLE.get(name, ())
    if parameter.choices:
        yield "nonsense"
    elif isinstance(parameter.default, bool):
        yield "maybe"
    else:
        yield "nonsense"
        for bound, step in ((parameter.low, -1), (parameter.high, 1)):
            if bound is not None:
                yield text(type(parameter.default)(bound + step))
        if isinstance(parameter.default, float):
            yield "nan"


def edge_values(parameter: Parameter) -> Iterator[str]:
    """Yield the values at the edges of what the parameter allows, except expensive ones."""
    yield from map(text, parameter.choices)
    if isinstance(parameter.default, bool):
        yield from ("true", "false")
    for bound in (parameter.low, parameter.high):
        if bound is not None and bound <= 10:
            yield text(type(parameter.default)(bound))


@pytest.mark.parametrize("name", COLLECTION.scenes)
def test_values_out_of_bounds_are_refused_by_the_parameters_name(name: str) -> None:
    parameters = COLLECTION.scenes[name].parameters
    for key, parameter in parameters.items():
        for value in wrong_values(key, parameter):
            with pytest.raises(UsageError, match=rf"{name}.*\b{key}\b"):
                build(f"{name}[{key}={value}]")
    with pytest.raises(UsageError, match="nonsense"):
        build(f"{name}[nonsense=1]")


@pytest.mark.parametrize("name", COLLECTION.scenes)
def test_values_at_the_bounds_build_or_contradict_another_parameter(name: str) -> None:
    for key, parameter in COLLECTION.scenes[name].parameters.items():
        for value in edge_values(parameter):
            label = f"{name}[{key}={value}" + ("]" if key == "detail" else f",detail={SMALL}]")
            try:
                scene = build(label)
            except UsageError as error:
                reason = str(error).partition("]: ")[2]
                named = [other for other in COLLECTION.scenes[name].parameters if other in reason]
                assert key in named, label
                assert len(named) == 2
            else:
                assert scene.objects or scene.lists is not None, label


@pytest.mark.parametrize("name", COLLECTION.scenes)
def test_detail_scales_the_number_of_triangles(name: str) -> None:
    # A plane of the stack is two triangles up to detail 1.
    details = (1, 16) if name == "layer_stack" else (SMALL, FULL)
    coarse, fine = (build(f"{name}[detail={detail}]") for detail in details)
    every = all_triangles(fine) / all_triangles(coarse)
    assert every > 1.5
    if transparent_triangles(fine) != transparent_triangles(coarse):
        assert transparent_triangles(fine) > 3 * transparent_triangles(coarse)
    else:
        assert every > 3


@pytest.mark.parametrize("name", COLLECTION.scenes)
def test_a_scene_is_affordable(name: str) -> None:
    scene = build(f"{name}[detail={FULL}]")
    assert scene.lists is not None or all_triangles(scene) < MOST_TRIANGLES.get(name, 60_000)


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
            assert signed_volume(item.mesh) > 1e-3
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
        lit = bool(scene.lights) and (any(material.albedo) or material.reflectance > 0)
        assert not (lit and item.mesh.radiance is not None)
        assert lit or emits(item) or material.transmission != BLACK
        assert scene.lights or not any(material.albedo)


@pytest.mark.parametrize("case", CASES)
def test_surroundings_fill_the_shadows_and_few_objects_emit_light(case: str) -> None:
    scene = small(case)
    if not scene.beams:
        return
    assert scene.environment is not None
    assert {item.name for item in scene.objects if emits(item)} == GLOWING.get(name_of(case), set())
    if len(scene.beams) == 1:
        # Inclined, so that shadows are seen beside what casts them.
        assert 0.4 < toward_light(scene)[1] < 0.97


@pytest.mark.parametrize("case", CASES)
def test_spot_lights_are_not_inside_of_casters(case: str) -> None:
    scene = small(case)
    opaque = [item.mesh for item in scene.opaque if item.casts]
    for light in scene.beams:
        if isinstance(light, SpotLight) and opaque:
            ray = np.subtract(light.target, light.position)
            assert (hits(merge(opaque), light.position, ray)[:1] > 0.1).all()


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
        assert min(item.material.albedo) >= 0.9
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
