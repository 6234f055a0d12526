"""The depth test passes the fragments that are nearer than the opaque ones in exact arithmetic."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from oitbench.gl.device import Device
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.modeling.mesh import quad
from oitbench.scene import Camera, Floats, Material, Mesh, Object, Scene
from tests.helpers import foreign_method as foreign
from tests.helpers import method, opened, render, rounding, write_method

SIZE = (24, 16)
WALL = Material(emission=(0.0, 1.0, 0.0))
HALF = Material(coverage=0.5, emission=(1.0, 0.0, 0.0))
VIEWS = [(0.0, 0.0, -1.0), (1.0, -2.0, 0.5), (-0.3, 0.1, 0.2)]
EXACT = ["a_buffer", "depth_peeling[precision=float]", "dual_depth_peeling", "sorted_over"]


def camera(ahead: tuple[float, float, float], **parts: Any) -> Camera:
    return Camera((3.0, 2.0, 1.0), (3 + ahead[0], 2 + ahead[1], 1 + ahead[2]), **parts)


def placed(seen: Camera, points: Any) -> Floats:
    """Return world positions of points in camera space."""
    return np.asarray(np.asarray(seen.position) + np.asarray(points, dtype=np.float64) @ seen.axes)


def triangle(seen: Camera, corners: Any) -> Mesh:
    return Mesh.from_arrays(placed(seen, corners), [[0, 1, 2]])


def facing(seen: Camera, distance: float) -> Mesh:
    """Return a triangle that faces the camera and fills its view."""
    side = 4 * distance
    return triangle(
        seen, [(-side, -side, -distance), (side, -side, -distance), (0, side, -distance)]
    )


def counts(device: Device, seen: Camera, wall: Mesh, sheets: list[Mesh]) -> Any:
    objects = [Object("wall", wall, WALL)]
    objects += [Object(str(k), sheet, HALF) for k, sheet in enumerate(sheets)]
    with UploadedScene(device, Scene("depth", seen, tuple(objects))) as uploaded:
        return uploaded.fragment_counts(SIZE)


@pytest.mark.parametrize("ahead", VIEWS)
@pytest.mark.parametrize("far", [math.inf, 2e4])
@pytest.mark.parametrize("near", [0.1, 1e-4])
@pytest.mark.parametrize("distance", [1.0, 37.0, 1e4])
def test_facing_surfaces_are_distinguished_by_a_millionth_of_their_distance(
    device: Device, distance: float, near: float, far: float, ahead: tuple[float, float, float]
) -> None:
    seen = camera(ahead, near=near, far=far)
    gaps = np.array([-1e-2, -1e-4, -1e-5, -3e-6, -1e-6, 1e-6, 2e-6, 1e-5, 1e-4, 1e-2])
    sheets = [facing(seen, distance * (1 + gap)) for gap in gaps]
    found = counts(device, seen, facing(seen, distance), sheets)
    np.testing.assert_array_equal(found, (gaps < 0).sum())


@pytest.mark.parametrize("ahead", VIEWS)
@pytest.mark.parametrize("seed", range(4))
def test_oblique_surfaces_are_distinguished_by_a_ten_thousandth(
    device: Device, seed: int, ahead: tuple[float, float, float]
) -> None:
    seen, random = camera(ahead), np.random.default_rng(seed)
    near, far = 10.0, 100.0
    # Corners outside of the view, in distances from 1 to 10 times the nearest.
    slopes = np.array([(-1.5, -1.5), (1.5, -1.2), (0.2, 1.9)])
    distances = random.permutation([near, math.sqrt(near * far), far])
    corners = np.column_stack([slopes, -np.ones(3)]) * distances[:, None]
    # Other triangles of the same planes: corners that are weighted means, and beyond.
    other = np.array([(1.2, -0.1, -0.1), (-0.1, 1.2, -0.1), (-0.1, -0.1, 1.2)])
    scales = np.array([0.9, 1 - 1e-3, 1 - 1e-4, 1 + 1e-4, 1 + 1e-3, 1.1])
    sheets = [triangle(seen, other @ corners * scale) for scale in scales]
    found = counts(device, seen, triangle(seen, corners), sheets)
    covered = _inside(corners)
    assert covered.mean() > 0.3
    np.testing.assert_array_equal(found[covered], (scales < 1).sum())


def _inside(corners: Floats) -> Any:
    """Return the pixels whose centers lie within a triangle in camera space, bottom row first."""
    focal = SIZE[1] / 2 / math.tan(math.radians(45) / 2)
    x, y = np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1]))
    across, up = (x + 0.5 - SIZE[0] / 2) / focal, (y + 0.5 - SIZE[1] / 2) / focal
    rays = np.stack([across, up, -np.ones_like(up)], axis=-1)
    sides = np.stack(
        [np.einsum("hwc,c->hw", rays, np.cross(corners[i], corners[i - 2])) for i in range(3)]
    )
    return (sides > 1e-6).all(axis=0) | (sides < -1e-6).all(axis=0)


@pytest.mark.parametrize("chosen", EXACT)
@pytest.mark.parametrize(("share", "expected"), [(-1e-3, (0.5, 0.5, 0.0)), (1e-3, (0.0, 1.0, 0.0))])
def test_a_sheet_close_to_a_far_wall_is_composited(
    device: Device, chosen: str, share: float, expected: tuple[float, float, float]
) -> None:
    seen = camera(VIEWS[1], near=0.1)
    objects = (
        Object("wall", facing(seen, 1e4), WALL),
        Object("sheet", facing(seen, 1e4 * (1 + share)), HALF),
    )
    image = render(device, Scene("far", seen, objects), chosen, size=SIZE)
    # Emission is 1 but for the last bit, which drivers may truncate to a half float below 1.
    allowed = max(1e-6, rounding(method(chosen), 1, 1.0))
    np.testing.assert_allclose(image, np.broadcast_to(expected, image.shape), rtol=0, atol=allowed)


@pytest.mark.parametrize("far", [math.inf, 8.0])
def test_a_shader_sees_the_documented_depths(device: Device, tmp_path: Any, far: float) -> None:
    seen = Camera((0, 0, 0), (0, 0, -1), near=0.5, far=far)
    passes = """(
        Gather("show.glsl", reads=("opaque_depth",), writes={"seen": REPLACE}),
        Resolve("sky.glsl", reads=("opaque_depth",), writes={"behind": REPLACE}),
    )"""
    targets = '{"seen": Target("rgba32f"), "behind": Target("rgba32f")}'
    show = """void gather(Fragment fragment) {
        seen = vec4(fragment.z, fragment.depth, fragment.inverse_depth,
                    view_distance(read_opaque_depth()));
    }"""
    sky = """void resolve() {
        float z = view_distance(read_opaque_depth());
        behind = vec4(z, inverse_depth_at(z), read_opaque_depth(), 0.0);
    }"""
    chosen = foreign(write_method(tmp_path / "shown", passes, targets, show=show, sky=sky))
    wall = Object("wall", quad((0, 0, -5), (9, 0, 0), (0, 9, 0)), WALL)
    sheet = Object("sheet", quad((0, 0, -2), (9, 0, 0), (0, 9, 0)), HALF)
    span = 1 - 0.5 / far
    with opened(device, Scene("d", seen, (wall, sheet)), chosen, SIZE) as frame:
        frame.render()
        depth = (1 - 0.5 / 2) / span
        wanted = np.array([2, depth, 1 - depth, 5])
        np.testing.assert_allclose(frame.read("seen"), np.tile(wanted, (16, 24, 1)), rtol=1e-6)
        stored = (0.5 / 5 - 0.5 / far) / span
        wanted = np.array([5, stored, stored, 0])
        np.testing.assert_allclose(frame.read("behind"), np.tile(wanted, (16, 24, 1)), rtol=1e-6)
    with opened(device, Scene("d", seen, (sheet,)), chosen, SIZE) as frame:
        frame.render()
        empty = frame.read("behind")
    assert (empty[..., 2] == 0).all()
    expected = 8 if far == 8 else 1e30
    np.testing.assert_allclose(empty[..., 0], expected, rtol=1e-5)


def test_surfaces_beyond_the_far_plane_are_not_drawn(device: Device) -> None:
    seen = camera(VIEWS[0], far=10.0)
    sheets = [facing(seen, distance) for distance in (5.0, 9.999, 10.001, 20.0)]
    far = facing(seen, 30.0)
    assert (counts(device, seen, far, sheets) == 2).all()
