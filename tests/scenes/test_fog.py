"""Frosted door, foggy street, atrium and light shafts show what they are named for."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest

from oitbench.effects import Effect
from oitbench.modeling.placement import merge
from oitbench.modeling.props.architecture import arch, column, window_wall
from oitbench.modeling.props.lettering import lettering
from oitbench.modeling.props.people import limb, man, woman
from oitbench.path_traced.export.scene import _require_distinct
from oitbench.plugins import Collection
from oitbench.scene import DirectionalLight, Mesh, Object, Scene, SpotLight

COLLECTION = Collection.load()
NAMES = ("frosted_door", "foggy_street", "atrium_fog", "light_shafts")
FOGGY = NAMES[1:]
MOST_TRIANGLES = 60_000
TRANSLUCENT = Effect.COVERAGE | Effect.SHADOWS | Effect.TRANSLUCENT_SHADOWS
COLORED = TRANSLUCENT | Effect.COLORED_TRANSMISSION | Effect.COLORED_SHADOWS
EFFECTS = {
    "frosted_door": COLORED | Effect.DIFFUSION,
    "frosted_door[collimation=1]": COLORED,
    "foggy_street": TRANSLUCENT | Effect.DIFFUSION | Effect.VOLUME,
    "foggy_street[collimation=1]": TRANSLUCENT | Effect.VOLUME,
    "atrium_fog": Effect.VOLUME,
    "light_shafts": COLORED | Effect.VOLUME,
}


def build(text: str) -> Scene:
    return COLLECTION.build_scene(text)


def named(scene: Scene, name: str) -> Object:
    return next(item for item in scene.objects if item.name == name)


def triangles(scene: Scene) -> int:
    return sum(len(item.mesh.triangles) for item in scene.objects)


def corners(mesh: Mesh) -> npt.NDArray[np.float64]:
    return mesh.positions.astype(np.float64)[mesh.triangles]


def met(mesh: Mesh, start: npt.ArrayLike, ray: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Return where along `ray` from `start` it meets the mesh, ascending (Möller-Trumbore)."""
    origin, along = np.asarray(start, dtype=np.float64), np.asarray(ray, dtype=np.float64)
    a, b, c = corners(mesh).swapaxes(0, 1)
    normal = np.cross(b - a, c - a)
    scale = normal @ along
    level = np.abs(scale) < 1e-12
    scale[level] = 1.0
    offset = np.cross(origin - a, along)
    u = -np.einsum("ij,ij->i", c - a, offset) / scale
    v = np.einsum("ij,ij->i", b - a, offset) / scale
    at = np.einsum("ij,ij->i", a - origin, normal) / scale
    return np.sort(at[~level & (u >= 0) & (v >= 0) & (u + v <= 1) & (at > 0)])


# All four


@pytest.mark.parametrize(("text", "effects"), EFFECTS.items())
def test_scenes_call_for_the_effects_they_are_made_for(text: str, effects: Effect) -> None:
    name, _, rest = text.partition("[")
    for detail in ("0.1", "1"):
        assert build(f"{name}[detail={detail}{',' if rest else ']'}{rest}").effects == effects


@pytest.mark.parametrize("name", NAMES)
def test_detail_adds_triangles_within_bounds(name: str) -> None:
    coarse, fine = (triangles(build(f"{name}[detail={detail}]")) for detail in (0.1, 1))
    assert 1.5 * coarse < fine < MOST_TRIANGLES


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("detail", ["0.1", "1"])
def test_no_triangles_coincide(name: str, detail: str) -> None:
    _require_distinct(build(f"{name}[detail={detail}]"))


@pytest.mark.parametrize("name", NAMES)
def test_only_the_atrium_glows_instead_of_being_lit(name: str) -> None:
    scene = build(f"{name}[detail=0.1]")
    assert scene.lights
    baked = [item.mesh.radiance is not None for item in scene.objects]
    assert set(baked) == {name == "atrium_fog"}
    assert all(item.mesh.normals is not None for item in scene.objects)


@pytest.mark.parametrize("name", NAMES)
def test_lights_shine_from_outside_of_what_casts_shadows(name: str) -> None:
    scene = build(f"{name}[detail=0.1]")
    casters = merge([item.mesh for item in scene.opaque if item.casts])
    for light in scene.beams:
        if isinstance(light, SpotLight):
            reach = met(casters, light.position, np.subtract(light.target, light.position))
            assert not len(reach) or reach[0] > 0.1


