"""Fingerprints of scenes: every value matters, and no last digit does."""

from __future__ import annotations

import dataclasses
import json
import os
import subprocess
import sys
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from numpy._core._multiarray_umath import (  # type: ignore[import-not-found,unused-ignore]
    __cpu_dispatch__,
    __cpu_features__,
)

from oitbench import scene as descriptions
from oitbench.fingerprints.scene import scene_fingerprint, scene_size
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
    Sprites,
    Strands,
    Texture,
    Wrap,
)
from tests.helpers import collection

UP, DOWN = np.float64(np.inf), np.float64(-np.inf)


def sheet_scene(
    unit: float = 1.0, offset: float = 0.0, radiance: float = 1.0, fov: float = 0.8, **fields: Any
) -> Scene:
    """Return a scene of one sheet, two meters before the camera in another unit."""
    mesh = quad((offset, 0, -2 * unit), (unit, 0, 0), (0, unit, 0))
    sheet = Object("sheet", mesh, Material(coverage=0.5, emission=(radiance,) * 3))
    camera = Camera((0, 0, 0), (0, 0, -1), fov_y=fov, near=1e-3 * unit)
    return Scene("x", camera, (sheet,), **fields)


def foggy(extinction: float) -> Scene:
    return sheet_scene(medium=Medium(extinction, (-1e6, -1e6, -1e6), (1e6, 1e6, 1e6)))


def lit(light: Any, **fields: Any) -> Scene:
    return sheet_scene(lights=(light,), **fields)


def sky(texels: Any) -> Scene:
    return lit(EnvironmentLight(Texture(np.asarray(texels, np.float32))))


def with_material(**fields: Any) -> Scene:
    scene = sheet_scene()
    (sheet,) = scene.objects
    return replace(scene, objects=(replace(sheet, material=replace(sheet.material, **fields)),))


def with_mesh(**fields: Any) -> Scene:
    scene = sheet_scene()
    (sheet,) = scene.objects
    return replace(scene, objects=(replace(sheet, mesh=replace(sheet.mesh, **fields)),))


SUN = [[0.1, 0.1, 0.1, 1e5], [0.1, 0.1, 0.1, 0.1]]
DIM = [[0.1, 0.101, 0.1, 1e5], [0.1, 0.1, 0.1, 0.1]]
FAR = (6.4e6, 0.0, 0.0)
PAIRS = {
    "micrometers: a sheet moved by its width": (
        sheet_scene(unit=1e-6),
        sheet_scene(unit=1e-6, offset=2e-6),
    ),
    "an atmosphere of 1.6e-5 or 2.4e-5 per meter": (foggy(1.6e-5), foggy(2.4e-5)),
    "an atmosphere of 1e-6 or 4e-6 per meter": (foggy(1e-6), foggy(4e-6)),
    "radiance of 1e-6 or 4e-6": (sheet_scene(radiance=1e-6), sheet_scene(radiance=4e-6)),
    "a view of 2e-6 or 4e-6 radians": (sheet_scene(fov=2e-6), sheet_scene(fov=4e-6)),
    "meters: a sheet moved by a centimeter": (sheet_scene(), sheet_scene(offset=0.01)),
    "a sheet moved by four millionths of its size": (sheet_scene(), sheet_scene(offset=8e-6)),
    "one scene in two units": (sheet_scene(unit=1.0), sheet_scene(unit=1e-6)),
    "two kinds of light": (
        lit(SpotLight((0, 1, 0), (0, 0, 0))),
        lit(DirectionalLight((0, -1, 0))),
    ),
    "a dim part of a sky with a sun": (sky(SUN), sky(DIM)),
    "a camera moved by a millimeter, far from the origin": (
        replace(sheet_scene(offset=6.4e6), camera=Camera(FAR, (6.4e6, 0, -1))),
        replace(sheet_scene(offset=6.4e6), camera=Camera((6.4e6 + 1e-3, 0, 0), (6.4e6, 0, -1))),
    ),
    "a number of seven digits": (with_material(roughness=0.5), with_material(roughness=0.5000001)),
    "a value that is given and one by default": (with_material(specular=0.04), with_material()),
    "normals or none": (with_mesh(normals=None), with_mesh()),
    "the other side": (
        with_mesh(),
        with_mesh(triangles=with_mesh().objects[0].mesh.triangles[::-1]),
    ),
    "a textured material": (
        with_mesh(),
        replace(with_mesh(), background=(0.0, 0.0, 1e-5)),
    ),
    "a tall or a wide texture": (sky(np.ones((2, 8))), sky(np.ones((8, 2)))),
    "a texture that ends or goes on": (
        with_material(coverage=Texture(np.ones((2, 2), np.float32))),
        with_material(
            coverage=Texture(np.ones((2, 2), np.float32), (Wrap.REPEAT, Wrap.CLAMP)),
        ),
    ),
    "a cutoff": (with_material(), with_material(cutoff=0.5)),
    "a back": (with_material(), with_material(culled=True)),
    "coverage of vertices": (with_mesh(), with_mesh(coverage=np.array([0, 1, 1, 1], np.float32))),
    "exposure": (sheet_scene(), sheet_scene(exposure=1.0)),
}


