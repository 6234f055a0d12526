"""Descriptions of scenes with wrong values are refused."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from oitbench.errors import SceneError
from oitbench.modeling.mesh import quad
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
    Texture,
    Wrap,
)

NAN, INFINITY = float("nan"), float("inf")
BLACK, HALF = (0.0, 0.0, 0.0), (0.5, 0.5, 0.5)
SHEET = quad((0, 0, -2), (1, 0, 0), (0, 1, 0))
PLAIN = Object("plain", SHEET, Material())
CAMERA = Camera(position=(0, 0, 0), target=(0, 0, -1))
FLAT = Camera(position=(0, 0, 0), target=(0, 0, -1), far=0.4)


def texture(*shape: int, value: float = 0.5) -> Texture:
    return Texture(np.full(shape, value, np.float32))


def glass(**fields: Any) -> Material:
    return Material(**{"transmission": (0.9, 0.9, 0.9), **fields}, index=1.5, solid=True)


def mesh(**arrays: Any) -> Mesh:
    given: dict[str, Any] = {"positions": SHEET.positions, "triangles": SHEET.triangles, **arrays}
    return Mesh.from_arrays(**given)


def lists(**arrays: Any) -> FragmentLists:
    shapes: dict[str, tuple[int, ...]] = {"z": (2, 4, 4), "coverage": (2, 4, 4)}
    shapes |= {"radiance": (2, 4, 4, 3), "transmission": (2, 4, 4, 3)}
    given: dict[str, Any] = {
        name: np.full(shape, 0.5, np.float32) for name, shape in shapes.items()
    }
    return FragmentLists(**(given | arrays))


def scene(**parts: Any) -> Scene:
    given: dict[str, Any] = {"name": "wrong", "camera": CAMERA, "objects": (PLAIN,)}
    return Scene(**(given | parts))


def fog(**values: Any) -> Medium:
    given: dict[str, Any] = {"extinction": 0.1, "low": (-1, -1, -1), "high": (1, 1, 1)}
    return Medium(**(given | values))


WRONG: list[tuple[Callable[[], object], str]] = [
    (lambda: texture(4, 4, 2), r"texture: texels are \(4, 4, 2\)"),
    (lambda: texture(4, 0), r"texture: texels are \(4, 0\); give one texel"),
    (lambda: Texture(np.ones((1, 1), np.float32), ("repeat", "spin")), "texture: wrap is"),  # type: ignore[arg-type]
    (lambda: texture(4, 4, value=NAN), "texture: texels holds NaN"),
    (lambda: Material(coverage=1.5), "material: coverage"),
    (lambda: Material(albedo=texture(2, 2, 3, value=1.5)), "material: albedo"),
    (lambda: Material(transmission=texture(2, 2, value=-1)), "material: transmission"),
    (lambda: Material(roughness=texture(2, 2, 3)), "material: roughness has colors"),
    (
        lambda: Material(
            texture(2, 2), albedo=Texture(np.ones((1, 1), np.float32), (Wrap.REPEAT, Wrap.CLAMP))
        ),
        "material: coverage and albedo wrap differently",
    ),
    (lambda: Material(cutoff=1.5), "material: cutoff must lie"),
    (lambda: Material(cutoff=0.0), "material: cutoff is 0, which all coverage reaches"),
    (lambda: glass(cutoff=0.5), "material: a refracting solid has cutoff or culled"),
    (lambda: glass(culled=True), "material: a refracting solid has cutoff or culled"),
    (lambda: glass(albedo=texture(2, 2)), "material: a refracting solid is even"),
    (lambda: glass(transmission=texture(2, 2)), "material: a refracting solid is even"),
    # No light passes the material, but it passes where the mesh is not covered.
    (
        lambda: Object("x", mesh(coverage=[0.5] * 4), Material(solid=True, index=1.5, culled=True)),
        "object x: a refracting solid has cutoff or culled",
    ),
    (lambda: mesh(coverage=[0.5]), r"mesh: coverage must be \(4,\)"),
    (lambda: mesh(coverage=[0.5, 0.5, 2, 1]), "mesh: coverage must lie"),
    (lambda: mesh(albedo=np.full((4, 3), -1)), "mesh: albedo must lie"),
    (lambda: mesh(transmission=np.zeros((4, 4))), r"mesh: transmission must be \(4, 3\)"),
    (lambda: Object("x", mesh(albedo=np.ones((4, 3))), glass()), "object x: a refracting solid is"),
    (lambda: Object("x", mesh(uvs=None), Material(roughness=texture(2, 2))), "object x: .* no uvs"),
    (lambda: Material(coverage=texture(4, 4, value=-0.5)), "material: coverage"),
    (lambda: Material(coverage=texture(4, 4, 3)), "material: coverage has colors"),
    (lambda: Material(transmission=(0.5, 1.1, 0.5)), "material: transmission"),
    (lambda: Material(emission=(-1.0, 0.0, 0.0)), "material: emission"),
    (lambda: Material(albedo=(0.0, 2.0, 0.0)), "material: albedo"),
    (lambda: Material(specular=1.5), "material: specular"),
    (lambda: Material(roughness=-0.1), "material: roughness"),
    (lambda: Material(index=0.9), "material: index is 0.9"),
    (lambda: Material(collimation=NAN), "material: collimation"),
    (lambda: mesh(positions=np.zeros((4, 2))), "mesh: positions"),
    (lambda: mesh(triangles=np.zeros((1, 4))), "mesh: triangles"),
    (lambda: mesh(triangles=np.zeros((0, 3))), "mesh: it has no triangle"),
    (lambda: mesh(triangles=[(0, 1, 4)]), "mesh: a triangle uses vertex 4 of 4"),
    (lambda: mesh(triangles=[(0, 1, -1)]), "mesh: a triangle uses vertex"),
    (lambda: mesh(uvs=np.zeros((4, 3))), r"mesh: uvs must be \(4, 2\)"),
    (lambda: mesh(radiance=np.zeros((3, 3))), r"mesh: radiance must be \(4, 3\)"),
    (lambda: mesh(radiance=np.full((4, 3), -0.1)), "mesh: radiance is negative"),
    (lambda: mesh(normals=np.full((4, 3), NAN)), "mesh: normals holds NaN"),
    (lambda: mesh(normals=np.zeros((4, 3))), "mesh: normals must have length one"),
    (lambda: mesh(normals=np.full((4, 3), 1.0)), "mesh: normals must have length one"),
    (lambda: DirectionalLight((0, -1, 0), (1e39, 1, 1)), "light: irradiance holds a number beyond"),
    (
        lambda: Object("board", mesh(), Material(coverage=texture(4, 4))),
        "object board: its material has a texture but its mesh has no uvs",
    ),
    (lambda: lists(z=np.zeros((4, 4), np.float32)), "fragment lists: z"),
    (lambda: lists(coverage=np.zeros((2, 4, 3), np.float32)), "fragment lists: coverage"),
    (lambda: lists(transmission=np.zeros((2, 4, 4), np.float32)), "fragment lists: transmission"),
    (lambda: lists(radiance=np.full((2, 4, 4, 3), INFINITY)), "fragment lists: radiance holds"),
    (lambda: lists(radiance=np.full((2, 4, 4, 3), -0.5)), "fragment lists: radiance is negative"),
    (lambda: lists(coverage=np.full((2, 4, 4), 1.5)), "fragment lists: coverage must lie"),
    (lambda: lists(coverage=np.full((2, 4, 4), NAN)), "fragment lists: coverage must lie"),
    (lambda: lists(transmission=np.full((2, 4, 4, 3), -0.1)), "fragment lists: transmission must"),
    (lambda: Camera((0, 0, 1), (0, 0, 1)), "camera: position and target coincide"),
    (lambda: Camera((0, 5, 0), up=BLACK), "camera: up has no length"),
    (lambda: Camera((0, NAN, 1)), "camera: position"),
    (lambda: Camera((0, 0, 1), fov_y=4.0), "camera: fov_y"),
    (lambda: Camera((0, 0, 1), near=2.0, far=1.0), "camera: near"),
    (lambda: DirectionalLight(BLACK), "light: its direction has no length"),
    (lambda: DirectionalLight((0, -1, 0), (1, -1, 1)), "light: irradiance is negative"),
    (lambda: SpotLight((0, 1, 0), (0, 1, 0)), "light: position and target coincide"),
    (lambda: SpotLight((0, 1, 0), BLACK, intensity=(1, NAN, 1)), "light: intensity holds NaN"),
    (lambda: SpotLight((0, 1, 0), BLACK, intensity=(-1, 1, 1)), "light: intensity is negative"),
    (lambda: SpotLight((0, 1, 0), BLACK, angle=4.0), "light: angle"),
    (lambda: EnvironmentLight((1.0, NAN, 1.0)), "light: radiance holds NaN"),
    (lambda: EnvironmentLight((1.0, -1.0, 1.0)), "light: radiance is negative"),
    (lambda: EnvironmentLight(texture(2, 4, 3, value=-0.5)), "light: radiance is negative"),
    (lambda: fog(extinction=-1.0), "medium: extinction"),
    (lambda: fog(albedo=(1.5, 0.5, 0.5)), "medium: albedo"),
    (lambda: fog(anisotropy=1.0), "medium: anisotropy"),
    (lambda: fog(collimation=1.5), "medium: collimation"),
    (lambda: fog(high=(1, -1, 1)), "medium: its box is empty"),
    (lambda: fog(density=np.ones((2, 2))), r"medium: density is \(2, 2\)"),
    (lambda: fog(density=np.full((2, 2, 2), 1.5)), "medium: density"),
    (lambda: scene(objects=()), "scene wrong: it has no object"),
    (lambda: scene(objects=(PLAIN, PLAIN)), r"scene wrong: two objects are named \['plain'\]"),
    (lambda: scene(lights=(EnvironmentLight(),) * 2), "scene wrong: it has 2 environment lights"),
    (lambda: scene(lights=(EnvironmentLight(),), background=HALF), "scene wrong: its environment"),
    (lambda: scene(background=(0.0, 0.0, NAN)), "scene wrong: background holds NaN"),
    (lambda: scene(background=(0.0, 0.0, -1.0)), "scene wrong: background is negative"),
    (lambda: scene(exposure=INFINITY), "scene wrong: exposure is inf stops"),
    (lambda: scene(exposure=NAN), "scene wrong: exposure is nan stops"),
    (lambda: scene(objects=(), lists=lists(z=np.full((2, 4, 4), 0.1))), "scene wrong: z of its"),
    (lambda: scene(objects=(), lists=lists(), camera=FLAT), "scene wrong: z of its fragment lists"),
    (lambda: scene(ambient_occlusion=-1.0), "scene wrong: ambient_occlusion is -1"),
]


@pytest.mark.parametrize(("make", "message"), WRONG, ids=[message for _, message in WRONG])
def test_errors_name_the_owner_and_the_wrong_value(
    make: Callable[[], object], message: str
) -> None:
    with pytest.raises(SceneError, match=message):
        make()