@pytest.mark.parametrize("name", FOGGY)
def test_the_camera_is_in_the_fog_and_no_surface_in_a_face_of_its_box(name: str) -> None:
    scene = build(f"{name}[detail=0.1]")
    fog = scene.medium
    assert fog is not None
    assert (np.subtract(scene.camera.position, fog.low) > 0).all()
    assert (np.subtract(fog.high, scene.camera.position) > 0).all()
    for item in scene.objects:
        points = corners(item.mesh)
        for axis in range(3):
            for face in (fog.low[axis], fog.high[axis]):
                assert not (np.abs(points[:, :, axis] - face) < 1e-3).all(axis=1).any()


@pytest.mark.parametrize("name", ["foggy_street", "atrium_fog", "light_shafts"])
def test_extinction_is_a_parameter(name: str) -> None:
    fog = build(f"{name}[detail=0.1,extinction=0.02]").medium
    assert fog is not None
    assert fog.extinction == 0.02


@pytest.mark.parametrize("name", ["foggy_street", "light_shafts"])
def test_densities_vary_within_their_range(name: str) -> None:
    fog = build(f"{name}[detail=0.1]").medium
    assert fog is not None
    assert fog.density is not None
    assert fog.density.min() >= 0
    assert 0.3 < fog.density.max() <= 1
    assert fog.density.max() > 2 * fog.density.min()
    # Clipped densities would show as flat banks of fog.
    assert (fog.density == 1).mean() < 0.01


# frosted_door


def test_people_stand_at_two_distances_behind_one_pane() -> None:
    scene = build("frosted_door")
    (pane,) = scene.transparent
    assert np.ptp(pane.mesh.positions[:, 2]) == 0
    behind = {name: -named(scene, name).mesh.positions[:, 2].max() for name in ("woman", "man")}
    assert 0 < behind["woman"] < 0.05
    assert behind["man"] > 1.9
    assert -named(scene, "far window").mesh.positions[:, 2].max() > 2 * behind["man"]


def test_only_the_hand_is_near_the_glass() -> None:
    points = named(build("frosted_door"), "woman").mesh.positions
    near = points[points[:, 2] > -0.09]
    assert np.ptp(near[:, 1]) < 0.3
    assert (points[:, 2] < -0.2).mean() > 0.5


@pytest.mark.parametrize("name", ["lettering", "frame", "office wall"])
def test_what_stays_sharp_covers_the_pane_from_the_front(name: str) -> None:
    scene = build("frosted_door")
    mesh, eye = named(scene, name).mesh, np.asarray(scene.camera.position)
    pane = named(scene, "pane").mesh.positions
    for triangle in corners(mesh):
        middle = triangle.mean(axis=0)
        at = eye + (middle - eye) * (eye[2] / (eye[2] - middle[2]))
        through = (at[:2] > pane[:, :2].min(axis=0)).all() and (
            at[:2] < pane[:, :2].max(axis=0)
        ).all()
        # What lies behind the plane of the pane is hidden by its own front.
        assert not through or middle[2] > 0 or len(met(mesh, eye, middle - eye)) > 1


def test_lettering_is_in_front_of_the_pane_alone() -> None:
    scene = build("frosted_door")
    letters, pane = named(scene, "lettering").mesh.positions, named(scene, "pane").mesh.positions
    assert 0 < letters[:, 2].min() <= letters[:, 2].max() < 0.02
    for axis in (0, 1):
        assert pane[:, axis].min() < letters[:, axis].min()
        assert letters[:, axis].max() < pane[:, axis].max()


# foggy_street


def test_the_woman_is_near_and_the_man_deep_in_the_fog() -> None:
    scene = build("foggy_street")
    depth = {
        name: scene.camera.view_distance(named(scene, name).mesh.positions).mean()
        for name in ("woman", "man")
    }
    assert depth["man"] > 2 * depth["woman"]
    assert _optical_depth(scene, depth["woman"]) < 0.25
    assert _optical_depth(scene, depth["man"]) > 2.5 * _optical_depth(scene, depth["woman"])
    assert _optical_depth(scene, 60.0) > 2


