"""Surfaces of functions: signed distances, their smooth unions, and the mesh where one is zero.

A signed distance is a function of points, shape (n, 3), in meters: negative inside a body and about
the distance to its surface elsewhere. Bodies that are joined smoothly have no crease.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from oitbench.scene import Floats, Mesh, Vector, unit

Distance = Callable[[Floats], Floats]
"""A signed distance: from points, shape (n, 3), to meters, shape (n,)."""
COARSE = 4
"""Cells along the edge of a block; only blocks near the surface are evaluated cell by cell."""
_STEP = 2e-4
"""Half the distance over which gradients are measured, meters."""


def ellipsoid(points: Floats, center: Vector, radii: Vector) -> Floats:
    """Return the approximate signed distance to an ellipsoid, exact on its surface and for balls.

    References
    ----------
    Quilez 2008, "Ellipsoid: distance", the bound of first order.
    """
    scaled = (points - np.asarray(center)) / np.asarray(radii)
    first = np.linalg.norm(scaled, axis=1)
    second = np.linalg.norm(scaled / np.asarray(radii), axis=1)
    return np.asarray(first * (first - 1) / np.maximum(second, 1e-12))


def capsule(points: Floats, start: Vector, end: Vector, first: float, last: float) -> Floats:
    """Return the signed distance to a round limb of radius `first` at `start`, `last` at `end`."""
    axis = np.subtract(end, start)
    offset = points - np.asarray(start)
    along = np.clip(offset @ axis / (axis @ axis), 0, 1)
    gap = np.linalg.norm(offset - along[:, None] * axis, axis=1)
    return np.asarray(gap - (first + (last - first) * along))


def joined(first: Floats, second: Floats, blend: float) -> Floats:
    """Return the union of two bodies, whose crease is filled within `blend` meters."""
    near = np.maximum(blend - np.abs(first - second), 0) / blend
    return np.asarray(np.minimum(first, second) - near**2 * blend / 4)


def carved(body: Floats, tool: Floats, blend: float) -> Floats:
    """Return a body less another one, with an edge that is rounded within `blend` meters."""
    return -joined(-body, tool, blend)


def gradients(distance: Distance, points: Floats) -> Floats:
    """Return unit vectors away from the body, shape (n, 3)."""
    parts = []
    for axis in np.eye(3) * _STEP:
        parts.append(distance(points + axis) - distance(points - axis))
    return unit(np.stack(parts, axis=1))


def surface(distance: Distance, low: Vector, high: Vector, cell: float) -> Mesh:
    """Return the mesh where a signed distance is zero, with smooth normals.

    Parameters
    ----------
    distance : Distance
    low, high : Vector
        Corners of the box that is searched, meters. The mesh is open where the body leaves it.
    cell : float
        About the length of an edge of a triangle, meters.

    References
    ----------
    Lewiner et al. 2003, "Efficient implementation of Marching Cubes' cases with topological
    guarantees".
    """
    import skimage.measure

    counts = np.ceil(np.subtract(high, low) / (COARSE * cell)).astype(int) * COARSE + 1
    lines = [np.linspace(*ends) for ends in zip(low, high, counts, strict=True)]
    lattice = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1)
    values = _sampled(distance, lattice)
    spacing = [float(line[1] - line[0]) for line in lines]
    points, triangles, _, _ = skimage.measure.marching_cubes(
        values, 0.0, spacing=spacing, allow_degenerate=False, gradient_direction="ascent"
    )
    places = points.astype(np.float64) + np.asarray(low)
    return Mesh.from_arrays(places, triangles, normals=gradients(distance, places))


def _sampled(distance: Distance, lattice: Floats) -> Floats:
    """Return the distance at a lattice, shape (x, y, z, 3); far from the surface, about that."""
    corners = np.ascontiguousarray(lattice[::COARSE, ::COARSE, ::COARSE])
    coarse = distance(corners.reshape(-1, 3)).reshape(corners.shape[:3])
    fine = coarse
    for axis in range(3):
        fine = np.repeat(fine, COARSE, axis=axis)
    shifts = tuple(slice(COARSE // 2, COARSE // 2 + length) for length in lattice.shape[:3])
    values = np.array(fine[shifts])
    # The diagonal of a block, twice its radius, as distances to smooth unions are not exact.
    reach = np.linalg.norm(lattice[COARSE, COARSE, COARSE] - lattice[0, 0, 0])
    close = np.abs(values) < reach
    values[close] = distance(lattice[close])
    return values
