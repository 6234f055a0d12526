"""The scenes of shadows, caustics, smoke and bottles show under real lights what they are for."""

from __future__ import annotations

import itertools
import math

import numpy as np
import numpy.typing as npt
import pytest

from oitbench.effects import Effect
from oitbench.modeling.particles import fill, puff, shared_coverage, sprites
from oitbench.modeling.surroundings import gradient_sky
from oitbench.plugins import Collection
from oitbench.scene import (
    Camera,
    DirectionalLight,
    EnvironmentLight,
    Floats,
    Mesh,
    Object,
    Scene,
    SpotLight,
    Texture,
)

COLLECTION = Collection.load()
GREY = Effect.COVERAGE | Effect.TRANSLUCENT_SHADOWS
COLORED = GREY | Effect.SHADOWS | Effect.COLORED_TRANSMISSION | Effect.COLORED_SHADOWS
CAUSTIC = COLORED | Effect.REFRACTION | Effect.CAUSTICS
EFFECTS = {
    "shadow_trio": CAUSTIC,
    "caustic_spheres": CAUSTIC,
    "smoke_ball": GREY | Effect.SHADOWS,
    "clouds": GREY,
    "smoke_and_glass": CAUSTIC,
    "bottles": COLORED,
}
SMOKY = ("shadow_trio", "smoke_ball", "clouds", "smoke_and_glass")
CLOSED = (
    ("shadow_trio", "ball"),
    ("caustic_spheres", "ball of index 1.0"),
    ("caustic_spheres", "ball of index 1.3"),
    ("caustic_spheres", "ball of index 1.5"),
    ("caustic_spheres", "knot of index 1.5"),
    ("smoke_and_glass", "clear ball"),
    ("smoke_and_glass", "green ball"),
    ("smoke_and_glass", "vase"),
)


def build(text: str) -> Scene:
    return COLLECTION.build_scene(text)


def named(scene: Scene, name: str) -> Object:
    return next(item for item in scene.objects if item.name == name)


def corners(mesh: Mesh) -> Floats:
    """Return the triangles' corners, shape (n, 3, 3)."""
    return np.asarray(mesh.positions.astype(np.float64)[mesh.triangles])


def meets(mesh: Mesh, origin: npt.ArrayLike, directions: Floats) -> Floats:
    """Count the triangles that each ray meets, shape (rays,) (Möller & Trumbore 1997)."""
    a, b, c = corners(mesh).swapaxes(0, 1)
    start, ray = np.broadcast_to(np.asarray(origin), directions.shape)[:, None], directions[:, None]
    offset = start - a
    across = np.cross(ray, c - a)
    scale = (across * (b - a)).sum(axis=-1)
    turned = np.cross(offset, b - a)
    with np.errstate(divide="ignore", invalid="ignore"):
        u = (across * offset).sum(axis=-1) / scale
        v = (ray * turned).sum(axis=-1) / scale
        distance = ((c - a) * turned).sum(axis=-1) / scale
    return np.asarray(((u > 0) & (v > 0) & (u + v < 1) & (distance > 1e-4)).sum(axis=1))


def view_rays(camera: Camera, side: int, aspect: float = 4 / 3) -> Floats:
    """Return side × side directions through the view, shape (side², 3)."""
    line = (np.arange(side) + 0.5) / side * 2 - 1
    x, y = np.meshgrid(line, line)
    half = math.tan(camera.fov_y / 2)
    local = np.stack([x.ravel() * half * aspect, y.ravel() * half, -np.ones(side**2)], axis=1)
    return np.asarray(local @ camera.axes)


def toward_light(scene: Scene, point: npt.ArrayLike) -> Floats:
    """Return the unit vector from `point` to the scene's one light with shadows."""
    (light,) = scene.beams
    if isinstance(light, DirectionalLight):
        toward = -np.asarray(light.direction, dtype=np.float64)
    else:
        toward = np.asarray(light.position) - np.asarray(point)
    return np.asarray(toward / np.linalg.norm(toward))


def center(item: Object) -> Floats:
    return np.asarray(item.mesh.positions.astype(np.float64).mean(axis=0))


def particles(scene: Scene) -> list[Object]:
    return [item for item in scene.objects if item.particles]


def places(item: Object) -> Floats:
    return np.asarray(item.mesh.positions.astype(np.float64).reshape(-1, 4, 3).mean(axis=1))


# All of them


@pytest.mark.parametrize("detail", ["", "[detail=0.1]"])
@pytest.mark.parametrize(("name", "effects"), EFFECTS.items())
def test_scenes_call_for_the_effects_they_are_made_for(
    name: str, effects: Effect, detail: str
) -> None:
    assert build(name + detail).effects == effects


