"""Procedural meshes: flat and curved patches, surfaces of revolution, and copies of them.

All positions are metres in a right-handed space with y up; triangles run counter-clockwise seen
from the side their normals point to. Every builder returns float32 vertices with uvs and normals.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from oitbench.scene import RGB, Mesh

Floats = npt.NDArray[np.float64]


def divisions(base: float, detail: float, least: int = 1) -> int:
    """Return how often to divide an edge so that the number of triangles grows with `detail`.

    Parameters
    ----------
    base : float
        Divisions at detail 1.
    detail : float
        Factor on the number of triangles of a surface; not negative.
    least : int
        Never fewer than this.
    """
    return max(least, round(base * math.sqrt(detail)))


def grid(center: RGB, right: RGB, up: RGB, columns: int = 1, rows: int = 1) -> Mesh:
    """Return the parallelogram center ± right ± up, divided into columns × rows cells.

    Its normal is right × up; u runs along `right` and v along `up`, both from 0 to 1.
    """
    u, v = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1))
    uvs = np.stack([u.ravel(), v.ravel()], axis=1)
    edges = np.array([right, up], dtype=np.float64)
    positions = np.asarray(center, dtype=np.float64) + (2 * uvs - 1) @ edges
    normal = _unit(np.cross(edges[0], edges[1]))
    return _mesh(positions, _lattice(columns, rows), uvs, np.tile(normal, (len(uvs), 1)))


def quad(center: RGB, right: RGB, up: RGB) -> Mesh:
    """Return the parallelogram center ± right ± up as two triangles."""
    return grid(center, right, up)


def box(center: RGB, size: RGB, cells: int = 1) -> Mesh:
    """Return an axis-aligned box of edge lengths `size`, each face divided into cells × cells."""
    half = np.asarray(size, dtype=np.float64) / 2
    faces = []
    for axis in range(3):
        for sign in (1, -1):
            # A cyclic pair of axes spans the face; the sign turns its normal outwards.
            offset, right, up = np.zeros((3, 3))
            offset[axis] = sign * half[axis]
            right[(axis + 1) % 3] = sign * half[(axis + 1) % 3]
            up[(axis + 2) % 3] = half[(axis + 2) % 3]
            middle = np.asarray(center, dtype=np.float64) + offset
            faces.append(grid(_triple(middle), _triple(right), _triple(up), cells, cells))
    return merge(faces)


def lathe(profile: npt.ArrayLike, slices: int) -> Mesh:
    """Return the surface of revolution of a profile round the y axis.

    Parameters
    ----------
    profile : array, shape (n, 2)
        Points (radius, height) in metres. A profile that runs upwards has outward normals, its
        reverse has inward ones. No two successive points may coincide.
    slices : int
        Divisions round the axis, at least 3.

    Returns
    -------
    Mesh
        u runs round the axis and v along the profile. Normals are smooth along the profile, so a
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
    angle[-1] = 0.0  # exactly the first column again, so that the seam cannot crack
    around = np.stack([np.sin(angle), np.cos(angle)], axis=1)
    tangent = np.gradient(points, axis=0)
    slope = _unit(np.stack([tangent[:, 1], -tangent[:, 0]], axis=1))
    u, v = np.meshgrid(np.linspace(0, 1, slices + 1), np.linspace(0, 1, len(points)))
    triangles = _lattice(slices, len(points) - 1)
    positions = _revolve(points, around)
    return _mesh(
        positions,
        triangles[~_degenerate(positions, triangles)],
        np.stack([u.ravel(), v.ravel()], axis=1),
        _revolve(slope, around),
    )


def sphere(center: RGB, radius: float, slices: int, stacks: int) -> Mesh:
    """Return a sphere divided into `slices` round the y axis and `stacks` from pole to pole."""
    polar = np.linspace(0, math.pi, stacks + 1)
    profile = np.stack([np.sin(polar), -np.cos(polar)], axis=1)
    profile[[0, -1], 0] = 0.0
    unit = lathe(profile, slices)
    placed = transform(unit, translation(center) @ scaling((radius, radius, radius)))
    return replace(placed, normals=unit.positions)


def smooth_curve(corners: npt.ArrayLike, count: int) -> Floats:
    """Return `count` points, evenly spaced, on the polygon `corners` with its corners rounded off.

    Parameters
    ----------
    corners : array, shape (n, d)
        Open polygon; the curve starts and ends at its ends and stays inside its convex hull.
    count : int
        Points returned, at least 2.

    References
    ----------
    Chaikin 1974, "An algorithm for high-speed curve generation"; the limit is a quadratic B-spline.
    """
    curve = np.asarray(corners, dtype=np.float64)
    for _ in range(5):
        first, second = curve[:-1], curve[1:]
        cut = np.stack([0.75 * first + 0.25 * second, 0.25 * first + 0.75 * second], axis=1)
        curve = np.concatenate([curve[:1], cut.reshape(-1, curve.shape[1]), curve[-1:]])
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))])
    at = np.linspace(0, length[-1], count)
    return np.stack([np.interp(at, length, column) for column in curve.T], axis=1)


