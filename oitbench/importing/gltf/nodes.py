"""The hierarchy of nodes: their places in the world, and copies by instancing."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from oitbench.errors import SceneError
from oitbench.importing.gltf.accessors import read_vectors
from oitbench.importing.gltf.document import Document
from oitbench.importing.gltf.extensions import INSTANCING, Instancing
from oitbench.importing.gltf.schema import Node
from oitbench.scene import Floats


def walk(document: Document) -> Iterator[tuple[int, Node, Floats]]:
    """Yield the number, the node and the transform to the world of each node of the scene.

    Raises
    ------
    SceneError
        A node has two parents, or is its own ancestor.
    """
    nodes = document.gltf.nodes
    document.budget.take("nodes", len(nodes))
    waiting = [(index, np.eye(4)) for index in reversed(_roots(document))]
    seen = set()
    while waiting:
        index, above = waiting.pop()
        node = document.part("node", nodes, index)
        if index in seen:
            raise SceneError(f"node {index} has two parents, or is its own ancestor")
        seen.add(index)
        with np.errstate(all="ignore"):
            matrix = above @ _matrix(node)
        if not np.isfinite(matrix).all():
            raise SceneError(f"the transform of node {index} is out of range")
        yield index, node, matrix
        waiting += [(child, matrix) for child in reversed(node.children)]


def copies(document: Document, node: Node) -> Floats | None:
    """Return the transforms of the copies of a node's mesh, shape (n, 4, 4); None without."""
    found = node.extension(INSTANCING, Instancing)
    if found is None:
        return None
    parts = {
        name: read_vectors(document, found.attributes[name], width)
        for name, width in (("TRANSLATION", 3), ("ROTATION", 4), ("SCALE", 3))
        if name in found.attributes
    }
    counts = {len(values) for values in parts.values()}
    if len(counts) != 1:
        raise SceneError(f"{INSTANCING} has attributes of {sorted(counts)} copies; export it again")
    (count,) = counts
    document.budget.take("nodes", count)
    zero, one = np.zeros((count, 3)), np.ones((count, 3))
    still = np.tile([0.0, 0.0, 0.0, 1.0], (count, 1))
    return _placed(
        parts.get("TRANSLATION", zero), parts.get("ROTATION", still), parts.get("SCALE", one)
    )


def _roots(document: Document) -> list[int]:
    gltf = document.gltf
    if gltf.scenes:
        if len(gltf.scenes) > 1:
            document.notes.add("only one of several scenes is shown")
        return document.part("scene", gltf.scenes, gltf.scene or 0).nodes
    children = {child for node in gltf.nodes for child in node.children}
    return [index for index in range(len(gltf.nodes)) if index not in children]


def _matrix(node: Node) -> Floats:
    if node.matrix is not None:
        matrix = np.array(node.matrix, dtype=np.float64).reshape(4, 4).T
        # Only affine transforms are allowed.
        matrix[3] = 0, 0, 0, 1
        return matrix
    place, turn, size = (np.array([v]) for v in (node.translation, node.rotation, node.scale))
    matrices: Floats = _placed(place, turn, size)
    return np.asarray(matrices[0])


def _placed(translation: Floats, rotation: Floats, scale: Floats) -> Floats:
    """Return the matrices of translations, rotations (x, y, z, w) and scales; scales first."""
    with np.errstate(all="ignore"):
        lengths = np.linalg.norm(rotation, axis=1, keepdims=True)
        turned = (lengths > 1e-12) & (lengths < 1e12)
        x, y, z, w = np.where(turned, rotation / lengths, [0.0, 0.0, 0.0, 1.0]).T
        matrices = np.zeros((len(translation), 4, 4))
        rows = (
            (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
            (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
            (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
        )
        for row, entries in enumerate(rows):
            for column, entry in enumerate(entries):
                matrices[:, row, column] = entry * scale[:, column]
    matrices[:, :3, 3] = translation
    matrices[:, 3, 3] = 1
    return matrices
