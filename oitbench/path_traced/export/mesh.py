"""Mitsuba meshes: objects are joined, and their materials become attributes of the faces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import ModuleType
from typing import Any

import numpy as np

from oitbench.path_traced.export.film import (
    ABSORPTION,
    ALBEDO,
    COLUMN,
    COVERAGE,
    LIGHT,
    REFLECTANCE,
    TRANSMISSION,
    Film,
    make_bsdf,
    make_emitter,
)
from oitbench.path_traced.export.variation import VERTEX, Variation
from oitbench.scene import Array, Floats, Material, Mesh, Object
from oitbench.scene.texturing import constant, constants_of


def build_mesh(mitsuba: ModuleType, film: Film, group: Sequence[Object]) -> Any:
    """Return one Mitsuba mesh of all objects of a group.

    Parameters
    ----------
    mitsuba : module
        With a variant set.
    film : Film
        Of the whole scene.
    group : sequence of Object
        Either films or refracting solids (see `shapes.layout`).
    """
    textured = film.variation.textures is not None
    meshes = [_with_normals(item.mesh) for item in group]
    light = np.concatenate(
        [_light(item.material, mesh) for item, mesh in zip(group, meshes, strict=True)]
    )
    properties = mitsuba.Properties("mesh")
    refracts = group[0].refracts
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
    for name in sorted(film.variation.vertex):
        column = np.concatenate([_factors(part, name) for part in meshes])
        mesh.add_attribute(VERTEX + name, column.shape[1], column.ravel())
    for name, column in _attributes(group, film.variation).items():
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
    points = mesh.positions[mesh.triangles]
    normals = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, length, out=np.zeros_like(normals), where=length > 0)
    separate = mesh.with_separate_corners()
    return replace(separate, normals=np.repeat(normals, 3, axis=0).astype(np.float32))


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
    """Return α·L at the vertices, shape (n, 3), without the factor of `Variation`."""
    emission, coverage = constants_of(material)
    light = np.ones((len(mesh.positions), 3)) if mesh.radiance is None else mesh.radiance
    return np.asarray(light * np.multiply(emission, coverage), dtype=np.float32)


def _factors(mesh: Mesh, name: str) -> Array:
    """Return the factors of vertices on a property, shape (n, 1) or (n, 3)."""
    count, width = len(mesh.positions), 1 if name == "coverage" else 3
    values = mesh.factors.get(name)
    plain = np.ones((count, width), dtype=np.float32)
    return plain if values is None else values.reshape(count, width).astype(np.float32)


def _attributes(group: Sequence[Object], variation: Variation) -> dict[str, Array]:
    """Return the values of the faces by attribute, without the factors of `variation`."""
    found: dict[str, list[Any]] = {}
    for item in group:
        material = item.material
        _, coverage = constants_of(material)
        transmission, albedo = constant(material.transmission), constant(material.albedo)
        kept = np.multiply(transmission, 1 - np.asarray(albedo))
        values: dict[str, Any] = {
            ABSORPTION: coverage * (1 - kept),
            COVERAGE: [coverage],
            REFLECTANCE: [0.0 if material.isotropic else material.reflectance],
        }
        if variation.inner:
            values |= {TRANSMISSION: transmission, ALBEDO: albedo}
        values |= {COLUMN + name: [value] for name, value in variation.row(material).items()}
        for name, row in values.items():
            found.setdefault(name, []).append(row)
    counts = [len(item.mesh.triangles) for item in group]
    return {
        name: np.repeat(np.asarray(rows, dtype=np.float32), counts, axis=0)
        for name, rows in found.items()
    }