def _optical_depth(scene: Scene, distance: float) -> float:
    """Return the fog's along the street from the camera, from the cells that it passes."""
    fog = scene.medium
    assert fog is not None
    assert fog.density is not None
    steps = -(np.arange(1000) + 0.5) / 1000 * distance
    points = np.asarray(scene.camera.position) + np.stack([0 * steps, 0 * steps, steps], axis=1)
    span = np.subtract(fog.high, fog.low)
    cells = ((points - fog.low) / span * fog.density.shape[::-1]).astype(int)
    passed = fog.density[cells[:, 2], cells[:, 1], cells[:, 0]]
    return float(passed.mean() * distance * fog.extinction)


def test_lamps_recede_and_shine_down_from_below_their_bulbs() -> None:
    scene = build("foggy_street")
    bulbs = named(scene, "bulbs").mesh.positions
    assert np.ptp(scene.camera.view_distance(bulbs)) > 40
    spots = [light for light in scene.beams if isinstance(light, SpotLight)]
    assert len(spots) == len(scene.beams) == 2
    for light in spots:
        gap = np.linalg.norm(bulbs - np.asarray(light.position), axis=1)
        assert 0 < gap.min() < 0.1
        assert light.target[1] < light.position[1]


def test_leaves_cover_partly_and_transmit_nothing() -> None:
    (leaves,) = build("foggy_street").transparent
    assert leaves.material.binary_coverage
    assert leaves.material.transmission == (0, 0, 0)


def test_another_seed_lights_other_windows() -> None:
    one, other = (named(build(f"foggy_street[seed={seed}]"), "warm windows") for seed in (1, 2))
    assert not np.array_equal(one.mesh.positions, other.mesh.positions)


# atrium_fog


def test_the_fog_of_the_atrium_has_a_closed_form() -> None:
    scene = build("atrium_fog[detail=0.1]")
    assert scene.lights == (scene.environment,)
    fog = scene.medium
    assert fog is not None
    assert fog.density is None
    assert fog.anisotropy == 0
    assert fog.collimation == 1


def test_banners_of_one_paint_hang_at_several_distances() -> None:
    scene = build("atrium_fog[detail=0.1]")
    for paint in ("red", "blue", "green"):
        positions = named(scene, f"{paint} banners").mesh.positions
        assert len(np.unique(positions[:, 2])) >= 3
        assert np.ptp(scene.camera.view_distance(positions)) > 6


# light_shafts


def test_the_sun_comes_through_windows_and_nowhere_else() -> None:
    scene = build("light_shafts")
    (sun,) = (light for light in scene.beams if isinstance(light, DirectionalLight))
    casters = merge([item.mesh for item in scene.opaque if item.casts])
    toward = -np.asarray(sun.direction)
    assert toward[2] < 0  # the sun stands before the camera
    random = np.random.default_rng(7)
    lit = 0
    for _ in range(300):
        point = random.uniform((-3.9, 0.05, -11.9), (3.9, 6.1, 1.0))
        if len(met(casters, point, toward)):
            continue
        lit += 1
        side, end = ((4.25 - point[0]) / toward[0], (-12.25 - point[2]) / toward[2])
        x, y, z = point + min(side, end) * toward
        assert 1.1 < y < 4.95
        across = (z + 12) % 3 - 1.5 if side < end else x % 4 - 2
        assert np.abs(across) < 0.65
    assert 0.03 < lit / 300 < 0.4


def test_colored_light_falls_on_the_floor_before_the_camera() -> None:
    scene = build("light_shafts")
    (sun,) = (light for light in scene.beams if isinstance(light, DirectionalLight))
    casters = merge([item.mesh for item in scene.opaque if item.casts])
    toward = -np.asarray(sun.direction)
    for name in ("blue glass", "gold glass"):
        pane = named(scene, name).mesh.positions.astype(np.float64)
        low, high = pane.min(axis=0), pane.max(axis=0)
        lit = []
        for u in np.linspace(0.1, 0.9, 9):
            for v in np.linspace(0.1, 0.9, 5):
                point = low + (high - low) * [0, v, u]
                floor = point - toward * (point[1] / toward[1])
                if not len(met(casters, floor + 1e-3 * toward, toward)):
                    lit.append(floor)
        assert lit
        offset = np.asarray(lit) - np.asarray(scene.camera.position)
        x, y = (offset @ scene.camera.axes[:2].T).T
        half = scene.camera.view_distance(lit) * math.tan(scene.camera.fov_y / 2)
        assert ((np.abs(y) < half) & (np.abs(x) < 4 / 3 * half)).any()