@pytest.mark.parametrize("name", EFFECTS)
def test_one_inclined_light_throws_the_shadows_and_surroundings_fill_them(name: str) -> None:
    scene = build(f"{name}[detail=0.1]")
    assert len(scene.beams) == 1
    assert 0.4 < toward_light(scene, (0, 0, 0))[1] < 0.97
    assert isinstance(scene.environment, EnvironmentLight)
    for item in scene.objects:
        assert item.material.emission == (0, 0, 0)
        assert item.mesh.radiance is None


@pytest.mark.parametrize("name", EFFECTS)
def test_no_two_triangles_coincide(name: str) -> None:
    scene = build(f"{name}[detail=0.1]")
    triangles = np.concatenate([corners(item.mesh) for item in scene.objects]).astype(np.float32)
    order = np.lexsort(triangles.transpose(2, 0, 1)[::-1], axis=1)
    sorted_corners = np.take_along_axis(triangles, order[..., None], axis=1)
    assert len(np.unique(sorted_corners.reshape(-1, 9), axis=0)) == len(triangles)


@pytest.mark.parametrize("name", EFFECTS)
def test_floors_receive_shadows_and_throw_none(name: str) -> None:
    scene = build(f"{name}[detail=0.1]")
    for item in scene.objects:
        assert item.casts == (item.name not in ("floor", "ground", "table"))


@pytest.mark.parametrize("name", SMOKY)
def test_optical_depth_of_smoke_does_not_change_with_detail(name: str) -> None:
    thickness = []
    for detail in ("0.5", "1", "2"):
        total = 0.0
        for item in particles(build(f"{name}[detail={detail}]")):
            coverage = item.material.coverage
            assert isinstance(coverage, Texture)
            a, b, c = corners(item.mesh).swapaxes(0, 1)
            areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
            alpha = float(coverage.texels.max() / puff(1.0).texels.max())
            total -= float(areas.sum()) * math.log(1 - alpha)
        thickness.append(total)
    np.testing.assert_allclose(thickness, thickness[1], rtol=0.08)


@pytest.mark.parametrize("name", SMOKY)
def test_smoke_is_isotropic_and_faces_camera_and_light_alike(name: str) -> None:
    scene = build(f"{name}[detail=0.1]")
    for item in particles(scene):
        assert item.material.isotropic
        assert min(item.material.albedo) >= 0.9
        assert item.mesh.normals is not None
        normal = item.mesh.normals[0].astype(np.float64)
        to_camera = abs(float(normal @ scene.camera.axes[2]))
        to_light = abs(float(normal @ toward_light(scene, (0, 0, 0))))
        assert to_camera == pytest.approx(to_light, abs=1e-5)
        assert to_camera > 0.7


@pytest.mark.parametrize("name", SMOKY)
def test_another_seed_moves_the_smoke(name: str) -> None:
    first, second = (particles(build(f"{name}[detail=0.1,seed={seed}]")) for seed in (1, 2))
    assert not np.array_equal(first[0].mesh.positions, second[0].mesh.positions)


@pytest.mark.parametrize("detail", ["0.1", "1"])
@pytest.mark.parametrize(("name", "label"), CLOSED)
def test_solids_are_watertight_with_normals_outwards(name: str, label: str, detail: str) -> None:
    item = named(build(f"{name}[detail={detail}]"), label)
    assert item.material.solid
    _, welded = np.unique(item.mesh.positions, axis=0, return_inverse=True)
    triangles = welded.reshape(-1)[item.mesh.triangles]
    edges = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=-1).reshape(-1, 2)
    assert (edges[:, 0] != edges[:, 1]).all()
    # Each edge is run through once in either direction.
    assert len(np.unique(edges, axis=0)) == len(edges)
    assert {tuple(edge) for edge in edges.tolist()} == {
        tuple(edge) for edge in edges[:, ::-1].tolist()
    }
    a, b, c = corners(item.mesh).swapaxes(0, 1)
    assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6 > 1e-3
    normals = item.mesh.normals
    assert normals is not None
    shading = normals[item.mesh.triangles].mean(axis=1)
    assert (np.einsum("ij,ij->i", shading, np.cross(b - a, c - a)) > 0).all()


# Single scenes


