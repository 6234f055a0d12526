"""Bodies of one cross-section: tubes along curves, cylinders, and plates cut from outlines.

Lengths are in the unit of the caller. All meshes here have normals and no uvs, so that they can be
merged with each other and with closed solids.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from oitbench.modeling.placement import merge, rotation, transform, translation
from oitbench.modeling.profiles import outline, smooth_curve
from oitbench.modeling.solids import closed, turned
from oitbench.scene import Floats, Mesh, Vector, as_vector, unit

HALVES = ((0, 1, 2), (0, 2, 3))
"""The two triangles of a quadrilateral."""
CREASE = math.cos(math.radians(35))
"""Cosine of the largest turn between two edges of an outline that are shaded as one curve."""


def tube(path: npt.ArrayLike, radius: npt.ArrayLike, sides: int) -> Mesh:
    """Return a closed round tube along a curve, with flat ends.

    Parameters
    ----------
    path : array, shape (n, 3)
        Points of the center line, n ≥ 2; no two successive ones coincide.
    radius : float or array, shape (n,)
        Above zero.
    sides : int
        Divisions about the tube, at least 3.
    """
    points = np.asarray(path, dtype=np.float64)
    radii = np.broadcast_to(np.asarray(radius, dtype=np.float64), len(points))
    tangents = unit(np.gradient(points, axis=0))
    across = np.empty_like(points)
    side = np.cross(tangents[0], np.eye(3)[np.argmin(np.abs(tangents[0]))])
    for place, tangent in enumerate(tangents):
        # The frame is carried along without twist.
        side = side - (side @ tangent) * tangent
        side = side / np.linalg.norm(side)
        across[place] = side
    upright = np.cross(tangents, across)
    angle = np.arange(sides) / sides * 2 * math.pi
    spokes = (
        np.cos(angle)[None, :, None] * across[:, None]
        + np.sin(angle)[None, :, None] * upright[:, None]
    )
    rings = points[:, None] + radii[:, None, None] * spokes
    first, last = (np.broadcast_to(points[end], (1, sides, 3)) for end in (0, -1))
    return closed(np.concatenate([first, rings, last]))


def pipe(corners: npt.ArrayLike, radius: float, steps: int, sides: int) -> Mesh:
    """Return a tube along a polygon with rounded corners.

    Parameters
    ----------
    corners : array, shape (n, 3)
    radius : float
    steps, sides : int
        Number of points along the pipe, at least 2, and divisions about it, at least 3.
    """
    return tube(smooth_curve(corners, steps), radius, sides)


def helix(radius: float, height: float, turns: float, steps: int) -> Floats:
    """Return points of a helix about the y axis from y = 0 upwards, shape (steps + 1, 3)."""
    along = np.linspace(0, 1, steps + 1)
    angle = 2 * math.pi * turns * along
    return np.stack([radius * np.cos(angle), height * along, radius * np.sin(angle)], axis=1)


def cylinder(start: Vector, end: Vector, radius: float, bevel: float, slices: int) -> Mesh:
    """Return a solid cylinder between two points of its axis, with rounded rims.

    Parameters
    ----------
    start, end : Vector
    radius, bevel : float
        `bevel` is the radius of the rims' rounding, at most half the length and below `radius`.
    slices : int
        Divisions about the axis, at least 3.
    """
    axis = np.subtract(end, start).astype(np.float64)
    length = float(np.linalg.norm(axis))
    profile = outline(
        [(0.0, 0.0, 0.0), (radius, 0.0, bevel), (radius, length, bevel), (0.0, length, 0.0)], 0.0
    )
    return transform(turned(profile, slices), translation(start) @ upright_to(as_vector(axis)))


def upright_to(direction: Vector) -> Floats:
    """Return the rotation, shape (4, 4), that turns the y axis into `direction`."""
    toward = unit(np.asarray(direction, dtype=np.float64))
    axis = np.cross([0.0, 1.0, 0.0], toward)
    if not axis.any():
        return np.eye(4) if toward[1] > 0 else rotation((1, 0, 0), math.pi)
    return rotation(as_vector(axis), math.acos(min(1.0, max(-1.0, float(toward[1])))))


def circle(radius: float, count: int, center: tuple[float, float] = (0.0, 0.0)) -> Floats:
    """Return `count` points of a circle, counterclockwise from +x, shape (count, 2)."""
    angle = np.arange(count) / count * 2 * math.pi
    return np.asarray(center) + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def gear(teeth: int, root: float, tip: float) -> Floats:
    """Return the outline of a gear with teeth between two radii, shape (4 teeth, 2)."""
    step = 2 * math.pi / teeth
    angle = (np.arange(teeth)[:, None] + np.array([-0.26, -0.12, 0.12, 0.26])).ravel() * step
    radius = np.tile([root, tip, tip, root], teeth)
    return np.asarray(radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1))


def around(circles: Sequence[tuple[float, float, float]], count: int) -> Floats:
    """Return the outline of a band that is pulled tight around circles, shape (count, 2).

    Parameters
    ----------
    circles : sequence of (float, float, float)
        (x, y) of each center, and its radius.
    count : int
        Number of points. Those of equal index face in the same direction, whatever the circles.
    """
    x, y, radius = np.asarray(circles, dtype=np.float64).T
    facing = circle(1.0, count)
    reach = facing[:, :1] * x + facing[:, 1:] * y + radius
    touched = reach.argmax(axis=1)
    centers = np.stack([x[touched], y[touched]], axis=1)
    return np.asarray(centers + radius[touched, None] * facing)


def plate(outer: npt.ArrayLike, inner: npt.ArrayLike, depth: float) -> Mesh:
    """Return a plate with a hole, parallel to the xy plane and centered on it.

    Parameters
    ----------
    outer, inner : array, shape (n, 2)
        Outlines of the plate and of its hole, counterclockwise. Points of equal index are joined
        and should be close to each other.
    depth : float
        Thickness along z.
    """
    rim, hole = (np.asarray(points, dtype=np.float64) for points in (outer, inner))
    half = depth / 2
    faces = []
    for z, near, far in ((half, rim, hole), (-half, hole, rim)):
        normals = np.broadcast_to([0.0, 0.0, math.copysign(1.0, z)], (2 * len(rim), 3))
        faces.append(_band(_lifted(near, z), _lifted(far, z), normals))
    for points, below, above in ((rim, -half, half), (hole, half, -half)):
        sides = _lifted(_edge_normals(points), 0.0) * math.copysign(1.0, above)
        faces.append(_band(_lifted(points, below), _lifted(points, above), sides))
    return merge(faces)


def _lifted(points: Floats, z: float) -> Floats:
    """Return points (x, y) in the plane z."""
    return np.concatenate([points, np.full((len(points), 1), z)], axis=1)


def _edge_normals(points: Floats) -> Floats:
    """Return the outward normals at the start and the end of each edge, shape (2n, 2).

    They are shared by the edges that meet in a point, unless there is a crease.
    """
    along = np.roll(points, -1, axis=0) - points
    normals = unit(np.stack([along[:, 1], -along[:, 0]], axis=1))
    before, after = np.roll(normals, 1, axis=0), np.roll(normals, -1, axis=0)
    smooth_start = (before * normals).sum(axis=1, keepdims=True) > CREASE
    smooth_end = (after * normals).sum(axis=1, keepdims=True) > CREASE
    starts = unit(np.where(smooth_start, before + normals, normals))
    ends = unit(np.where(smooth_end, after + normals, normals))
    return np.stack([starts, ends], axis=1).reshape(-1, 2)


def _band(first: Floats, second: Floats, normals: Floats) -> Mesh:
    """Return quadrilaterals between two loops of points; `normals` are those of each edge's ends.

    The band faces outwards if it runs along z upwards from the first loop to the second.
    """
    count = len(first)
    corners = np.stack([first, np.roll(first, -1, 0), np.roll(second, -1, 0), second], axis=1)
    shades = normals.reshape(count, 2, 3)[:, [0, 1, 1, 0]]
    starts = 4 * np.arange(count)[:, None]
    triangles = np.concatenate([starts + np.array(half) for half in HALVES])
    return Mesh.from_arrays(
        corners.reshape(-1, 3), triangles, normals=np.ascontiguousarray(shades.reshape(-1, 3))
    )
