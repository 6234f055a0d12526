"""Scene → Mitsuba: all films of one texture become one mesh with their values as its attributes.

Few meshes keep the kernel small (drjit records each plugin's calls) and let one acceleration
structure hold everything, however many objects a scene has.
"""

from __future__ import annotations

import importlib
from collections.abc import Hashable, Iterable, Sequence
from types import ModuleType
from typing import Any

import numpy as np

from oitbench.errors import CapabilityError
from oitbench.path_traced import llvm
from oitbench.path_traced.film import (
    ABSORPTION,
    LIGHT,
    Film,
    FilteredTexture,
    make_bsdf,
    make_emitter,
)
from oitbench.path_traced.view import View
from oitbench.scene import BLACK, RGB, Array, Material, Object, Scene, Texture
from oitbench.texturing import premultiplied_pyramid


def require_traceable(scene: Scene) -> None:
    """Raise `CapabilityError` with one line if this version cannot path-trace `scene`."""
    if scene.lists is not None:
        raise CapabilityError(
            f"scene {scene.name}: fragment lists have no geometry, so there is no path-traced truth"
        )
    materials = [item.material for item in scene.objects]
    missing = {
        "lights": bool(scene.lights),
        "a medium": scene.medium is not None,
        "refraction": any(material.index != 1 for material in materials),
        "diffusion": any(material.collimation < 1 for material in materials),
        "ambient occlusion": scene.ambient_occlusion,
    }
    called = [name for name, present in missing.items() if present]
    if called:
        raise CapabilityError(
            f"scene {scene.name}: the path tracer does not simulate {' and '.join(called)} yet"
        )


def _require_distinct(scene: Scene) -> None:
    """Raise `CapabilityError` if triangles coincide exactly: a ray would meet only one of them."""
    corners = [item.mesh.positions[item.mesh.triangles] for item in scene.objects]
    owners = np.repeat(np.arange(len(corners)), [len(part) for part in corners])
    triangles = np.concatenate(corners).astype(np.float32) + np.float32(0)
    edges = np.diff(triangles.astype(np.float64), axis=1)
    solid = np.cross(edges[:, 0], edges[:, 1]).any(axis=1)
    triangles, owners = triangles[solid], owners[solid]
    # Whichever corner comes first: sort the three of each triangle by (x, y, z).
    order = np.lexsort(triangles.transpose(2, 0, 1)[::-1], axis=1)
    triangles = np.take_along_axis(triangles, order[..., None], axis=1)
    rows = np.ascontiguousarray(triangles.reshape(len(triangles), 9)).view("V36").ravel()
    _, inverse, counts = np.unique(rows, return_inverse=True, return_counts=True)
    doubled = np.flatnonzero(counts[inverse] > 1)
    if len(doubled):
        first = np.flatnonzero(inverse == inverse[doubled[0]])
        names = sorted({scene.objects[owners[index]].name for index in first})
        raise CapabilityError(
            f"scene {scene.name}: {len(doubled)} triangles coincide, as in {' and '.join(names)}; "
            "a ray meets only one of each, so there is no path-traced truth"
        )


def export(scene: Scene, view: View, mitsuba: ModuleType | None = None) -> Any:
    """Build the Mitsuba scene that `view` sees.

    Parameters
    ----------
    scene : Scene
    view : View
        Whose sub-pixels textures are filtered for.
    mitsuba : module, optional
        With a variant set; `llvm.load()` without.

    Returns
    -------
    mitsuba.Scene

    Raises
    ------
    CapabilityError
        If the scene has what this version cannot trace, or Mitsuba is not installed.
    """
    require_traceable(scene)
    _require_distinct(scene)
    mitsuba = llvm.load() if mitsuba is None else mitsuba
    drjit = importlib.import_module("drjit")
    content: dict[str, Any] = {"type": "scene"}
    for number, group in enumerate(_groups(scene.objects)):
        pyramid = premultiplied_pyramid(group[0].material)
        texture = None if pyramid is None else FilteredTexture.build(mitsuba, drjit, pyramid, view)
        content[f"films_{number}"] = _mesh(mitsuba, Film(mitsuba, drjit, view, texture), group)
    if scene.background != BLACK:
        radiance = {"type": "rgb", "value": [float(value) for value in scene.background]}
        content["background"] = {"type": "constant", "radiance": radiance}
    return mitsuba.load_dict(content)


def _groups(objects: Iterable[Object]) -> list[list[Object]]:
    """Collect the objects that share their textures, if any."""
    groups: dict[Hashable, list[Object]] = {}
    for item in objects:
        groups.setdefault(_texture_key(item.material), []).append(item)
    return list(groups.values())


def _texture_key(material: Material) -> Hashable:
    parts = (material.emission, material.coverage)
    if not any(isinstance(part, Texture) for part in parts):
        return None
    return tuple(id(part) if isinstance(part, Texture) else part for part in parts)


def _mesh(mitsuba: ModuleType, film: Film, group: Sequence[Object]) -> Any:
    textured = film.texture is not None
    light = np.concatenate([_light(item, textured) for item in group])
    absorption = np.concatenate([_absorption(item, textured) for item in group])
    properties = mitsuba.Properties("mesh")
    properties["film"] = make_bsdf(film)
    if light.any():
        properties["glow"] = make_emitter(film)
    positions = np.concatenate([item.mesh.positions for item in group])
    faces = _joined_triangles(group)
    mesh = mitsuba.Mesh(
        "films",
        len(positions),
        len(faces),
        props=properties,
        has_vertex_texcoords=textured,
    )
    mesh.add_attribute(LIGHT, 3, light.ravel())
    mesh.add_attribute(ABSORPTION, 3, absorption.ravel())
    values = mitsuba.traverse(mesh)
    values["vertex_positions"] = np.ascontiguousarray(positions, dtype=np.float32).ravel()
    values["faces"] = faces.ravel()
    if textured:
        uvs = [item.mesh.uvs for item in group if item.mesh.uvs is not None]
        values["vertex_texcoords"] = np.concatenate(uvs).astype(np.float32).ravel()
    values.update()
    return mesh


def _joined_triangles(group: Sequence[Object]) -> Any:
    counts = [len(item.mesh.positions) for item in group]
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    parts = [
        item.mesh.triangles.astype(np.uint32) + np.uint32(start)
        for item, start in zip(group, starts, strict=True)
    ]
    return np.concatenate(parts)


def _light(item: Object, textured: bool) -> Array:
    """Return α·L at the vertices, without what a texture gives."""
    mesh, material = item.mesh, item.material
    light = np.ones((len(mesh.positions), 3)) if mesh.radiance is None else mesh.radiance
    if not textured:
        light = light * np.multiply(_value(material.emission), _value(material.coverage))
    return light.astype(np.float32)


def _absorption(item: Object, textured: bool) -> Array:
    """Return α(1 − t) on the triangles, without an α that a texture gives."""
    material = item.material
    absorption = 1 - np.asarray(material.transmission, dtype=np.float64)
    if not textured:
        absorption = absorption * np.asarray(_value(material.coverage))
    return np.tile(absorption, (len(item.mesh.triangles), 1)).astype(np.float32)


def _value(value: float | RGB | Texture) -> float | RGB:
    if isinstance(value, Texture):
        raise TypeError("a texture is looked up, not multiplied in")
    return value
