"""Surfaces in one plane: decals on opaque surfaces, and transparent layers on each other."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from oitbench.effects import Effect
from oitbench.errors import CapabilityError
from oitbench.gl.device import Device
from oitbench.modeling.mesh import grid, quad
from oitbench.scene import Camera, DirectionalLight, Floats, Material, Mesh, Object, Scene
from oitbench.scene.coincidence import find_coincidence
from tests.helpers import assert_order_independent, opened, render

SIZE = (48, 32)
CAMERA = Camera((0.3, 0.2, 1.0), (0.2, 0.3, -1.0))
WHITE = Material(emission=(1.0, 1.0, 1.0))
RED = Material(coverage=0.5, emission=(1.0, 0.0, 0.0))
BLUE = Material(coverage=0.5, emission=(0.0, 0.0, 1.0))
EXACT = ["a_buffer", "a_buffer[resolve=iterative]", "depth_peeling[precision=float]"]
OTHERS = ["dual_depth_peeling", "sorted_over", "weighted_average", "k_buffer", "stochastic"]
TILTS = [0.0, 0.37, 5.0]


def plane(tilt: float, side: float, cells: int = 1, turned: bool = False) -> Mesh:
    """Return a square in a plane through (0, 0, −3), with other triangles for other `cells`."""
    right, up = np.array((side, 0, 0)), np.array((0, side, side * tilt))
    center = np.array((0.0, 0.0, -3.0))
    if turned:
        right, up = up, right
    if cells == 1:
        return quad(tuple(center), tuple(right), tuple(up))
    return grid(tuple(center), tuple(right), tuple(up), cells, 2 * cells + 1)


def decal(tilt: float, *, turned: bool = False, material: Material = RED, **parts: Any) -> Scene:
    objects = (
        Object("wall", plane(tilt, 20.0), WHITE),
        Object("decal", plane(tilt, 15.0, 3, turned), material, **parts),
    )
    return Scene("decal", CAMERA, objects)


@pytest.mark.parametrize("tilt", TILTS)
@pytest.mark.parametrize("chosen", [*EXACT, *OTHERS[:3]])
def test_a_decal_is_before_its_wall_where_it_faces_the_viewer(
    device: Device, chosen: str, tilt: float
) -> None:
    front = render(device, decal(tilt), chosen, size=SIZE)
    wall = render(device, Scene("w", CAMERA, decal(tilt).objects[:1]), chosen, size=SIZE)
    covered = wall[..., 1] > 0.99
    if tilt < 1:
        assert covered.all()
    expected = np.where(covered[..., None], (1.0, 0.5, 0.5), 0.0)
    middle = np.s_[8:24, 12:36]
    np.testing.assert_allclose(front[middle], expected[middle], atol=2e-3)
    back = render(device, decal(tilt, turned=True), chosen, size=SIZE)
    np.testing.assert_allclose(back[middle], wall[middle], atol=2e-3)


def test_a_decal_casts_no_speckle_under_lights(device: Device) -> None:
    lit = Material(coverage=0.5, albedo=(0.8, 0.1, 0.1), specular=0.0)
    scene = decal(0.37, material=lit)
    wall = Object("wall", scene.objects[0].mesh, Material(albedo=(0.8, 0.8, 0.8), specular=0.0))
    lamp = DirectionalLight((0.2, -0.5, -1.0), (2.0, 2.0, 2.0))
    scene = Scene("lit", CAMERA, (wall, scene.objects[1]), lights=(lamp,))
    image = render(device, scene, "a_buffer", size=SIZE, effects=Effect.COVERAGE)
    middle = image[8:24, 12:36]
    assert np.ptp(middle.reshape(-1, 3), axis=0).max() < 1e-5


@pytest.mark.parametrize("tilt", TILTS)
@pytest.mark.parametrize("swapped", [False, True])
def test_two_transparent_layers_in_one_plane_are_ordered_by_content(
    device: Device, tilt: float, swapped: bool
) -> None:
    objects = (
        Object("red", plane(tilt, 15.0, 3), RED),
        Object("blue", plane(tilt, 18.0, turned=True), BLUE),
    )
    scene = Scene("two", CAMERA, objects[::-1] if swapped else objects, background=(0, 1, 0))
    with opened(device, scene, "a_buffer", SIZE) as frame:
        assert_order_independent(frame, 3)
        image = frame.image()[8:24, 12:36].reshape(-1, 3)
    # By alpha L channel by channel: blue, (0, 0, 1/2), is before red.
    np.testing.assert_allclose(image, np.tile((0.25, 0.25, 0.5), (len(image), 1)), atol=1e-6)


def test_a_declared_decal_takes_the_plane_of_its_object(device: Device) -> None:
    scene, random = decal(0.37), np.random.default_rng(1)
    mesh = scene.objects[1].mesh
    noise = random.normal(scale=1e-6, size=mesh.positions.shape)
    rough = Mesh.from_arrays(mesh.positions + noise, mesh.triangles)
    wall = scene.objects[0]
    assert Scene("rough", CAMERA, (wall, Object("decal", rough, RED))).coincidence is None
    found = Scene("rough", CAMERA, (wall, Object("decal", rough, RED, decal_of="wall")))
    assert found.coincidence is not None
    assert found.coincidence.pair == ("decal", "wall")
    image = render(device, found, "a_buffer", size=SIZE)
    np.testing.assert_allclose(image, render(device, scene, "a_buffer", size=SIZE), atol=1e-6)


def test_several_samples_are_refused(device: Device) -> None:
    with (
        pytest.raises(CapabilityError, match="wall and decal lie in one plane; give one sample"),
        opened(device, decal(0.0), "a_buffer[msaa=4]", SIZE),
    ):
        pass


def objects_of(*meshes: Mesh, material: Material = RED) -> list[Object]:
    return [Object(str(k), mesh, material) for k, mesh in enumerate(meshes)]


def turn(mesh: Mesh, axes: Floats) -> Mesh:
    return Mesh.from_arrays(mesh.positions @ axes, mesh.triangles)


def test_only_overlapping_triangles_of_one_plane_coincide() -> None:
    random = np.random.default_rng(4)
    axes = np.linalg.qr(random.normal(size=(3, 3)))[0]
    base = turn(quad((0, 0, -5), (1, 0, 0), (0, 1, 0)), axes)
    same = turn(grid((0.2, 0.3, -5), (1, 0.2, 0), (0, 1, 0), 3, 2), axes)
    beside = turn(quad((2, 0, -5), (1, 0, 0), (0, 1, 0)), axes)
    corner = turn(quad((2.1, 2.1, -5), (1, 1, 0), (-1, 1, 0)), axes)
    close = turn(quad((0, 0, -5 - 1e-7), (1, 0, 0), (0, 1, 0)), axes)
    assert find_coincidence(objects_of(base, same)) is not None
    for other in (beside, corner, close):
        assert find_coincidence(objects_of(base, other)) is None
        assert find_coincidence(objects_of(other, base)) is None
    assert find_coincidence(objects_of(base, same, material=WHITE)) is None
    assert find_coincidence(objects_of(base)) is None
    found = find_coincidence([*objects_of(beside, base), Object("same", same, WHITE)])
    assert found is not None
    assert found.pair[1] == "same"
    # All triangles of the plane have its equation, bit for bit.
    assert len(np.unique(np.concatenate(list(found.planes.values())), axis=0)) == 1


def test_planes_through_the_eye_are_left_out() -> None:
    edge_on = quad((0, 0, -5), (1, 0, 0), (0, 0, 1))
    assert find_coincidence(objects_of(edge_on, edge_on)) is None
