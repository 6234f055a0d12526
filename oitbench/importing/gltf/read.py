"""Reads a glTF file: one object for each primitive of each node."""

from __future__ import annotations

import numpy as np

from oitbench.errors import SceneError
from oitbench.importing import shapes
from oitbench.importing.content import Content, Names
from oitbench.importing.files import Folder
from oitbench.importing.gltf.beams import add_camera, add_light
from oitbench.importing.gltf.document import Document
from oitbench.importing.gltf.materials import Look, Materials
from oitbench.importing.gltf.nodes import copies, walk
from oitbench.importing.gltf.primitives import Geometry, read_primitive
from oitbench.importing.limits import Budget, short
from oitbench.importing.notes import Notes
from oitbench.scene import Floats, Mesh


def read_gltf(folder: Folder, budget: Budget, notes: Notes) -> Content:
    """Return the content of a .glb or .gltf file."""
    document = Document(folder, budget, notes)
    return _Reader(document).content()


class _Reader:
    def __init__(self, document: Document) -> None:
        self._document = document
        self._materials = Materials(document)
        self._geometries: dict[tuple[int, int], Geometry | None] = {}
        self._content, self._names = Content(), Names()

    def content(self) -> Content:
        document = self._document
        for index, node, matrix in walk(document):
            add_camera(document, self._content, node, matrix)
            add_light(document, self._content, node, matrix)
            if node.mesh is None:
                continue
            placed = copies(document, node)
            matrices = matrix[None] if placed is None else matrix @ placed
            self._add_mesh(node.mesh, node.name or f"node {index}", matrices)
        return self._content

    def _add_mesh(self, number: int, name: str, matrices: Floats) -> None:
        document = self._document
        mesh = document.part("mesh", document.gltf.meshes, number)
        for part, primitive in enumerate(mesh.primitives):
            key = number, part
            if key not in self._geometries:
                try:
                    self._geometries[key] = read_primitive(document, primitive)
                except SceneError as error:
                    owner = mesh.name or f"mesh {number}"
                    raise SceneError(f"{short(owner)}: {error}") from error
            geometry = self._geometries[key]
            look = self._materials.look(primitive.material, geometry)
            if geometry is None:
                continue
            title = self._names.free(name)
            document.budget.take("triangles", len(geometry.triangles) * len(matrices))
            document.budget.take("vertices", len(geometry.positions) * len(matrices))
            placed = self._mesh(geometry, look, matrices, title)
            scale = float(np.abs(np.linalg.det(matrices[0, :3, :3])) ** (1 / 3))
            found = self._materials.fitted(look, placed, title, scale)
            if found is not None:
                self._content.objects.append(found)

    def _mesh(self, geometry: Geometry, look: Look, matrices: Floats, name: str) -> Mesh:
        """Return the copies of a geometry as one mesh in the world."""
        positions, normals = geometry.positions, geometry.normals
        triangles = geometry.triangles
        parts = []
        with np.errstate(all="ignore"):
            for number, matrix in enumerate(matrices):
                place, direction, mirrors = shapes.moved(matrix, positions, normals)
                turned = triangles[:, ::-1] if mirrors else triangles
                if direction is not None:
                    direction = shapes.unit_normals(direction, place, turned)
                parts.append((place, direction, turned + number * len(positions)))
        places = np.concatenate([place for place, _, _ in parts])
        return Mesh.from_arrays(
            places,
            np.concatenate([turned for _, _, turned in parts]),
            uvs=self._uvs(geometry, look, len(matrices), name),
            normals=None if normals is None else np.concatenate([d for _, d, _ in parts]),
            **self._colors(geometry, look, len(matrices)),
        )

    def _uvs(self, geometry: Geometry, look: Look, count: int, name: str) -> Floats | None:
        if look.placement is None:
            return None
        found = geometry.coordinates.get(look.placement.set)
        if found is None:
            self._document.notes.add("a texture without coordinates shows one texel", name)
            found = np.zeros((len(geometry.positions), 2))
        return np.tile(look.placement.uvs(found), (count, 1))

    def _colors(self, geometry: Geometry, look: Look, count: int) -> dict[str, Floats]:
        """Return the factors at vertices on the properties of a material."""
        if geometry.colors is None:
            return {}
        colors = np.tile(geometry.colors, (count, 1))
        found = {"radiance" if look.unlit else "albedo": colors[:, :3]}
        if not look.unlit and look.passes:
            found["transmission"] = colors[:, :3]
        if look.alpha and (colors[:, 3] != 1).any():
            found["coverage"] = colors[:, 3]
        return found
