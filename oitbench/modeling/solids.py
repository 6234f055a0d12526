"""Closed solids from rings: outlines with rounded corners, turned or lofted into one mesh each.

What is turned here bounds a solid: every edge is shared by two triangles, normals point outwards,
and no vertex is doubled, so refraction finds an inside and an outside everywhere.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from oitbench.modeling.baking import Floats
from oitbench.modeling.mesh import divisions
from oitbench.scene import Mesh

Corner = tuple[float, float, float]
"""(radius, height, radius of the fillet) of an outline, metres."""
STEPS_PER_TURN = 20
"""Chords at detail 1 of a fillet that turned a full circle."""


def outline(corners: Sequence[Corner], detail: float) -> Floats:
    """Return the polygon `corners` with each corner rounded by an arc of its own radius.

    Parameters
    ----------
    corners : sequence of (radius, height, fillet)
        Metres; ends keep their corner, and so does whatever has fillet 0.
    detail : float
        Factor on the number of triangles of what is turned from the outline.

    Returns
    -------
    array, shape (n, 2)
        (radius, height); successive points differ.

    Raises
    ------
    ValueError
        If two fillets, or a fillet and an end, need more of an edge than there is.
    """
    points = np.asarray(corners, dtype=np.float64)
    ends, radii = points[:, :2], points[:, 2]
    edges = np.diff(ends, axis=0)
    lengths = np.linalg.norm(edges, axis=1)
    directions = edges / lengths[:, None]
    cosine = np.einsum("ij,ij->i", directions[:-1], directions[1:]).clip(-1, 1)
    turn = np.pad(np.arccos(cosine), 1)
    reach = radii * np.tan(turn / 2)
    if (reach[:-1] + reach[1:] > lengths * (1 + 1e-9)).any():
        edge = int(np.argmax(reach[:-1] + reach[1:] - lengths))
        raise ValueError(f"the fillets at the ends of edge {edge} of an outline overlap")
    curve = [ends[:1]]
    for index in range(1, len(points) - 1):
        if reach[index] == 0:
            curve.append(ends[index : index + 1])
            continue
        steps = divisions(STEPS_PER_TURN * turn[index] / (2 * math.pi), detail, 2)
        before, after = directions[index - 1], directions[index]
        toward = (after - before) / np.linalg.norm(after - before)
        middle = ends[index] + toward * radii[index] / math.cos(turn[index] / 2)
        angle = (np.arange(steps + 1) / steps - 0.5) * turn[index]
        level = (before + after) / np.linalg.norm(before + after)
        arc = np.sin(angle)[:, None] * level - np.cos(angle)[:, None] * toward
        curve.append(middle + radii[index] * arc)
    curve.append(ends[-1:])
    joined = np.concatenate(curve)
    joined[np.abs(joined) < 1e-12] = 0.0
    apart = np.linalg.norm(np.diff(joined, axis=0), axis=1) > 1e-9
    return np.asarray(joined[np.concatenate([[True], apart])])


def turned(profile: Floats, slices: int) -> Mesh:
    """Return the solid of revolution of a profile (n, 2) that starts and ends on the y axis.

    Parameters
    ----------
    profile : array, shape (n, 2)
        (radius, height) in metres, from the foot round the outside to the other end.
    slices : int
        Divisions round the axis, at least 3.
    """
    radius, height = profile.T
    return loft(np.stack([-radius, height, radius, height, radius], axis=1), slices)


def loft(rings: Floats, slices: int) -> Mesh:
    """Return the closed tube through elliptic rings, with smooth normals and one vertex a corner.

    Parameters
    ----------
    rings : array, shape (n, 5)
        (x, y) of the back of each ring, (x, y) of its front, and half its width along z, metres.
        The first and the last ring are points; seen from +z, the tube runs with its back on
        the left.
    slices : int
        Divisions round the tube, at least 3.

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


def closed(grid: Floats) -> Mesh:
    """Return the mesh of a grid of points that is closed round its second axis.

    Parameters
    ----------
    grid : array, shape (rings, slices, 3)
        All points of the first ring coincide, and so do those of the last.
    """
    rings, slices = grid.shape[:2]
    around = np.roll(grid, -1, axis=1) - np.roll(grid, 1, axis=1)
    along = np.gradient(grid, axis=0)
    normals = np.cross(around, along)
    for end, inner in ((0, 1), (-1, -2)):
        normals[end] = normals[inner].sum(axis=0)
    lengths = np.linalg.norm(normals, axis=-1, keepdims=True)
    body = (slice(1, -1), slice(None))
    ends = (grid[0, :1], grid[-1, :1])
    positions = np.concatenate([ends[0], grid[body].reshape(-1, 3), ends[1]])
    unit = normals / lengths
    vertex = np.concatenate([unit[0, :1], unit[body].reshape(-1, 3), unit[-1, :1]])
    start = 1 + np.arange(rings - 3)[:, None] * slices
    this = np.arange(slices)
    following = np.roll(this, -1)
    lower, right = (start + this).ravel(), (start + following).ravel()
    upper, corner = lower + slices, right + slices
    last, base = len(positions) - 1, len(positions) - 1 - slices
    triangles = np.concatenate(
        [
            np.stack([np.zeros_like(this), 1 + following, 1 + this], axis=1),
            np.stack([lower, right, corner], axis=1),
            np.stack([lower, corner, upper], axis=1),
            np.stack([base + this, base + following, np.full_like(this, last)], axis=1),
        ]
    )
    return Mesh(
        positions.astype(np.float32),
        triangles.astype(np.uint32),
        normals=vertex.astype(np.float32),
    )
