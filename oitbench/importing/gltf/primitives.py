"""Geometry of a glTF file: vertices and triangles of one primitive, in the space of its node."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from oitbench.errors import SceneError
from oitbench.importing import shapes
from oitbench.importing.gltf.accessors import read_indices, read_vectors
from oitbench.importing.gltf.document import Document
from oitbench.importing.gltf.schema import Primitive
from oitbench.importing.shapes import Indices
from oitbench.scene import Floats

_TRIANGLES, _STRIP, _FAN = 4, 5, 6


@dataclass(frozen=True, eq=False)
class Geometry:
    """Vertices that triangles use, and triangles.

    Parameters
    ----------
    positions : array, shape (n, 3)
    triangles : array, shape (m, 3)
    normals : array, shape (n, 3), optional
        Default: flat shading.
    coordinates : dict of int to array, shape (n, 2)
        Texture coordinates by number, v downwards.
    colors : array, shape (n, 4), optional
        Linear, in [0, 1].
    """

    positions: Floats
    triangles: Indices
    normals: Floats | None
    coordinates: dict[int, Floats]
    colors: Floats | None


def read_primitive(document: Document, primitive: Primitive) -> Geometry | None:
    """Return the triangles of a primitive; None if it has none that is visible.

    Raises
    ------
    SceneError
        An attribute is damaged.
    """
    notes, attributes = document.notes, primitive.attributes
    if primitive.mode < _TRIANGLES:
        notes.add("points and lines are left out")
        return None
    if "POSITION" not in attributes:
        notes.add("meshes without positions are left out")
        return None
    if primitive.targets:
        notes.add("morph targets are ignored")
    for name in attributes:
        if name.startswith("COLOR_") and name != "COLOR_0":
            notes.add("only the first color of vertices counts")
    positions = read_vectors(document, attributes["POSITION"], 3)
    triangles = _triangles(document, primitive, len(positions))
    kept = shapes.sound(positions, triangles)
    if not kept.all():
        notes.add("triangles without area are left out")
        triangles = triangles[kept]
    if not len(triangles):
        return None
    used, triangles = shapes.compact(positions, triangles)

    def read(name: str, *widths: int) -> Floats | None:
        if name not in attributes:
            return None
        values = read_vectors(document, attributes[name], *widths)
        if len(values) != len(positions):
            raise SceneError(f"{name} has {len(values)} vertices, and POSITION {len(positions)}")
        return values[used]

    coordinates = {}
    for name in sorted(attributes):
        number = name.removeprefix("TEXCOORD_")
        if number != name and number.isascii() and number.isdigit():
            found = read(name, 2)
            assert found is not None
            coordinates[int(number[:6])] = found
    return Geometry(
        positions[used], triangles, read("NORMAL", 3), coordinates, _colors(read("COLOR_0", 3, 4))
    )


def _colors(values: Floats | None) -> Floats | None:
    """Return colors with alpha, shape (n, 4); None if all are white and opaque."""
    if values is None:
        return None
    colors = np.ones((len(values), 4))
    colors[:, : values.shape[1]] = values.clip(0, 1)
    return None if (colors == 1).all() else colors


def _triangles(document: Document, primitive: Primitive, vertices: int) -> Indices:
    if primitive.indices is None:
        indices = np.arange(vertices, dtype=np.int64)
    else:
        indices = read_indices(document, primitive.indices)
    shapes.check(indices, vertices)
    if primitive.mode == _STRIP:
        return shapes.strip(indices)
    if primitive.mode == _FAN:
        return shapes.fan(indices)
    return indices[: len(indices) // 3 * 3].reshape(-1, 3)
