"""Closed solids: profiles turned about an axis, and rings joined by lofting.

Every mesh here bounds a solid: each edge is shared by two triangles, normals point outwards, and no
vertex is duplicated, so that refraction finds an inside and an outside everywhere.
"""

from __future__ import annotations

import math

import numpy as np

from oitbench.scene import Floats, Mesh, unit


def turned(profile: Floats, slices: int) -> Mesh:
    """Return the solid of revolution of a profile that starts and ends on the y axis.

    Parameters
    ----------
    profile : array, shape (n, 2)
        (radius, height) in meters, from the foot along the outside to the other end.
    slices : int
        Divisions about the axis, at least 3.
    """
    return loft(round_rings(profile), slices)


def round_rings(profile: Floats) -> Floats:
    """Return the circular rings, for `loft`, of a profile (radius, height), shape (n, 2)."""
    radius, height = profile.T
    return np.stack([-radius, height, radius, height, radius], axis=1)


def loft(rings: Floats, slices: int) -> Mesh:
    """Return the closed tube through elliptic rings, with smooth normals.

    Parameters
    ----------
    rings : array, shape (n, 5)
        (x, y) of the back of each ring, (x, y) of its front, and half its width along z, meters.
        The first and the last ring are points. Seen from +z with the first ring below, the back is
        on the left.
    slices : int
        Divisions about the tube, at least 3.

    Raises
    ------
    ValueError
        If the tube is open at an end.
    """
    back, front, width = rings[:, 0:2], rings[:, 2:4], rings[:, 4]
    spans = np.hypot(np.linalg.norm(front - back, axis=1), width)
    if spans[0] != 0 or spans[-1] != 0:
        raise ValueError("the first and the last ring of a closed solid must be points")
    angle = np.arange(slices) / slices * 2 * math.pi
    positions = np.empty((len(rings), slices, 3))
    positions[..., :2] = (front + back)[:, None] / 2 + np.cos(angle)[:, None] * (front - back)[
        :, None
    ] / 2
    positions[..., 2] = -np.sin(angle) * width[:, None]
    return closed(positions)


def closed(points: Floats) -> Mesh:
    """Return the mesh of a grid of points that is closed along its second axis and at both ends.

    Parameters
    ----------
    points : array, shape (rings, slices, 3)
        All points of the first ring coincide, and so do those of the last.
    """
    rings, slices = points.shape[:2]
    around = np.roll(points, -1, axis=1) - np.roll(points, 1, axis=1)
    along = np.gradient(points, axis=0)
    normals = np.cross(around, along)
    for end, inner in ((0, 1), (-1, -2)):
        normals[end] = normals[inner].sum(axis=0)
    start = 1 + np.arange(rings - 3)[:, None] * slices
    this = np.arange(slices)
    following = np.roll(this, -1)
    lower, right = (start + this).ravel(), (start + following).ravel()
    upper, corner = lower + slices, right + slices
    last = 1 + (rings - 2) * slices
    base = last - slices
    triangles = np.concatenate(
        [
            np.stack([np.zeros_like(this), 1 + following, 1 + this], axis=1),
            np.stack([lower, right, corner], axis=1),
            np.stack([lower, corner, upper], axis=1),
            np.stack([base + this, base + following, np.full_like(this, last)], axis=1),
        ]
    )
    return Mesh.from_arrays(
        _one_vertex_each(points), triangles, normals=_one_vertex_each(unit(normals))
    )


def _one_vertex_each(values: Floats) -> Floats:
    """Return the values of all vertices in order, with one vertex for each of the two end rings."""
    return np.concatenate([values[0, :1], values[1:-1].reshape(-1, 3), values[-1, :1]])