@pytest.mark.parametrize("pair", PAIRS.values(), ids=PAIRS)
def test_scenes_with_different_pictures_have_different_fingerprints(
    pair: tuple[Scene, Scene],
) -> None:
    assert scene_fingerprint(pair[0]) != scene_fingerprint(pair[1])


def test_names_and_classes_do_not_matter() -> None:
    class Pane(Object):
        """Another class of the same content."""

    scene = sheet_scene()
    (sheet,) = scene.objects
    pane = Pane("pane", sheet.mesh, sheet.material)
    renamed = replace(scene, name="y", objects=(pane,))
    assert scene_fingerprint(renamed) == scene_fingerprint(scene)


def test_references_between_objects_matter_but_not_their_names() -> None:
    @dataclass(frozen=True, eq=False)
    class Decal(Object):
        decal_of: str = ""

    (sheet,) = sheet_scene().objects

    def decal(first: str, second: str, of: str) -> str:
        walls = [replace(sheet, name=name) for name in (first, second)]
        on_it = Decal("decal", sheet.mesh, sheet.material, decal_of=of)
        return scene_fingerprint(replace(sheet_scene(), objects=(*walls, on_it)))

    assert decal("a", "b", of="a") == decal("c", "d", of="c")
    assert decal("a", "b", of="a") != decal("a", "b", of="b")


def test_kinds_of_values_can_be_told_apart_by_their_fields() -> None:
    kinds = [
        kind
        for name in descriptions.__all__
        if dataclasses.is_dataclass(kind := getattr(descriptions, name))
        and kind is not descriptions.ViewMesh  # It has no value of its own.
    ]
    fields = [
        tuple(sorted(field.name for field in dataclasses.fields(kind) if field.init))
        for kind in kinds
    ]
    assert len(kinds) > 8
    assert len(set(fields)) == len(kinds)


def test_values_without_a_rule_are_a_bug() -> None:
    scene = sheet_scene()
    object.__setattr__(scene, "background", {1.0})
    with pytest.raises(TypeError, match="set has no fingerprint"):
        scene_fingerprint(scene)