def test_trio_shadows_lie_in_plain_view() -> None:
    scene = build("shadow_trio")
    floor = named(scene, "floor")
    for item in scene.transparent:
        middle = center(item)
        toward = toward_light(scene, middle)
        shadow = middle - toward * middle[1] / toward[1]
        local = (shadow - scene.camera.position) @ scene.camera.axes.T
        assert local[1] / -local[2] > -0.8 * math.tan(scene.camera.fov_y / 2)
        ray = (shadow - scene.camera.position)[None]
        assert all(
            meets(other.mesh, scene.camera.position, ray)[0] == 0 for other in scene.transparent
        )
        assert meets(floor.mesh, scene.camera.position, ray)[0] == 1


def test_the_trios_cloud_and_ball_are_side_by_side() -> None:
    scene = build("shadow_trio")
    cloud, ball = (named(scene, name).mesh.positions for name in ("cloud", "ball"))
    assert cloud[:, 0].max() < ball[:, 0].min()
    assert min(cloud[:, 1].min(), ball[:, 1].min()) > 0.2


def test_spheres_differ_in_index_alone_and_hover_in_a_row() -> None:
    scene = build("caustic_spheres")
    solids = scene.transparent
    assert [item.material.index for item in solids] == [1.0, 1.3, 1.5, 1.5]
    assert [item.material.refracts for item in solids] == [False, True, True, True]
    assert solids[0].material.reflectance == 0
    assert len({item.material.transmission for item in solids}) == 1
    assert 0.6 < min(solids[0].material.transmission) < max(solids[0].material.transmission) < 0.95
    spans = [
        (float(x.min()), float(x.max())) for x in (item.mesh.positions[:, 0] for item in solids)
    ]
    assert all(one[1] < other[0] for one, other in itertools.pairwise(spans))
    assert all(0.1 < item.mesh.positions[:, 1].min() < 0.4 for item in solids)


def test_the_spot_light_reaches_every_sphere_and_its_shadow() -> None:
    scene = build("caustic_spheres")
    (spot,) = scene.beams
    assert isinstance(spot, SpotLight)
    axis = np.subtract(spot.target, spot.position)
    axis /= np.linalg.norm(axis)
    for item in scene.transparent:
        rays = item.mesh.positions - np.asarray(spot.position)
        cosine = (rays @ axis) / np.linalg.norm(rays, axis=1)
        assert np.arccos(cosine).max() < 0.9 * spot.angle / 2


