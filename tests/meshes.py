"""Properties of meshes that several tests measure."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from oitbench.scene import Floats, Mesh


def corners(mesh: Mesh) -> Floats:
    """Return the corners of the triangles, shape (n, 3, 3)."""
    return np.asarray(mesh.positions[mesh.triangles])


def bounds(mesh: Mesh) -> tuple[Floats, Floats]:
    """Return the lowest and the highest coordinates."""
    return mesh.positions.min(axis=0), mesh.positions.max(axis=0)


def face_normals(mesh: Mesh) -> Floats:
    """Return normals of twice the area of each triangle, shape (n, 3)."""
    a, b, c = corners(mesh).swapaxes(0, 1)
    return np.asarray(np.cross(b - a, c - a))


def signed_volume(mesh: Mesh) -> float:
    """Return the enclosed volume, negative if the normals point inwards."""
    a, b, c = corners(mesh).swapaxes(0, 1)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def agreement(mesh: Mesh) -> Floats:
    """Return face normal · vertex normal at each corner, up to scale, shape (n, 3)."""
    assert mesh.normals is not None
    normals = mesh.normals[mesh.triangles]
    return np.asarray(np.einsum("ij,ikj->ik", face_normals(mesh), normals))


def has_unit_normals(mesh: Mesh) -> bool:
    assert mesh.normals is not None
    return np.allclose(np.linalg.norm(mesh.normals, axis=1), 1, atol=1e-5)


def boundary(mesh: Mesh) -> Floats:
    """Return the starts of the edges that do not join exactly two triangles, shape (k, 3).

    Vertices at the same place count as one. A mesh without such edges is watertight: it has no
    crack, and no duplicated, collapsed or reversed triangle.
    """
    rounded = mesh.positions.astype(np.float32).astype(np.float64)
    places, welded = np.unique(rounded, axis=0, return_inverse=True)
    loops = welded.reshape(-1)[mesh.triangles].astype(np.int64)
    edges = loops.ravel() * len(places) + np.roll(loops, -1, axis=1).ravel()
    found, counts = np.unique(edges, return_counts=True)
    starts, ends = np.divmod(found, len(places))
    paired = np.isin(ends * len(places) + starts, found)
    return np.asarray(places[starts[(counts != 1) | ~paired | (starts == ends)]])


def coincident(meshes: Sequence[Mesh]) -> int:
    """Return the number of triangles that have the same corners as another one."""
    triangles = np.concatenate([mesh.positions[mesh.triangles] for mesh in meshes])
    triangles = triangles.astype(np.float32)
    order = np.lexsort(triangles.transpose(2, 0, 1)[::-1], axis=1)
    in_order = np.take_along_axis(triangles, order[..., None], axis=1).reshape(-1, 9)
    # Adding zero makes both zeros the same bytes.
    rows = np.ascontiguousarray(in_order + np.float32(0)).view("V36")
    return len(rows) - len(np.unique(rows))


def hits(mesh: Mesh, origin: npt.ArrayLike, direction: npt.ArrayLike) -> Floats:
    """Return where a ray meets the mesh, in lengths of `direction`, ascending.

    References
    ----------
    Möller & Trumbore 1997, "Fast, minimum storage ray-triangle intersection".
    """
    start, ray = np.asarray(origin, np.float64), np.asarray(direction, np.float64)
    a, b, c = corners(mesh).swapaxes(0, 1)
    normal = np.cross(b - a, c - a)
    scale = normal @ ray
    parallel = np.abs(scale) < 1e-12
    scale[parallel] = 1.0
    offset = np.cross(start - a, ray)
    u = -np.einsum("ij,ij->i", c - a, offset) / scale
    v = np.einsum("ij,ij->i", b - a, offset) / scale
    at = np.einsum("ij,ij->i", a - start, normal) / scale
    return np.sort(at[~parallel & (u >= 0) & (v >= 0) & (u + v <= 1) & (at > 1e-6)])


def count_hits(
    mesh: Mesh, origins: npt.ArrayLike, directions: npt.ArrayLike
) -> npt.NDArray[np.int64]:
    """Return the number of triangles that each ray meets; origins and directions broadcast."""
    pairs = np.broadcast_arrays(np.atleast_2d(origins), np.atleast_2d(directions))
    return np.array([len(hits(mesh, *pair)) for pair in zip(*pairs, strict=True)])
