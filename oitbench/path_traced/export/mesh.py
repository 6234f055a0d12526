"""Mitsuba meshes: objects are joined, and their materials become attributes of the faces."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from types import ModuleType
from typing import Any

import numpy as np

from oitbench.path_traced.export.film import (
    ABSORPTION,
    COVERAGE,
    LIGHT,
    REFLECTANCE,
    TEXTURE,
    Film,
    make_bsdf,
    make_emitter,
)
from oitbench.scene import Array, Floats, Material, Mesh, Object
from oitbench.scene.texturing import constants_of, image_key, images_of


def build_mesh(
    mitsuba: ModuleType, film: Film, group: Sequence[Object], numbers: Mapping[Hashable, int]
) -> Any:
    """Return one Mitsuba mesh of all objects of a group.

    Parameters
    ----------
    mitsuba : module
        With a variant set.
    film : Film
        With the textures of the scene, if it has some.
    group : sequence of Object
        Either films or refracting solids (see `shapes.layout`).
    numbers : mapping of hashable to int
        Place of each texture among those of the scene, by `image_key`.
    """
    textured = film.textures is not None
    meshes = [_with_normals(item.mesh) for item in group]
    light = np.concatenate(
        [_light(item.material, mesh) for item, mesh in zip(group, meshes, strict=True)]
    )
    properties = mitsuba.Properties("mesh")
    refracts = group[0].material.refracts and not group[0].material.opaque
    # The interfaces of solids are traced by `optics`, with the indices on both of their sides.
    properties["film"] = mitsuba.load_dict({"type": "null"}) if refracts else make_bsdf(film)
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
    for name, column in _attributes(group, numbers).items():
        mesh.add_attribute(name, column.shape[1], column.ravel())
    values = mitsuba.traverse(mesh)
    values["faces"] = faces.ravel()
    values["vertex_positions"] = _joined([part.positions for part in meshes])
    values["vertex_normals"] = _joined([part.normals for part in meshes])
    if textured:
        values["vertex_texcoords"] = _joined([_uvs(part) for part in meshes])
    values.update()
    return mesh


def _with_normals(mesh: Mesh) -> Mesh:
    """Return `mesh`; without normals, its copy with three vertices and a normal for each face."""
    if mesh.normals is not None:
        return mesh
    corners = mesh.triangles.ravel()
    points = mesh.positions[mesh.triangles]
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


def _uvs(mesh: Mesh) -> Array:
    return np.zeros((len(mesh.positions), 2), np.float32) if mesh.uvs is None else mesh.uvs


def _joined(parts: Sequence[Floats | Array | None]) -> Any:
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


def _light(material: Material, mesh: Mesh) -> Array:
    """Return α·L at the vertices, shape (n, 3), without the factor of a texture."""
    emission, coverage = constants_of(material)
    light = np.ones((len(mesh.positions), 3)) if mesh.radiance is None else mesh.radiance
    return np.asarray(light * np.multiply(emission, coverage), dtype=np.float32)


def _attributes(group: Sequence[Object], numbers: Mapping[Hashable, int]) -> dict[str, Array]:
    """Return the values of the faces by attribute, without the factor of a texture."""
    rows = []
    for item in group:
        material = item.material
        _, coverage = constants_of(material)
        kept = np.multiply(material.transmission, 1 - np.asarray(material.albedo))
        reflectance = 0.0 if material.isotropic else material.reflectance
        number = texture_number(material, numbers)
        rows.append([*(coverage * (1 - kept)), coverage, reflectance, number])
    counts = [len(item.mesh.triangles) for item in group]
    values = np.repeat(np.asarray(rows, dtype=np.float32), counts, axis=0)
    columns = {ABSORPTION: values[:, :3], COVERAGE: values[:, 3:4], REFLECTANCE: values[:, 4:5]}
    return columns | ({TEXTURE: values[:, 5:]} if numbers else {})


def texture_number(material: Material, numbers: Mapping[Hashable, int]) -> int:
    """Return the number of a material's texture plus one; 0 if it has none."""
    images = images_of(material)
    return 0 if images is None else numbers[image_key(images)] + 1
