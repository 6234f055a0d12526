"""Scene → Mitsuba: all films of one texture become one mesh with their values as its attributes.

Few meshes keep the kernel small (drjit records each plugin's calls) and let one acceleration
structure hold everything, however many objects a scene has.
"""

from __future__ import annotations

import importlib
from collections.abc import Hashable, Sequence
from types import ModuleType
from typing import Any

import numpy as np

from oitbench.errors import CapabilityError
from oitbench.path_traced import llvm
from oitbench.path_traced.export.film import (
    ABSORPTION,
    COVERAGE,
    LIGHT,
    REFLECTANCE,
    Film,
    FilteredTexture,
    make_bsdf,
    make_emitter,
)
from oitbench.path_traced.export.view import View
from oitbench.path_traced.photons.map import solids
from oitbench.path_traced.trace.reflection import interface_roughness
from oitbench.scene import BLACK, RGB, Array, Material, Mesh, Object, Scene, Texture
from oitbench.scene.texturing import premultiplied_pyramid


def require_traceable(scene: Scene) -> None:
    """Raise `CapabilityError` with one line if `scene` has no path-traced truth."""
    if scene.lists is not None:
        raise CapabilityError(
            f"scene {scene.name}: fragment lists have no geometry, so there is no path-traced truth"
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


def layout(scene: Scene) -> dict[str, list[Object]]:
    """Return the objects of `scene` by the id of their Mitsuba shape.

    Each refracting solid has a shape of its own; all others share one with those of their texture.
    """
    bending = solids(scene)
    apart = {id(item) for item in bending.values()}
    groups: dict[Hashable, list[Object]] = {}
    for item in scene.objects:
        if id(item) not in apart:
            groups.setdefault(_texture_key(item.material), []).append(item)
    films = {f"films_{number}": group for number, group in enumerate(groups.values())}
    return films | {name: [item] for name, item in bending.items()}


def export(scene: Scene, view: View, mitsuba: ModuleType | None = None) -> Any:
    """Build the Mitsuba scene that `view` sees: its surfaces, and its background.

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
        If the scene has no path-traced truth, or Mitsuba is not installed.
    """
    mitsuba = llvm.load() if mitsuba is None else mitsuba
    return export_with_textures(scene, view, mitsuba)[0]


def export_with_textures(
    scene: Scene, view: View, mitsuba: ModuleType
) -> tuple[Any, dict[str, FilteredTexture]]:
    """Return what `export` does, and the textures by the ids of their shapes."""
    require_traceable(scene)
    _require_distinct(scene)
    drjit = importlib.import_module("drjit")
    content: dict[str, Any] = {"type": "scene"}
    textures: dict[str, FilteredTexture] = {}
    for name, group in layout(scene).items():
        pyramid = premultiplied_pyramid(group[0].material)
        if pyramid is not None:
            textures[name] = FilteredTexture.build(mitsuba, drjit, pyramid, view)
        content[name] = _mesh(mitsuba, Film(mitsuba, drjit, view, textures.get(name)), group)
    if scene.background != BLACK:
        radiance = {"type": "rgb", "value": [float(value) for value in scene.background]}
        content["background"] = {"type": "constant", "radiance": radiance}
    return mitsuba.load_dict(content), textures


def _texture_key(material: Material) -> Hashable:
    parts = (material.emission, material.coverage)
    if not any(isinstance(part, Texture) for part in parts):
        return None
    return tuple(id(part) if isinstance(part, Texture) else part for part in parts)


def _mesh(mitsuba: ModuleType, film: Film, group: Sequence[Object]) -> Any:
    textured = film.texture is not None
    meshes = [_with_normals(item.mesh) for item in group]
    light = np.concatenate(
        [_light(item.material, mesh, textured) for item, mesh in zip(group, meshes, strict=True)]
    )
    properties = mitsuba.Properties("mesh")
    bends = group[0].material.refracts and not group[0].material.opaque
    properties["film"] = _interface(mitsuba, group[0].material) if bends else make_bsdf(film)
    if light.any():
        properties["glow"] = make_emitter(film)
    faces = _joined_triangles(meshes)
    mesh = mitsuba.Mesh(
        "films",
        sum(len(part.positions) for part in meshes),
        len(faces),
        props=properties,
        has_vertex_normals=True,
        has_vertex_texcoords=textured,
    )
    mesh.add_attribute(LIGHT, 3, light.ravel())
    for name, column in _attributes(group, textured).items():
        mesh.add_attribute(name, column.shape[1], column.ravel())
    values = mitsuba.traverse(mesh)
    values["faces"] = faces.ravel()
    values["vertex_positions"] = _joined([part.positions for part in meshes])
    values["vertex_normals"] = _joined([part.normals for part in meshes])
    if textured:
        values["vertex_texcoords"] = _joined([part.uvs for part in meshes])
    values.update()
    return mesh


def _interface(mitsuba: ModuleType, material: Material) -> Any:
    """Return Mitsuba's own BSDF for the surface of a refracting solid."""
    content = {"type": "dielectric", "int_ior": float(material.index), "ext_ior": 1.0}
    alpha = interface_roughness(material)
    if alpha > 0:
        content |= {"type": "roughdielectric", "distribution": "beckmann", "alpha": alpha}
    return mitsuba.load_dict(content)


def _with_normals(mesh: Mesh) -> Mesh:
    """Return `mesh`, or if it has no normals the same with three vertices for each flat face."""
    if mesh.normals is not None:
        return mesh
    corners = mesh.triangles.ravel()
    points = mesh.positions[mesh.triangles].astype(np.float64)
    normals = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, length, out=np.zeros_like(normals), where=length > 0)
    return Mesh(
        mesh.positions[corners],
        np.arange(len(corners), dtype=np.uint32).reshape(-1, 3),
        None if mesh.uvs is None else mesh.uvs[corners],
        None if mesh.radiance is None else mesh.radiance[corners],
        np.repeat(normals, 3, axis=0).astype(np.float32),
    )