def test_the_knot_is_no_ball() -> None:
    knot = named(build("caustic_spheres[detail=0.2]"), "knot of index 1.5")
    line = np.linspace(-0.4, 0.4, 24)
    origins = np.stack(np.meshgrid(line, line, [2.0]), axis=-1).reshape(-1, 3) + center(knot)
    hits = meets_from(knot.mesh, origins, np.array([0.0, 0.0, -1.0]))
    assert hits.max() >= 4
    assert hits[len(hits) // 2] == 0


@pytest.mark.parametrize(("cube", "inside"), [("inside", True), ("above", False)])
def test_the_cube_is_in_the_smoke_or_between_smoke_and_sun(cube: str, inside: bool) -> None:
    scene = build(f"smoke_ball[cube={cube}]")
    (smoke,) = particles(scene)
    block = named(scene, "cube").mesh
    low, high = block.positions.min(axis=0), block.positions.max(axis=0)
    middles = places(smoke)
    within = ((middles > low) & (middles < high)).all(axis=1).sum()
    assert (20 < within < 500) if inside else within == 0
    shaded = meets_from(block, middles, toward_light(scene, (0, 0, 0))) > 0
    # The shadow goes through a part of the smoke, from its sunny side to its far one.
    assert 0.05 < shaded.mean() < 0.5
    if not inside:
        along = middles @ toward_light(scene, (0, 0, 0))
        assert np.ptp(along[shaded]) > 0.8 * np.ptp(along)


def meets_from(mesh: Mesh, origins: Floats, direction: Floats) -> Floats:
    """Count the triangles that rays of one direction meet from each of `origins`."""
    return meets(mesh, origins, np.broadcast_to(direction, origins.shape))


def test_the_left_cloud_shades_a_part_of_the_center_one() -> None:
    scene = build("clouds")
    left, middle = (named(scene, f"{name} cloud") for name in ("left", "center"))
    origins = places(middle)
    layers = meets_from(left.mesh, origins, toward_light(scene, (0, 0, 0)))
    assert 0.1 < (layers >= 3).mean() < 0.6
    assert not scene.opaque


def test_clouds_hover_before_a_blue_sky_with_a_brighter_horizon() -> None:
    scene = build("clouds")
    assert 1400 <= sum(len(item.mesh.triangles) // 2 for item in scene.transparent) <= 1700
    sky = scene.environment
    assert sky is not None
    assert isinstance(sky.radiance, Texture)
    texels = sky.radiance.texels
    zenith, horizon = texels[0, 0], texels[len(texels) // 2 - 1, 0]
    assert zenith[2] > 2 * zenith[0]
    assert horizon.mean() > 2 * zenith.mean()


def test_smoke_dominates_the_fragments_beside_glass() -> None:
    scene = build("smoke_and_glass")
    rays = view_rays(scene.camera, 16)
    depth = {item.name: meets(item.mesh, scene.camera.position, rays) for item in scene.transparent}
    smoke = depth.pop("smoke")
    assert smoke.mean() > 20
    assert (smoke > 10).mean() > 0.9
    assert smoke.sum() > 15 * sum(layers.sum() for layers in depth.values())
    assert all(layers.max() > 0 for layers in depth.values())


def test_glass_beside_smoke_is_sheets_and_refracting_solids_at_full_resolution() -> None:
    glass = [item for item in build("smoke_and_glass").transparent if not item.particles]
    assert sum(item.material.refracts for item in glass) >= 2
    assert sum(not item.material.solid and item.material.tints for item in glass) >= 2


def test_glass_stands_partly_before_and_partly_in_the_smoke() -> None:
    scene = build("smoke_and_glass")
    (smoke,) = particles(scene)
    distance = scene.camera.view_distance(places(smoke))
    for item in scene.transparent:
        if not item.particles:
            depth = float(scene.camera.view_distance(center(item)))
            assert 0.03 < (distance < depth).mean() < 0.97


def test_plastic_is_a_glossy_thin_film() -> None:
    scene = build("bottles[detail=0.1]")
    for item in scene.transparent:
        material = item.material
        assert not material.solid
        assert not material.refracts
        assert 0 < material.reflectance <= 0.1
        assert 0 < max(material.albedo) < 0.1
        assert max(material.transmission) / min(material.transmission) > 1.5


def test_a_bottles_shadow_falls_towards_the_viewer() -> None:
    scene = build("bottles[detail=0.1]")
    for item in scene.transparent:
        middle = center(item)
        toward = toward_light(scene, middle)
        shadow = middle - toward * middle[1] / toward[1]
        assert scene.camera.view_distance(shadow) < scene.camera.view_distance(middle)


# What they share


def test_shared_coverage_keeps_the_transmittance_of_the_whole() -> None:
    assert shared_coverage(0.3, 100, 100) == pytest.approx(0.3)
    assert (1 - shared_coverage(0.3, 100, 250)) ** 250 == pytest.approx(0.7**100)


def test_points_fill_balls_evenly_and_by_volume() -> None:
    random = np.random.default_rng(3)
    points = fill(random, 20000, [(0, 0, 0), (10, 0, 0)], [1.0, 2.0], stretch=(1, 0.5, 1))
    large = points[:, 0] > 5
    assert large.mean() == pytest.approx(8 / 9, abs=0.01)
    local = (points[large] - [10, 0, 0]) / [1, 0.5, 1]
    reach = np.linalg.norm(local, axis=1) / 2
    assert reach.max() <= 1
    # Half the volume of a ball is within 0.5^(1/3) of its radius.
    assert (reach < 0.5 ** (1 / 3)).mean() == pytest.approx(0.5, abs=0.015)


def test_sprites_face_halfway_between_camera_and_light() -> None:
    camera = Camera(position=(0, 0, 5), target=(0, 0, 0))
    random = np.random.default_rng(1)
    for toward, expected in (((0, 1, 0), (0, 1, 1)), ((0, 0.6, -0.8), (0, -0.6, 1.8))):
        mesh = sprites(random, [(0, 0, 0), (1, 2, 3)], [0.5, 2.0], camera, toward)
        assert mesh.normals is not None
        unit = np.asarray(expected) / np.linalg.norm(expected)
        np.testing.assert_allclose(mesh.normals, np.tile(unit, (8, 1)), atol=1e-6)
        edges = np.linalg.norm(mesh.positions[[1, 5]] - mesh.positions[[0, 4]], axis=1)
        np.testing.assert_allclose(edges, [1, 4], rtol=1e-6)


def test_a_gradient_sky_runs_from_below_to_above() -> None:
    sky = gradient_sky([(-90, (0, 0, 0)), (0, (1, 1, 1)), (90, (1, 0, 0))])
    assert isinstance(sky.radiance, Texture)
    texels = sky.radiance.texels
    assert texels.shape == (64, 128, 3)
    np.testing.assert_allclose(texels[0, 5], (1, 1 / 64, 1 / 64), rtol=1e-5)
    np.testing.assert_allclose(texels[-1, 5], 1 / 64, rtol=1e-5)
    assert (texels == texels[:, :1]).all()
