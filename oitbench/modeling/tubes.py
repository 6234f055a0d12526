"""Tubes along curves: pipes, wires, boughs."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from oitbench.modeling.mesh import collapsed, lattice
from oitbench.scene import Floats, Mesh, unit


def tubes(curves: Floats, radii: npt.ArrayLike, sides: int) -> Mesh:
    """Return round tubes along curves, open at both ends, with smooth normals.

    Parameters
    ----------
    curves : array, shape (n, k, 3)
        k points of each curve, meters. Successive points differ.
    radii : array, broadcastable to (n, k)
        Meters.
    sides : int
        Divisions around a tube, at least 3.

    Returns
    -------
    Mesh
        u runs around a tube and v along it, both from 0 to 1.

    References
    ----------
    Wang et al. 2008, "Computation of rotation minimizing frames": the double reflection.
    """
    count, length = curves.shape[:2]
    along = unit(_tangents(curves))
    across = _frames(curves, along)
    upper = np.cross(along, across)
    angle = np.linspace(0, 2 * math.pi, sides + 1)
    angle[-1] = 0.0  # equal to the first column exactly, so that the seam cannot crack
    normals = (
        np.cos(angle)[:, None] * across[:, :, None] + np.sin(angle)[:, None] * upper[:, :, None]
    )
    reach = np.broadcast_to(np.asarray(radii, dtype=np.float64), (count, length))
    positions = (curves[:, :, None] + reach[..., None, None] * normals).reshape(-1, 3)
    faces = lattice(sides, length - 1).astype(np.int64)
    triangles = faces[None] + length * (sides + 1) * np.arange(count)[:, None, None]
    triangles = triangles.reshape(-1, 3)
    u, v = np.meshgrid(np.linspace(0, 1, sides + 1), np.linspace(0, 1, length))
    return Mesh.from_arrays(
        positions,
        triangles[~collapsed(positions, triangles)],
        uvs=np.tile(np.stack([u.ravel(), v.ravel()], axis=1), (count, 1)),
        normals=normals.reshape(-1, 3),
    )


def straight(starts: npt.ArrayLike, ends: npt.ArrayLike, points: int = 2) -> Floats:
    """Return straight curves between points, shape (n, points, 3)."""
    first, last = np.asarray(starts, dtype=np.float64), np.asarray(ends, dtype=np.float64)
    part = np.linspace(0, 1, points)[None, :, None]
    return np.asarray(first[:, None] * (1 - part) + last[:, None] * part)


def _tangents(curves: Floats) -> Floats:
    """Return directions that halve the angle at each inner point."""
    steps = unit(np.diff(curves, axis=1))
    inner = steps[:, 1:] + steps[:, :-1]
    return np.concatenate([steps[:, :1], inner, steps[:, -1:]], axis=1)


def _frames(curves: Floats, along: Floats) -> Floats:
    """Return unit vectors across each curve that do not turn about it, shape (n, k, 3)."""
    least = np.abs(along[:, 0]).argmin(axis=1)
    across = np.empty_like(along)
    across[:, 0] = unit(np.cross(along[:, 0], np.eye(3)[least]))
    for index in range(1, curves.shape[1]):
        step = curves[:, index] - curves[:, index - 1]
        turned = _mirrored(across[:, index - 1], step)
        ahead = _mirrored(along[:, index - 1], step)
        across[:, index] = _mirrored(turned, along[:, index] - ahead)
    return across


def _mirrored(vectors: Floats, normals: Floats) -> Floats:
    """Return vectors mirrored in planes; unchanged where the normal has no length."""
    square = np.maximum((normals**2).sum(axis=1, keepdims=True), 1e-300)
    return np.asarray(
        vectors - 2 * (vectors * normals).sum(axis=1, keepdims=True) / square * normals
    )