def frames(centers: npt.ArrayLike, rights: npt.ArrayLike, ups: npt.ArrayLike) -> Floats:
    """Return affine frames, shape (k, 3, 4), with axes along rights, ups and their normal.

    The lengths of `rights` and `ups`, shape (k, 3), scale what is placed; z is scaled as x is.
    """
    x, y = np.asarray(rights, dtype=np.float64), np.asarray(ups, dtype=np.float64)
    z = _unit(np.cross(x, y)) * np.linalg.norm(x, axis=-1, keepdims=True)
    return np.stack([x, y, z, np.broadcast_to(np.asarray(centers), x.shape)], axis=-1)


def scatter(template: Mesh, placements: Floats) -> Mesh:
    """Return one mesh of `template` placed by each affine frame, shape (k, 3, 4), in order."""
    count = len(placements)
    linear, offset = placements[:, :, :3], placements[:, :, 3]
    if (np.linalg.det(linear) <= 0).any():
        raise ValueError("a frame flattens the template or turns it inside out")
    positions = np.einsum("kij,nj->kni", linear, template.positions) + offset[:, None]
    normals = None
    if template.normals is not None:
        # The cofactor matrix keeps normals perpendicular under any linear map.
        cofactor = np.linalg.det(linear)[:, None, None] * np.linalg.inv(linear).swapaxes(1, 2)
        normals = _unit(np.einsum("kij,nj->kni", cofactor, template.normals)).reshape(-1, 3)
    triangles = template.triangles.astype(np.int64)
    starts = np.arange(count)[:, None, None] * len(template.positions)
    return _mesh(
        positions.reshape(-1, 3),
        (triangles[None] + starts).reshape(-1, 3),
        None if template.uvs is None else np.tile(template.uvs, (count, 1)),
        normals,
        None if template.radiance is None else np.tile(template.radiance, (count, 1)),
    )


def merge(meshes: Sequence[Mesh]) -> Mesh:
    """Return one mesh of all triangles, in order; all meshes must carry the same attributes."""
    starts = np.cumsum([0] + [len(mesh.positions) for mesh in meshes[:-1]])
    return _mesh(
        np.concatenate([mesh.positions for mesh in meshes]),
        np.concatenate(
            [
                mesh.triangles.astype(np.int64) + start
                for mesh, start in zip(meshes, starts, strict=True)
            ]
        ),
        _joined("uvs", [mesh.uvs for mesh in meshes]),
        _joined("normals", [mesh.normals for mesh in meshes]),
        _joined("radiance", [mesh.radiance for mesh in meshes]),
    )


def transform(mesh: Mesh, matrix: Floats) -> Mesh:
    """Return `mesh` under an affine (4, 4) matrix that does not mirror."""
    return scatter(mesh, matrix[None, :3])


def translation(offset: RGB) -> Floats:
    """Return the (4, 4) matrix of a shift in metres."""
    matrix = np.eye(4)
    matrix[:3, 3] = offset
    return matrix


def scaling(factors: RGB) -> Floats:
    """Return the (4, 4) matrix of a scaling along the axes."""
    return np.diag([*factors, 1.0])


def rotation(axis: RGB, angle: float) -> Floats:
    """Return the (4, 4) matrix of a right-handed rotation by `angle` radians round `axis`."""
    x, y, z = _unit(np.asarray(axis, dtype=np.float64))
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    matrix = np.eye(4)
    matrix[:3, :3] += math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross
    return matrix


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))


def _triple(values: Floats) -> RGB:
    return (float(values[0]), float(values[1]), float(values[2]))


def _lattice(columns: int, rows: int) -> npt.NDArray[np.int64]:
    """Return two triangles per cell of a (rows + 1) × (columns + 1) array of vertices."""
    column, row = np.meshgrid(np.arange(columns), np.arange(rows))
    corner = (row * (columns + 1) + column).ravel()
    above = corner + columns + 1
    pairs = [np.stack([corner, corner + 1, above + 1]), np.stack([corner, above + 1, above])]
    return np.stack(pairs).transpose(2, 0, 1).reshape(-1, 3)


def _revolve(profile: Floats, around: Floats) -> Floats:
    radial = profile[:, None, 0, None] * around[None]
    height = np.broadcast_to(profile[:, None, 1], radial.shape[:2])
    return np.stack([radial[..., 0], height, radial[..., 1]], axis=-1).reshape(-1, 3)


def _degenerate(positions: Floats, triangles: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
    corners = positions[triangles]
    following = np.roll(corners, -1, axis=1)
    return np.asarray((corners == following).all(axis=2).any(axis=1))


def _joined(name: str, values: Sequence[npt.NDArray[np.float32] | None]) -> Floats | None:
    present = [value for value in values if value is not None]
    if present and len(present) != len(values):
        raise ValueError(f"only some of the meshes to merge have {name}")
    return np.concatenate(present).astype(np.float64) if present else None


def _mesh(
    positions: npt.ArrayLike,
    triangles: npt.NDArray[np.int64],
    uvs: npt.ArrayLike | None = None,
    normals: npt.ArrayLike | None = None,
    radiance: npt.ArrayLike | None = None,
) -> Mesh:
    return Mesh(
        np.asarray(positions, dtype=np.float32),
        triangles.astype(np.uint32),
        None if uvs is None else np.asarray(uvs, dtype=np.float32),
        None if radiance is None else np.asarray(radiance, dtype=np.float32),
        None if normals is None else np.asarray(normals, dtype=np.float32),
    )
