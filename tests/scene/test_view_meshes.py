"""Squares and ribbons that face the camera."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from oitbench.errors import SceneError
from oitbench.fingerprints.scene import scene_fingerprint
from oitbench.scene import Camera, Floats, Material, Mesh, Object, Scene, Sprites, Strands

PINHOLE = Camera((0.3, 0.2, 5.0), (0.1, 0.0, 0.0), fov_y=0.8)
FLAT = replace(PINHOLE, height=4.0)
CENTERS = [(0.0, 0.0, 0.0), (1.0, 2.0, 3.0)]


def test_sprites_face_halfway_between_camera_and_light() -> None:
    camera = Camera(position=(0, 0, 5), target=(0, 0, 0))
    for toward, expected in (((0, 1, 0), (0, 1, 1)), ((0, 0.6, -0.8), (0, -0.6, 1.8))):
        mesh = Sprites(CENTERS, [0.5, 2.0], [0.3, 1.0], toward).for_view(camera, 1)
        assert mesh.normals is not None
        unit = np.asarray(expected) / np.linalg.norm(expected)
        np.testing.assert_allclose(mesh.normals, np.tile(unit, (8, 1)), atol=1e-6)
        edges = np.linalg.norm(mesh.positions[[1, 5]] - mesh.positions[[0, 4]], axis=1)
        np.testing.assert_allclose(edges, [1, 4], rtol=1e-6)


@pytest.mark.parametrize("position", [(5.0, 1.0, 0.0), (0.0, 9.0, 0.0), (-1.0, -2.0, -3.0)])
def test_sprites_face_any_camera(position: tuple[float, float, float]) -> None:
    camera = Camera(position, (0.0, 0.5, 0.0))
    mesh = Sprites(CENTERS, 0.5).for_view(camera, 1)
    assert mesh.normals is not None
    np.testing.assert_allclose(mesh.normals, np.tile(camera.axes[2], (8, 1)), atol=1e-6)
    np.testing.assert_allclose(mesh.positions.reshape(2, 4, 3).mean(1), CENTERS, atol=1e-12)


def curves(random: np.random.Generator, count: int = 5, length: int = 7) -> Floats:
    """Return smooth curves around the origin."""
    turn = np.linspace(0, 1.5, length)[:, None] * random.normal(size=(count, 1, 3))
    return np.asarray(random.normal(size=(count, 1, 3)) * 0.5 + 0.3 * np.sin(turn))


def in_picture(camera: Camera, points: Floats, rows: int) -> Floats:
    """Return the places of points in pixels right and up."""
    place = (points - np.asarray(camera.position)) @ camera.axes[:2].T
    shown = 1.0 if camera.orthographic else camera.view_distance(points)[..., None]
    return np.asarray(place / shown * rows / camera.span)


@pytest.mark.parametrize("camera", [PINHOLE, FLAT], ids=["perspective", "orthographic"])
@pytest.mark.parametrize("thin", [True, False])
def test_ribbons_have_their_width_but_at_least_a_pixel(camera: Camera, thin: bool) -> None:
    points, rows = curves(np.random.default_rng(4)), 100
    width = 1e-3 if thin else 0.2
    mesh = Strands(points, width).for_view(camera, rows)
    assert mesh.coverage is not None
    n, k = points.shape[:2]
    edges = in_picture(camera, mesh.positions.reshape(n, k, 2, 3), rows)
    middle = in_picture(camera, points, rows)
    np.testing.assert_allclose(edges.mean(axis=2), middle, atol=1e-9)
    along = np.diff(middle, axis=1)
    along /= np.linalg.norm(along, axis=2, keepdims=True)
    # Distance of both edges from the line through each segment: at either end, half of the width.
    pixel = camera.pixel_size(points, rows)
    expected = np.maximum(width / pixel, 1.0)
    for end in (np.s_[:-1], np.s_[1:]):
        side = edges[:, end, 1] - edges[:, end, 0]
        across = side[..., 0] * along[..., 1] - side[..., 1] * along[..., 0]
        np.testing.assert_allclose(across, expected[:, end], rtol=1e-9)
    cover = np.repeat(np.minimum(width / pixel, 1.0), 2)
    np.testing.assert_allclose(mesh.coverage, cover, rtol=1e-6)
    assert thin == bool((mesh.coverage < 1).all())


def test_strips_share_their_joints_and_their_faces_look_at_the_camera() -> None:
    points = curves(np.random.default_rng(2))
    mesh = Strands(points, 0.01).for_view(PINHOLE, 600)
    assert len(mesh.positions) == points.shape[0] * points.shape[1] * 2
    a, b, c = mesh.positions[mesh.triangles].swapaxes(0, 1)
    facing = np.einsum("ij,ij->i", np.cross(b - a, c - a), np.asarray(PINHOLE.position) - a)
    assert (facing > 0).all()
    assert mesh.normals is not None
    along = np.repeat(np.gradient(points, axis=1).reshape(-1, 3), 2, axis=0)
    np.testing.assert_allclose(np.einsum("ij,ij->i", mesh.normals, along), 0, atol=1e-6)


def test_a_strand_along_the_line_of_sight_is_drawn() -> None:
    points = np.array([[(0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 2.0)]])
    mesh = Strands(points, 0.1).for_view(Camera((0, 0, 5)), 50)
    assert np.isfinite(mesh.positions).all()
    assert mesh.normals is not None
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1, atol=1e-6)


def test_a_sharp_turn_has_a_bounded_miter() -> None:
    points = np.array([[(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1e-3, 0.0)]])
    mesh = Strands(points, 0.1).for_view(FLAT, 1000)
    reach = np.linalg.norm(mesh.positions[2:4] - points[0, 1], axis=1)
    assert reach.max() <= 0.1 + 1e-9


def scene(mesh: Mesh) -> Scene:
    return Scene("s", PINHOLE, (Object("it", mesh, Material(coverage=0.5)),))


@pytest.mark.parametrize("mesh", [Sprites(CENTERS, 0.5, 0.2, (0, 1, 1)), Strands([CENTERS], 0.01)])
def test_a_scene_is_resolved_once_in_any_unit(mesh: Sprites | Strands) -> None:
    described = scene(mesh)
    resolved = described.resolved(64)
    found = resolved.objects[0].mesh
    assert type(found) is Mesh
    assert resolved.resolved(32) is resolved
    small = replace(scene(mesh.relocated((0, 0, 0), 1000.0)), meters_per_unit=0.001)
    small = replace(small, camera=PINHOLE.relocated((0, 0, 0), 1000.0))
    again = small.resolved(64).in_meters().objects[0].mesh
    np.testing.assert_allclose(again.positions, found.positions, atol=1e-9)
    assert isinstance(small.in_meters().objects[0].mesh, type(mesh))


def test_the_fingerprint_is_that_of_the_generator() -> None:
    sprites = Sprites(CENTERS, 0.5, 0.2)
    assert scene_fingerprint(scene(sprites)) == scene_fingerprint(scene(Sprites(CENTERS, 0.5, 0.2)))
    changed = [Sprites(CENTERS, 0.5, 0.3), Sprites(CENTERS, 0.4, 0.2), Strands([CENTERS], 0.5)]
    changed.append(Sprites(CENTERS, 0.5, 0.2, (0, 1, 0)))
    found = {scene_fingerprint(scene(mesh)) for mesh in (sprites, *changed)}
    assert len(found) == 5
    moved = np.asarray(CENTERS) + 1e-12
    assert scene_fingerprint(scene(Sprites(moved, 0.5, 0.2))) in found


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Sprites([(0, 0)], 1.0), "centers must be"),
        (lambda: Sprites(CENTERS, [1.0]), "radii must be"),
        (lambda: Sprites(CENTERS, 0.0), "radii must be above 0"),
        (lambda: Sprites(CENTERS, 1.0, toward_light=(0, 0, 0)), "no length"),
        (lambda: Strands([[(0, 0, 0)]], 1.0), "k above 1"),
        (lambda: Strands([CENTERS], [1.0, 2.0, 3.0]), "width must be"),
        (lambda: Strands([CENTERS], -1.0), "width must be above 0"),
        (lambda: Strands([CENTERS], 1.0, np.ones((2, 3))), "radiances must be"),
        (lambda: Strands([CENTERS], 1.0, -np.ones((1, 2, 3))), "light is 0 or more"),
    ],
)
def test_wrong_values_are_refused(make: object, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        make()  # type: ignore[operator]


def test_strands_need_the_height_of_the_picture() -> None:
    with pytest.raises(ValueError, match="height of the picture"):
        scene(Strands([CENTERS], 0.1)).resolved(0)