def test_the_statue_is_partly_in_shadow() -> None:
    scene = build("light_shafts")
    (sun,) = (light for light in scene.beams if isinstance(light, DirectionalLight))
    casters = merge([item.mesh for item in scene.opaque if item.casts])
    statue = named(scene, "statue").mesh
    assert statue.normals is not None
    toward = -np.asarray(sun.direction)
    facing = np.flatnonzero(statue.normals @ toward > 0.3)[::40]
    starts = statue.positions[facing] + 0.01 * statue.normals[facing]
    lit = np.mean([not len(met(casters, start, toward)) for start in starts])
    assert 0.15 < lit < 0.85


# Parts


def test_parts_have_normals_that_fit_their_triangles() -> None:
    parts = [
        column(3, 0.3, 1),
        arch(3, 2, 2, 0.5, 12),
        window_wall(3, 6, 0.5, 1.2, 1, 4, 12),
        lettering("PRIVATE EYE", (0, 0, 0), 0.2, 0.03),
        woman(1),
        man(1),
        limb((0, 0, 0), (0.1, -0.5, 0.2), 0.05, 0.03, 1),
        limb((0, 0.5, 0), (0, 0, 0), 0.05, 0.03, 1),
    ]
    for part in parts:
        assert part.normals is not None
        a, b, c = corners(part).swapaxes(0, 1)
        flat = np.cross(b - a, c - a)
        shading = part.normals[part.triangles].mean(axis=1)
        agree = np.einsum("ij,ij->i", flat, shading) > 0
        # Where a lathe turns sharply, shading rounds the edge off.
        assert agree.mean() > 0.97
        np.testing.assert_allclose(np.linalg.norm(part.normals, axis=1), 1, atol=1e-4)


def test_a_window_wall_has_one_opening() -> None:
    wall = window_wall(3, 6, 0.5, 1.2, 1, 4, 24)
    for x, y, hits in ((0.1, 3, 0), (0.1, 4.5, 0), (0.1, 0.5, 2), (1.2, 3, 2), (0.1, 5, 2)):
        assert len(met(wall, (x, y + 0.017, 5), (0, 0, -1))) == hits
    assert wall.positions.min(axis=0).tolist() == [-1.5, 0, -0.25]
    assert wall.positions.max(axis=0).tolist() == [1.5, 6, 0.25]


def test_an_arch_is_open_below() -> None:
    bay = arch(3, 2, 2, 0.5, 24)
    for x, y, hits in ((0.1, 0.9, 0), (0.9, 0.2, 0), (1.2, 0.1, 2), (0.1, 1.5, 2)):
        assert len(met(bay, (x, y + 0.013, 5), (0, 0, -1))) == hits


def test_reveals_face_into_their_openings() -> None:
    for bay, middle in ((arch(3, 2, 2, 0.5, 24), 0), (window_wall(3, 6, 0.5, 1.2, 1, 4, 24), 3)):
        assert bay.normals is not None
        reveal = bay.normals[:, 2] == 0
        inward = np.array([0, middle, 0]) - bay.positions[reveal]
        # The springing line of an arch lies in the plane of its middle, and faces down.
        assert (np.einsum("ij,ij->i", inward, bay.normals[reveal]) > -1e-6).all()
        assert reveal.sum() >= 4 * 24


def test_letters_without_a_glyph_are_refused() -> None:
    with pytest.raises(ValueError, match="glyph for Q"):
        lettering("QUIET", (0, 0, 0), 0.2, 0.03)


def test_people_stand_on_the_ground_at_their_heights() -> None:
    for figure, height in ((woman(1), 1.78), (man(1), 1.88)):
        low, high = figure.positions[:, 1].min(), figure.positions[:, 1].max()
        assert 0 <= low < 0.06
        assert high == pytest.approx(height, abs=0.03)
