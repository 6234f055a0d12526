"""Every scene builds, repeats exactly and calls for what it claims; each shows what it is for."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt
import pytest

from oitbench.effects import Effect
from oitbench.errors import UsageError
from oitbench.plugins import Collection
from oitbench.scene import BLACK, Mesh, Object, Scene, Texture

COLLECTION = Collection.load()
GREY, COLORED = Effect.COVERAGE, Effect.COVERAGE | Effect.COLORED_TRANSMISSION
CAST = Effect.SHADOWS | Effect.TRANSLUCENT_SHADOWS
OCCLUDED = Effect.AMBIENT_OCCLUSION | Effect.INFERRED_AO
EFFECTS = {
    "layer_stack": GREY,
    "layer_stack[transmission=grey]": GREY,
    "layer_stack[transmission=colored]": COLORED,
    "fragment_lists[detail=0.1]": GREY,
    "fragment_lists[detail=0.1,tinted=true]": COLORED,
    "glass_bars[detail=0.1]": COLORED,
    "foliage[detail=0.1]": GREY,
    "foliage[detail=0.1,light=sky]": GREY | CAST | OCCLUDED,
}
"""Of the scenes that are lit by emission, and of what they become; others have their own files."""
SEEDED = [name for name, plugin in COLLECTION.scenes.items() if "seed" in plugin.parameters]


def build(text: str) -> Scene:
    return COLLECTION.build_scene(text)


def named(scene: Scene, name: str) -> Object:
    return next(item for item in scene.objects if item.name == name)


def arrays(scene: Scene) -> Iterator[npt.NDArray[np.generic]]:
    """Yield every array of the scene, in a fixed order."""
    for item in scene.objects:
        mesh, material = item.mesh, item.material
        for value in (mesh.positions, mesh.triangles, mesh.uvs, mesh.radiance, mesh.normals):
            if value is not None:
                yield value
        for part in (material.coverage, material.emission, material.transmission):
            yield part.texels if isinstance(part, Texture) else np.asarray(part)
    if scene.lists is not None:
        lists = scene.lists
        yield from (lists.z, lists.coverage, lists.radiance, lists.transmission)
    if scene.medium is not None and scene.medium.density is not None:
        yield scene.medium.density
    if scene.environment is not None:
        around = scene.environment.radiance
        yield around.texels if isinstance(around, Texture) else np.asarray(around)


def distances(scene: Scene, mesh: Mesh) -> npt.NDArray[np.float64]:
    return scene.camera.view_distance(mesh.positions)


def crossings(mesh: Mesh, origin: npt.ArrayLike, target: npt.ArrayLike) -> int:
    """Count the triangles that the ray from `origin` through `target` meets (Möller-Trumbore)."""
    start = np.asarray(origin, dtype=np.float64)
    ray = np.asarray(target, dtype=np.float64) - start
    a, b, c = mesh.positions.astype(np.float64)[mesh.triangles].swapaxes(0, 1)
    normal = np.cross(b - a, c - a)
    scale = normal @ ray
    offset = np.cross(start - a, ray)
    u = -np.einsum("ij,ij->i", c - a, offset) / scale
    v = np.einsum("ij,ij->i", b - a, offset) / scale
    return int(((u > 0) & (v > 0) & (u + v < 1)).sum())


def test_a_ray_crosses_a_triangle_within_its_edges_only() -> None:
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=np.float32)
    triangle = Mesh(corners, np.array([[0, 1, 2]], dtype=np.uint32))
    places = ((0.25, 0.25, 1), (0.8, 0.1, 1), (0.1, 0.8, 1), (0.7, 0.7, 0), (-0.2, 0.3, 0))
    for x, y, met in places:
        assert crossings(triangle, (x, y, 1), (x, y, -1)) == met


@pytest.mark.parametrize("name", COLLECTION.scenes)
def test_every_scene_builds_and_repeats_exactly(name: str) -> None:
    first, second = (build(f"{name}[detail=0.1]") for _ in range(2))
    assert first.name.startswith(name)
    assert first.transparent or first.lists is not None or first.medium is not None
    assert first.effects
    for one, other in zip(arrays(first), arrays(second), strict=True):
        assert one.dtype == other.dtype
        np.testing.assert_array_equal(one, other)
        assert np.isfinite(one).all()
    assert all(
        item.mesh.radiance is None or (item.mesh.radiance >= 0).all() for item in first.objects
    )


@pytest.mark.parametrize("name", COLLECTION.scenes)
def test_surfaces_are_lit_or_have_light_baked_in_but_not_both(name: str) -> None:
    """Radiance at vertices is light found with the scene: none may come on top of it."""
    scene = build(f"{name}[detail=0.1]")
    for item in scene.objects:
        material = item.material
        lit = bool(scene.lights) and (any(material.albedo) or material.reflectance > 0)
        glows = isinstance(material.emission, Texture) or any(material.emission)
        assert not (lit and item.mesh.radiance is not None)
        assert lit or glows or material.transmission != BLACK
        assert scene.lights or not any(material.albedo)


@pytest.mark.parametrize("name", COLLECTION.scenes)
def test_every_scene_documents_its_parameters(name: str) -> None:
    plugin = COLLECTION.scenes[name]
    assert "detail" in plugin.parameters
    assert all(parameter.help for parameter in plugin.parameters.values())


@pytest.mark.parametrize(("text", "effects"), EFFECTS.items())
def test_scenes_call_for_the_effects_they_are_made_for(text: str, effects: Effect) -> None:
    assert build(text).effects == effects


@pytest.mark.parametrize("name", SEEDED)
def test_another_seed_gives_another_scene(name: str) -> None:
    pairs = zip(*(arrays(build(f"{name}[detail=0.1,seed={seed}]")) for seed in (1, 2)), strict=True)
    assert any(not np.array_equal(one, other) for one, other in pairs)


@pytest.mark.parametrize(
    ("text", "culprit"),
    [
        ("layer_stack[count=0]", "count"),
        ("layer_stack[first=0.1,near=0.2]", "first"),
        ("layer_stack[palette=mauve]", "palette"),
        ("fragment_lists[alpha_low=0.9,alpha_high=0.1]", "alpha_low"),
        ("fragment_lists[detail=-1]", "detail"),
        ("glass_bars[reflection=2]", "reflection"),
        ("bottles[coverage=nan]", "coverage"),
        ("smoke_ball[alpha=1.5]", "alpha"),
        ("smoke_ball[cube=below]", "cube"),
        ("foliage[leaves=3]", "leaves"),
        ("foliage[light=moon]", "light"),
        ("shadow_trio[alpha=-0.1]", "alpha"),
        ("clouds[seed=-1]", "seed"),
        ("frosted_door[collimation=2]", "collimation"),
        ("foggy_street[extinction=-1]", "extinction"),
        ("foggy_street[collimation=-0.5]", "collimation"),
        ("atrium_fog[extinction=nan]", "extinction"),
        ("light_shafts[detail=-1]", "detail"),
    ],
)
def test_wrong_parameters_are_refused_by_name(text: str, culprit: str) -> None:
    with pytest.raises(UsageError, match=culprit):
        build(text)


@pytest.mark.parametrize("name", ["glass_bars", "bottles", "smoke_ball", "foliage"])
def test_detail_adds_triangles(name: str) -> None:
    small, large = (
        sum(len(item.mesh.triangles) for item in build(f"{name}[detail={detail}]").transparent)
        for detail in (0.1, 0.5)
    )
    assert large > 2 * small


# layer_stack


@pytest.mark.parametrize("order", ["shuffled", "near_first", "far_first"])
def test_planes_are_at_their_distances_in_any_order(order: str) -> None:
    scene = build(f"layer_stack[count=5,first=3,spacing=0.25,order={order}]")
    for item in scene.objects:
        index = int(item.name.removeprefix("plane "))
        np.testing.assert_allclose(distances(scene, item.mesh), 3 + 0.25 * index, rtol=1e-6)
    sequence = [item.name for item in scene.objects]
    assert sorted(sequence) == [f"plane {index}" for index in range(5)]
    assert (sequence == sorted(sequence)) == (order == "near_first")


def test_planes_over_fill_a_view_of_four_to_one() -> None:
    scene = build("layer_stack[count=4,first=0.2,spacing=3]")
    for item in scene.objects:
        half = float(distances(scene, item.mesh)[0]) * math.tan(scene.camera.fov_y / 2)
        reach = np.abs(item.mesh.positions).max(axis=0)[:2]
        assert reach[1] > half
        assert reach[0] > 4 * half


def test_layer_materials_follow_the_parameters() -> None:
    scene = build("layer_stack[alpha=0.3,radiance=20,transmission=grey,clarity=0.5,palette=white]")
    for item in scene.objects:
        assert item.material.coverage == 0.3
        assert item.material.emission == (20, 20, 20)
        assert item.material.transmission == (0.5, 0.5, 0.5)
    assert scene.background == (0.25, 0.25, 0.25)


def test_spacing_zero_makes_exact_ties() -> None:
    scene = build("layer_stack[count=3,spacing=0]")
    first, *rest = (item.mesh.positions for item in scene.objects)
    assert all(np.array_equal(first, other) for other in rest)


# fragment_lists


def test_lists_are_distinct_unsorted_and_in_range() -> None:
    scene = build("fragment_lists[width=32,height=16,layers=12,alpha_low=0.2,alpha_high=0.4]")
    lists = scene.lists
    assert lists is not None
    assert lists.z.shape == (12, 16, 32)
    assert 0.5 <= lists.z.min() < 0.6
    assert 19.5 < lists.z.max() <= 20
    assert np.diff(np.sort(lists.z, axis=0), axis=0).min() > 5e-4
    ascending = (np.diff(lists.z, axis=0) > 0).mean()
    assert 0.45 < ascending < 0.55
    assert 0.2 <= lists.coverage.min() < 0.22
    assert 0.38 < lists.coverage.max() <= 0.4
    assert not lists.transmission.any()
    assert min(scene.background) > 0


def test_list_distances_are_uniform() -> None:
    lists = build("fragment_lists[layers=4]").lists
    assert lists is not None
    counts, _ = np.histogram(lists.z, bins=8, range=(0.5, 20))
    np.testing.assert_allclose(counts / lists.z.size, 1 / 8, atol=2e-3)


def test_ties_tint_and_hdr_are_to_be_asked_for() -> None:
    text = "fragment_lists[width=32,height=32,layers=8,ties=true,tinted=true,hdr=true]"
    lists = build(text).lists
    assert lists is not None
    assert all(len(np.unique(lists.z[:, row, 0])) < 8 for row in range(32))
    assert 0.4 < lists.transmission.mean() < 0.6
    assert lists.transmission.max() < 1
    assert 0.01 <= lists.radiance.min() < 0.02
    assert 50 < lists.radiance.max() <= 100
    assert 0.8 < np.median(lists.radiance) < 1.25


def test_long_lists_fit() -> None:
    lists = build("fragment_lists[width=64,height=64,layers=700]").lists
    assert lists is not None
    assert np.diff(np.sort(lists.z, axis=0), axis=0).min() > 0
    assert lists.z.max() <= 20


def test_detail_scales_the_number_of_lists() -> None:
    lists = build("fragment_lists[detail=0.25]").lists
    assert lists is not None
    assert lists.z.shape == (8, 128, 128)


# glass_bars


def test_bars_of_the_front_grid_are_all_nearer_than_those_behind() -> None:
    scene = build("glass_bars")
    far, near = (
        [
            float(distances(scene, item.mesh).mean())
            for item in scene.transparent
            if item.name.startswith(grid)
        ]
        for grid in ("level", "upright")
    )
    assert len(near) == len(far) == 7
    assert max(near) < min(far)


def test_bars_of_one_grid_are_coplanar_and_apart() -> None:
    scene = build("glass_bars")
    for grid, axis in (("upright", 0), ("level", 1)):
        bars = [item.mesh.positions for item in scene.transparent if item.name.startswith(grid)]
        assert len({float(z) for bar in bars for z in bar[:, 2]}) == 1
        spans = sorted((float(bar[:, axis].min()), float(bar[:, axis].max())) for bar in bars)
        assert all(one[1] < other[0] for one, other in itertools.pairwise(spans))


def test_bars_without_reflection_emit_nothing() -> None:
    for item in build("glass_bars[reflection=0]").transparent:
        assert item.material.emission == (0, 0, 0)
        assert item.material.coverage == 1
        assert max(item.material.transmission) / min(item.material.transmission) > 5


# bottles


@pytest.mark.parametrize("name", ["ruby", "emerald", "amber", "sapphire"])
def test_a_ray_through_a_bottle_meets_four_walls(name: str) -> None:
    scene = build("bottles[detail=0.3]")
    mesh = named(scene, name).mesh
    middle = mesh.positions.mean(axis=0) * [1, 0, 1] + [0.0031, 0.07, 0]
    slightly_above = middle + np.array([0, 0.003, 1])
    assert crossings(mesh, slightly_above, middle) == 4


def test_bottles_overlap_in_depth_so_that_no_order_of_objects_is_right() -> None:
    scene = build("bottles[detail=0.1]")
    spans = sorted(
        (float(z.min()), float(z.max()))
        for z in (distances(scene, item.mesh) for item in scene.transparent)
    )
    assert any(one[1] > other[0] for one, other in itertools.pairwise(spans))


def test_the_inner_wall_is_inside_the_outer_one() -> None:
    mesh = named(build("bottles[detail=0.3]"), "emerald").mesh
    half = len(mesh.positions) // 2
    foot = np.array([mesh.positions[0, 0], 0, mesh.positions[0, 2]])
    outer, inner = (
        np.hypot(*(part - foot)[:, [0, 2]].T) for part in np.split(mesh.positions, [half])
    )
    assert inner.max() == pytest.approx(outer.max() - 0.0025, abs=2e-4)


# smoke_ball


def test_smoke_is_one_object_of_a_thousand_particles_in_random_order() -> None:
    scene = build("smoke_ball")
    (smoke,) = scene.transparent
    assert smoke.particles
    assert len(smoke.mesh.triangles) == 2000
    depth = distances(scene, smoke.mesh).reshape(1000, 4).mean(axis=1)
    assert abs(np.corrcoef(np.arange(1000), depth)[0, 1]) < 0.1


# foliage


def test_foliage_is_thousands_of_binary_leaves() -> None:
    scene = build("foliage")
    assert all(item.material.binary_coverage for item in scene.transparent)
    assert sum(len(item.mesh.triangles) for item in scene.transparent) / 8 > 4000
    for item in scene.transparent:
        mask = item.material.coverage
        assert isinstance(mask, Texture)
        # Whole texels are in or out; only the outline is in between.
        assert ((mask.texels > 0) & (mask.texels < 1)).mean() < 0.1
        assert 0.2 < mask.texels.mean() < 0.8


@pytest.mark.parametrize("name", ["smoke_ball", "foliage"])
def test_card_textures_have_an_empty_border(name: str) -> None:
    for item in build(f"{name}[detail=0.1]").transparent:
        mask = item.material.coverage
        assert isinstance(mask, Texture)
        inner = mask.texels[3:-3, 3:-3]
        assert mask.texels.sum() == pytest.approx(float(inner.sum()))
        assert inner.max() > 0.1


@pytest.mark.parametrize("name", ["glass_bars", "foliage"])
def test_baked_pictures_stay_in_range(name: str) -> None:
    scene = build(f"{name}[detail=0.1]")
    for item in scene.opaque:
        assert item.mesh.radiance is not None
        shown = item.mesh.radiance * 2**scene.exposure
        assert shown.max() <= 1.05
        assert shown.mean() > 0.05


def test_sun_and_sky_take_the_place_of_baked_light() -> None:
    lit = build("foliage[detail=0.1,light=sky]")
    assert all(item.mesh.radiance is None for item in lit.objects)
    assert all(any(item.material.albedo) for item in lit.objects)
    assert all(item.material.binary_coverage for item in lit.transparent)
    assert lit.beams
    assert lit.environment is not None