def _joined(parts: Sequence[Array | None]) -> Any:
    present = [part for part in parts if part is not None]
    return np.concatenate(present).astype(np.float32).ravel()


def _joined_triangles(meshes: Sequence[Mesh]) -> Any:
    counts = [len(mesh.positions) for mesh in meshes]
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    parts = [
        mesh.triangles.astype(np.uint32) + np.uint32(start)
        for mesh, start in zip(meshes, starts, strict=True)
    ]
    return np.concatenate(parts)


def _light(material: Material, mesh: Mesh, textured: bool) -> Array:
    """Return α·L at the vertices, without what a texture gives."""
    light = np.ones((len(mesh.positions), 3)) if mesh.radiance is None else mesh.radiance
    if not textured:
        light = light * np.multiply(_value(material.emission), _value(material.coverage))
    return light.astype(np.float32)


def _attributes(group: Sequence[Object], textured: bool) -> dict[str, Array]:
    """Return values on the triangles, without an α that a texture gives."""
    rows = []
    for item in group:
        material = item.material
        coverage = 1.0 if textured else np.asarray(_value(material.coverage), dtype=np.float64)
        kept = np.multiply(material.transmission, 1 - np.asarray(material.albedo))
        reflectance = 0.0 if material.isotropic else material.reflectance
        rows.append([*(coverage * (1 - kept)), coverage, reflectance])
    counts = [len(item.mesh.triangles) for item in group]
    values = np.repeat(np.asarray(rows, dtype=np.float32), counts, axis=0)
    return {ABSORPTION: values[:, :3], COVERAGE: values[:, 3:4], REFLECTANCE: values[:, 4:]}


def _value(value: float | RGB | Texture) -> float | RGB:
    if isinstance(value, Texture):
        raise TypeError("a texture is looked up, not multiplied in")
    return value
