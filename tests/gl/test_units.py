"""A scene has one picture in every unit of length, and at every place in the world."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.gl.frame import Image
from oitbench.modeling.mesh import box, quad
from oitbench.scene import (
    Camera,
    DirectionalLight,
    EnvironmentLight,
    FragmentLists,
    Material,
    Medium,
    Mesh,
    Object,
    Scene,
    SpotLight,
)
from tests.helpers import render

SIZE = (48, 32)
METHODS = ["a_buffer", "phenomenological", "hashed_alpha", "weighted_blended", "stochastic"]
GLASS = Material(index=1.5, solid=True, transmission=(0.9, 0.3, 0.2))
FROSTED = Material(coverage=0.8, collimation=0.3, transmission=(0.3, 0.9, 0.4), specular=0.0)
PAPER = Material(albedo=(0.7, 0.6, 0.5), specular=0.0)
POST = Material(albedo=(0.3, 0.6, 0.3), specular=0.0)
FOG = Medium(0.1, (-2, -1, -2), (2, 2, 2), albedo=(0.9, 0.8, 0.7))


def toy(unit: float = 1.0, at: float = 0.0, medium: Medium | None = FOG) -> Scene:
    """Return a scene that is written in units of `unit` meters, `at` meters from the origin."""
    objects = (
        Object("floor", quad((0, 0, 0), (4, 0, 0), (0, 0, -4)), PAPER, casts=False),
        Object("post", box((-0.8, 0.5, 0), (0.3, 1, 0.3)), POST),
        Object("glass", box((0.5, 0.5, 0), (0.8, 0.8, 0.2)), GLASS),
        Object("frosted", quad((0.1, 0.6, 0.8), (0.4, 0, 0), (0, 0.4, 0)), FROSTED),
    )
    lights = (
        DirectionalLight((0.4, -1.0, -0.7), (2.0, 2.0, 2.0)),
        SpotLight((1, 3, 1), (0, 0, 0), (9.0, 8.0, 7.0)),
        EnvironmentLight((0.5, 0.6, 0.8)),
    )
    seen = Camera((1.2, 2.0, 3.5), (0, 0.3, 0), fov_y=math.radians(45), near=0.05, far=60)
    scene = Scene("toy", seen, objects, lights=lights, medium=medium, ambient_occlusion=0.6)
    # Of every length, this is the number in the scene's unit.
    origin, scale = (-at, -2 * at, at), 1 / unit
    return dataclasses.replace(
        scene,
        camera=seen.relocated(origin, scale),
        objects=tuple(
            dataclasses.replace(item, mesh=item.mesh.relocated(origin, scale)) for item in objects
        ),
        lights=(lights[0], lights[1].relocated(origin, scale), lights[2]),
        medium=None if medium is None else medium.relocated(origin, scale),
        ambient_occlusion=0.6 * scale,
        meters_per_unit=unit,
    )


def assert_same_picture(found: Image, expected: Image) -> None:
    """Roundings decide differently in a few texels of a shadow map, and at a few edges."""
    difference = np.abs(found - expected).max(axis=-1)
    assert (difference > 1e-3).mean() < 0.01
    assert np.median(difference) < 1e-5
    assert difference.mean() < 1e-3


@pytest.mark.parametrize("chosen", METHODS)
def test_a_scene_looks_the_same_in_all_units_and_places(device: Device, chosen: str) -> None:
    expected = render(device, toy(), chosen, size=SIZE)
    assert expected.std() > 0.05
    for unit in (1e-3, 1e3, 1e-6):
        assert_same_picture(render(device, toy(unit), chosen, size=SIZE), expected)
    for unit, at in ((1.0, 1e6), (1e-3, 1e6)):
        assert_same_picture(render(device, toy(unit, at), chosen, size=SIZE), expected)


def test_requested_effects_do_not_depend_on_the_unit() -> None:
    assert toy(1e-3).effects == toy().effects == toy(1e-3).in_meters().effects
    assert toy().effects & Effect.VOLUME


def test_lists_are_converted_to_meters() -> None:
    ones = np.ones((1, 1, 1), np.float32)
    color = np.ones((1, 1, 1, 3), np.float32)
    lists = FragmentLists(3 * ones, ones, color, 0 * color)
    scene = Scene("l", Camera((0, 0, 0), (0, 0, -1), near=1.0), lists=lists, meters_per_unit=0.01)
    found = scene.in_meters()
    assert found.lists is not None
    np.testing.assert_allclose(found.lists.z, 0.03)
    assert found.camera.near == pytest.approx(0.01)
    assert found.meters_per_unit == 1
    assert found.in_meters() is found


def tiny(size: float) -> Scene:
    """Return a floor, a pane of glass and a lamp, whose real size is `size` meters."""
    whole = toy(1 / size, medium=None)
    beams = tuple(light for light in whole.lights if isinstance(light, DirectionalLight))
    floor, post, pane = whole.objects[0], whole.objects[1], whole.objects[3]
    sheet = Object("pane", pane.mesh, dataclasses.replace(FROSTED, collimation=1.0))
    return dataclasses.replace(
        whole, objects=(floor, post, sheet), lights=beams, ambient_occlusion=0.0, meters_per_unit=1
    )


@pytest.mark.parametrize("size", [1e-3, 1e-7, 1e3])
def test_shadows_of_tiny_and_huge_scenes_are_those_of_the_scene_at_one_meter(
    device: Device, size: float
) -> None:
    expected = render(device, tiny(1.0), "a_buffer", size=SIZE)
    found = render(device, tiny(size), "a_buffer", size=SIZE)
    # The noise of shadow maps is another one.
    assert np.abs(found - expected).max() < 0.12
    assert np.sqrt(((found - expected) ** 2).mean()) < 0.01


def test_vertices_that_no_triangle_uses_have_no_influence(device: Device) -> None:
    scene = toy(medium=None)
    far = [(1e5, 1e5, 1e5), (-1e5, 9.0, 1e4)]

    def extended(mesh: Mesh) -> Mesh:
        normals = None if mesh.normals is None else np.vstack([mesh.normals, [(0, 0, 1)] * 2])
        uvs = None if mesh.uvs is None else np.vstack([mesh.uvs, np.zeros((2, 2))])
        positions = np.vstack([mesh.positions, far])
        return Mesh.from_arrays(positions, mesh.triangles, normals=normals, uvs=uvs)

    objects = tuple(dataclasses.replace(item, mesh=extended(item.mesh)) for item in scene.objects)
    other = dataclasses.replace(scene, objects=objects)
    for chosen in ("a_buffer", "sorted_over"):
        found = render(device, other, chosen, size=SIZE)
        np.testing.assert_array_equal(found, render(device, scene, chosen, size=SIZE))