def nudged(value: Any, direction: float) -> Any:
    """Return a value whose float64 numbers are moved to their neighbors."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        moved = object.__new__(type(value))
        for field in dataclasses.fields(value):
            inner = getattr(value, field.name)
            object.__setattr__(moved, field.name, nudged(inner, direction))
        return moved
    if isinstance(value, np.ndarray) and value.dtype.kind == "f":
        return np.nextafter(value.astype(np.float64), direction)
    if isinstance(value, float) and np.isfinite(value):
        return float(np.nextafter(value, direction))
    return tuple(nudged(item, direction) for item in value) if isinstance(value, tuple) else value


@pytest.mark.parametrize("far", [0.0, 1e3, 1e5])
@pytest.mark.parametrize("kind", ["sprites", "strands"])
def test_small_moves_far_from_the_origin_matter(kind: str, far: float) -> None:
    def scene(shift: float) -> Scene:
        points = np.array([(0.0, 0.0, -3.0), (0.3 + shift, 0.1, -3.0), (1.0, 0.0, -3.0)])
        points[:, 0] += far
        mesh = Sprites(points, 0.1) if kind == "sprites" else Strands(points[None], 0.1)
        fog = (Object("fog", mesh, Material(coverage=0.5)),)
        return Scene("x", Camera((far, 0.0, 0.0), (far, 0.0, -1.0)), fog)

    assert scene_fingerprint(scene(1e-4)) != scene_fingerprint(scene(0.0))


@pytest.mark.parametrize("name", collection().scenes)
def test_the_last_digit_does_not_matter(name: str) -> None:
    scene = collection().build_scene(name)
    expected = scene_fingerprint(scene)
    for direction in (UP, DOWN):
        assert scene_fingerprint(nudged(scene, direction)) == expected


@pytest.mark.parametrize(
    "value", [1.0, 0.5, 2.0, 0.1, 1 / 3, 1e-6, 0.0078125, 12345.678901, 1e30, 1e-30]
)
def test_the_last_digit_of_round_numbers_does_not_matter(value: float) -> None:
    def scene(number: float) -> Scene:
        corner = np.array([(number, 0, -2), (-number, 0, -2), (0, number, -2)])
        mesh = Mesh(corner, np.array([(0, 1, 2)], np.uint32))
        panes = (Object("pane", mesh, Material(coverage=0.5, emission=(number, 1.0, 0.5))),)
        return Scene("x", Camera((number, 0.0, 0.0), (number, 0.0, -1.0)), panes)

    steps = (value, np.nextafter(value, UP), np.nextafter(value, DOWN), value * (1 + 1e-14))
    assert len({scene_fingerprint(scene(float(step))) for step in steps}) == 1


def test_the_size_ignores_vertices_that_no_triangle_uses() -> None:
    mesh = quad((0, 0, 0), (1, 0, 0), (0, 3, 0))
    far = np.array([*mesh.positions, (1e6, 0, 0)])
    assert scene_size([Mesh(far, mesh.triangles)]) == scene_size([mesh]) == 6.0
    assert scene_size([]) == 1.0
    assert scene_size([Mesh(np.zeros((3, 3)), mesh.triangles % 3)]) == 1.0


def test_lists_of_fragments_have_fingerprints() -> None:
    ones = np.ones((2, 4, 4), np.float32)
    lists = FragmentLists(
        ones, 0.5 * ones, np.ones((2, 4, 4, 3), np.float32), np.zeros((2, 4, 4, 3), np.float32)
    )
    scene = Scene("x", Camera((0, 0, 0), (0, 0, -1)), lists=lists)
    other = replace(scene, lists=replace(lists, z=ones * np.float32(1.00001)))
    assert scene_fingerprint(scene) != scene_fingerprint(other)


ALL = """
import json
from oitbench.fingerprints.scene import scene_fingerprint
from oitbench.plugins import Collection
plugins = Collection.load()
print(json.dumps({n: scene_fingerprint(plugins.build_scene(n)) for n in plugins.scenes}))
"""


def test_another_processor_gives_the_same_fingerprints() -> None:
    """numpy, its BLAS and the C library compute as on a processor without vector instructions."""
    used = [name for name in __cpu_dispatch__ if __cpu_features__[name]]
    older = {
        "NPY_DISABLE_CPU_FEATURES": " ".join(used),
        "OPENBLAS_CORETYPE": "Nehalem",
        "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX512F,-AVX512VL",
    }
    found = subprocess.run(
        [sys.executable, "-c", ALL],
        env={**os.environ, **older},
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
    )
    scenes = collection().scenes
    expected = {name: scene_fingerprint(collection().build_scene(name)) for name in scenes}
    assert json.loads(found.stdout) == expected
