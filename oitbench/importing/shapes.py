"""Geometry of imported meshes: strips and fans, degenerate triangles, transforms, closed meshes."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from oitbench.errors import SceneError
from oitbench.scene import Floats, Mesh

Indices = npt.NDArray[np.int64]
_FLAT = 1e-12
"""Twice the area of a triangle over the square of its longest edge, below which it is a line."""


def check(triangles: Indices, vertices: int) -> None:
    """Raise `SceneError` if a triangle uses a vertex that does not exist."""
    if len(triangles):
        low, high = int(triangles.min()), int(triangles.max())
        if low < 0 or high >= vertices:
            raise SceneError(
                f"a triangle uses vertex {low if low < 0 else high} of {vertices}; export it again"
            )


def strip(indices: Indices) -> Indices:
    """Return the triangles of a strip, shape (n, 3), all with the orientation of the first."""
    count = max(0, len(indices) - 2)
    first, odd = np.arange(count), np.arange(count) % 2
    corners = np.stack([first, first + 1 + odd, first + 2 - odd], axis=1)
    return np.asarray(indices[corners])


def fan(indices: Indices) -> Indices:
    """Return the triangles of a fan, shape (n, 3)."""
    first = np.arange(1, max(1, len(indices) - 1))
    corners = np.stack([np.zeros_like(first), first, first + 1], axis=1)
    return np.asarray(indices[corners])


def sound(positions: Floats, triangles: Indices) -> npt.NDArray[np.bool_]:
    """Return which triangles have an area, shape (m,)."""
    kept = np.empty(len(triangles), dtype=bool)
    # In blocks, since the corners of a large mesh take much memory.
    for start in range(0, len(triangles), 1 << 18):
        a, b, c = (positions[column] for column in triangles[start : start + (1 << 18)].T)
        first, second, third = b - a, c - a, c - b
        longest = np.max([(edge * edge).sum(axis=1) for edge in (first, second, third)], axis=0)
        area = np.linalg.norm(np.cross(first, second), axis=1)
        kept[start : start + len(a)] = area > _FLAT * longest
    return kept


def compact(positions: Floats, triangles: Indices) -> tuple[Indices, Indices]:
    """Return the vertices that triangles use, in order, and the triangles of their numbers."""
    if len(triangles) < len(positions) // 16:
        # Many primitives may each use a small part of the same vertices.
        vertices, numbers = np.unique(triangles, return_inverse=True)
        return vertices, numbers.reshape(triangles.shape)
    used = np.zeros(len(positions), dtype=bool)
    used[triangles] = True
    if used.all():
        return np.arange(len(positions)), triangles
    return np.flatnonzero(used), (np.cumsum(used) - 1)[triangles]


def distinct_rows(table: Indices) -> tuple[Indices, Indices]:
    """Return the distinct rows of a table in order, and the number of each row among them."""
    low = table.min(axis=0)
    spans = [int(span) + 1 for span in table.max(axis=0) - low]
    if math.prod(spans) >= 2**62:
        rows, numbers = np.unique(table, axis=0, return_inverse=True)
        return rows, numbers.reshape(-1)
    # One number for each row sorts much faster.
    keys = np.zeros(len(table), dtype=np.int64)
    for column, span in enumerate(spans):
        keys = keys * span + (table[:, column] - low[column])
    _, first, numbers = np.unique(keys, return_index=True, return_inverse=True)
    return table[first], numbers


def moved(
    matrix: Floats, positions: Floats, normals: Floats | None
) -> tuple[Floats, Floats | None, bool]:
    """Return transformed positions and unit normals, and whether the transform mirrors.

    Parameters
    ----------
    matrix : array, shape (4, 4)
        Affine.
    positions, normals : array, shape (n, 3)
    """
    linear = matrix[:3, :3]
    placed = np.einsum("ij,kj->ik", positions, linear) + matrix[:3, 3]
    mirrors = bool(np.linalg.det(linear) < 0)
    if normals is None:
        return placed, None, mirrors
    # Normals follow the matrix of cofactors, which a flattening transform has, too.
    cofactors = np.stack([np.cross(linear[(k + 1) % 3], linear[(k + 2) % 3]) for k in range(3)])
    turned = np.einsum("ij,kj->ik", normals, -cofactors if mirrors else cofactors)
    return placed, turned, mirrors


def unit_normals(normals: Floats, positions: Floats, triangles: Indices) -> Floats:
    """Return normals of length one; where a file has none, the mean of the adjacent triangles'."""
    lengths = np.linalg.norm(normals, axis=1)
    good = np.isfinite(lengths) & (lengths > 1e-30)
    if not good.all():
        means = mean_normals(positions, triangles)
        normals = np.where(good[:, None], normals, means)
        lengths = np.linalg.norm(normals, axis=1)
    return np.asarray(normals / lengths[:, None])


def mean_normals(positions: Floats, triangles: Indices) -> Floats:
    """Return unit normals of the vertices: means over their triangles, weighted by area."""
    a, b, c = (positions[column] for column in triangles.T)
    faces = np.cross(b - a, c - a)
    sums = np.zeros_like(positions)
    for axis in range(3):
        for column in triangles.T:
            sums[:, axis] += np.bincount(column, faces[:, axis], len(positions))
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    up = np.array([0.0, 1.0, 0.0])
    return np.where(lengths > 0, sums / np.maximum(lengths, 1e-300), up)


def encloses(mesh: Mesh) -> bool:
    """Return whether a mesh bounds a solid: each edge joins two triangles, normals are outwards.

    Vertices at one place count as one.
    """
    positions = np.ascontiguousarray(mesh.positions + 0.0)
    _, welded = np.unique(positions.view("V24").ravel(), return_inverse=True)
    loops = welded.reshape(-1)[mesh.triangles].astype(np.int64)
    count = len(positions)
    ahead = (loops * count + np.roll(loops, -1, axis=1)).ravel()
    back = (np.roll(loops, -1, axis=1) * count + loops).ravel()
    ahead.sort()
    back.sort()
    single = bool((ahead[1:] != ahead[:-1]).all())
    if not single or not np.array_equal(ahead, back):
        return False
    a, b, c = (mesh.positions[column] for column in mesh.triangles.T)
    middle = mesh.positions.mean(axis=0)
    return bool(np.einsum("ij,ij->", a - middle, np.cross(b - middle, c - middle)) > 0)
