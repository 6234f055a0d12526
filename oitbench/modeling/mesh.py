"""Basic meshes: flat patches, boxes, surfaces of revolution and spheres.

Positions are meters in a right-handed space with y up. Triangles run counterclockwise seen from the
side that their normals point to. Every mesh here has uvs and normals.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from oitbench.modeling.placement import merge, scaling, transform, translation
from oitbench.modeling.profiles import outward
from oitbench.scene import Floats, Mesh, Vector, as_vector, unit

Indices = npt.NDArray[np.int64]


def grid(center: Vector, right: Vector, up: Vector, columns: int = 1, rows: int = 1) -> Mesh:
    """Return the parallelogram center ± right ± up, divided into columns × rows cells.

    Its normal is right × up; u runs along `right` and v along `up`, both from 0 to 1.
    """
    u, v = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1))
    uvs = np.stack([u.ravel(), v.ravel()], axis=1)
    edges = np.array([right, up], dtype=np.float64)
    positions = np.asarray(center, dtype=np.float64) + (2 * uvs - 1) @ edges
    normal = unit(np.cross(edges[0], edges[1]))
    return Mesh.from_arrays(
        positions, lattice(columns, rows), uvs=uvs, normals=np.tile(normal, (len(uvs), 1))
    )


def quad(center: Vector, right: Vector, up: Vector) -> Mesh:
    """Return the parallelogram center ± right ± up as two triangles."""
    return grid(center, right, up)


def box_faces(center: Vector, size: Vector) -> Iterator[tuple[Vector, Vector, Vector]]:
    """Yield the center, right and up of each face of an axis-aligned box of edge lengths `size`.

    They are arguments of `grid` that turn the normals outwards.
    """
    half = np.asarray(size, dtype=np.float64) / 2
    for axis in range(3):
        for sign in (1, -1):
            # A cyclic pair of axes spans the face; the sign turns its normal outwards.
            offset, right, up = np.zeros((3, 3))
            offset[axis] = sign * half[axis]
            right[(axis + 1) % 3] = sign * half[(axis + 1) % 3]
            up[(axis + 2) % 3] = half[(axis + 2) % 3]
            middle = np.asarray(center, dtype=np.float64) + offset
            yield as_vector(middle), as_vector(right), as_vector(up)


def box(center: Vector, size: Vector, cells: int = 1) -> Mesh:
    """Return an axis-aligned box of edge lengths `size`, each face divided into cells × cells."""
    return merge([grid(*face, cells, cells) for face in box_faces(center, size)])


def slab(low: Vector, high: Vector, cells: int = 1) -> Mesh:
    """Return the axis-aligned box between two opposite corners."""
    first, last = np.asarray(low), np.asarray(high)
    return box(as_vector((first + last) / 2), as_vector(last - first), cells)


def lathe(profile: npt.ArrayLike, slices: int) -> Mesh:
    """Return the surface of revolution of a profile about the y axis.

    Parameters
    ----------
    profile : array, shape (n, 2)
        Points (radius, height) in meters. A profile that runs upwards has outward normals, its
        reverse has inward ones. No two successive points may coincide.
    slices : int
        Divisions about the axis, at least 3.

    Returns
    -------
    Mesh
        u runs about the axis and v along the profile. Normals are smooth along the profile, so a
        crease needs two lathes.

    Raises
    ------
    ValueError
        For a profile of wrong shape, with a negative radius or with coinciding points.
    """
    points = np.asarray(profile, dtype=np.float64)
    if points.ndim != 2 or points.shape[0] < 2 or points.shape[1] != 2 or slices < 3:
        raise ValueError("a lathe needs a profile of shape (n ≥ 2, 2) and at least 3 slices")
    if (points[:, 0] < 0).any():
        raise ValueError("a lathe's profile has a negative radius")
    if (np.diff(points, axis=0) == 0).all(axis=1).any():
        raise ValueError("two successive points of a lathe's profile coincide")
    angle = np.linspace(0, 2 * math.pi, slices + 1)
    angle[-1] = 0.0  # equal to the first column exactly, so that the seam cannot crack
    around = np.stack([np.sin(angle), np.cos(angle)], axis=1)
    u, v = np.meshgrid(np.linspace(0, 1, slices + 1), np.linspace(0, 1, len(points)))
    positions, triangles = _revolve(points, around), lattice(slices, len(points) - 1)
    return Mesh.from_arrays(
        positions,
        triangles[~collapsed(positions, triangles)],
        uvs=np.stack([u.ravel(), v.ravel()], axis=1),
        normals=_revolve(unit(outward(points)), around),
    )


def sphere(center: Vector, radius: float, slices: int, stacks: int) -> Mesh:
    """Return a sphere divided into `slices` about the y axis and `stacks` from pole to pole."""
    polar = np.linspace(0, math.pi, stacks + 1)
    profile = np.stack([np.sin(polar), -np.cos(polar)], axis=1)
    profile[[0, -1], 0] = 0.0
    ball = lathe(profile, slices)
    placed = transform(ball, translation(center) @ scaling((radius, radius, radius)))
    return replace(placed, normals=ball.positions.astype(np.float32))


def collapsed(positions: npt.NDArray[np.floating], triangles: Indices) -> npt.NDArray[np.bool_]:
    """Return which triangles, shape (m, 3), have two corners at the same place; shape (m,)."""
    # Sines of equal angles may differ in the last digits of double precision.
    corners = positions.astype(np.float32)[triangles]
    following = np.roll(corners, -1, axis=1)
    return np.asarray((corners == following).all(axis=2).any(axis=1))


def triangle_areas(mesh: Mesh) -> Floats:
    """Return the areas of the triangles of a mesh, shape (m,)."""
    corners = mesh.positions[mesh.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.asarray(np.linalg.norm(normals, axis=1) / 2)


def lattice(columns: int, rows: int) -> Indices:
    """Return two triangles per cell of a (rows + 1) × (columns + 1) array of vertices."""
    column, row = np.meshgrid(np.arange(columns), np.arange(rows))
    corner = (row * (columns + 1) + column).ravel()
    above = corner + columns + 1
    pairs = [np.stack([corner, corner + 1, above + 1]), np.stack([corner, above + 1, above])]
    return np.stack(pairs).transpose(2, 0, 1).reshape(-1, 3)


def _revolve(profile: Floats, around: Floats) -> Floats:
    """Return the points of a profile in each of the directions `around` (x, z); row by row."""
    radial = profile[:, None, 0, None] * around[None]
    height = np.broadcast_to(profile[:, None, 1], radial.shape[:2])
    return np.stack([radial[..., 0], height, radial[..., 1]], axis=-1).reshape(-1, 3)
