"""Parts of buildings and streets: columns, arched walls and street lamps.

Meters, y up. Free-standing parts stand on y = 0 at the origin. Walls are parallel to the xy plane
and centered on it.
"""

from __future__ import annotations

import math

import numpy as np

from oitbench.modeling.detail import divisions
from oitbench.modeling.mesh import box, lathe, slab, sphere
from oitbench.modeling.placement import merge, repeated, transform, translation
from oitbench.modeling.profiles import smooth_curve
from oitbench.scene import Floats, Mesh, Vector

HALVES = ((0, 1, 2), (0, 2, 3))
"""The two triangles of a quadrilateral."""


def column(height: float, radius: float, detail: float) -> Mesh:
    """Return a round column on a square base under a square capital.

    Parameters
    ----------
    height : float
        From the floor to the top of the capital, meters.
    radius : float
        Radius of the shaft at its foot, meters. The base is three times as wide.
    detail : float
        Factor on the number of triangles.
    """
    plinth, edge = 0.5 * radius, 3 * radius
    foot, head = plinth, height - plinth
    corners = [
        (1.40, foot), (1.45, foot + 0.25 * radius), (1.30, foot + 0.50 * radius),
        (1.00, foot + 0.60 * radius), (1.00, foot + 1.0 * radius),
        (0.98, 0.5 * height), (0.84, head - 1.5 * radius), (0.84, head - 0.9 * radius),
        (1.00, head - 0.8 * radius), (0.90, head - 0.7 * radius), (1.40, head),
    ]  # fmt: skip
    profile = np.asarray(corners) * [radius, 1]
    shaft = lathe(smooth_curve(profile, divisions(24, detail, 6)), divisions(20, detail, 6))
    ends = [
        box((0, middle, 0), (edge, plinth, edge)) for middle in (plinth / 2, height - plinth / 2)
    ]
    return merge([shaft, *ends])


def arch(width: float, opening: float, height: float, depth: float, segments: int) -> Mesh:
    """Return a bay of a wall above a round arch that springs from y = 0, open below.

    Parameters
    ----------
    width, height, depth : float
        Size of the bay, meters.
    opening : float
        Diameter of the arch in meters, below `width` and twice `height`.
    segments : int
        Divisions of the arch.
    """
    inner, outer = _arc(width / 2, opening / 2, height, segments)
    ends = np.array([[width / 2, 0.0]]), np.array([[-width / 2, 0.0]])
    # The lower face continues along the springing line to the neighboring bays.
    return _pierced(
        np.concatenate([ends[0], inner, ends[1]]), np.concatenate([ends[0], outer, ends[1]]), depth
    )


def window_wall(
    width: float,
    height: float,
    depth: float,
    opening: float,
    sill: float,
    spring: float,
    segments: int,
) -> Mesh:
    """Return a bay of a wall that stands on y = 0 and has one round-headed window.

    Parameters
    ----------
    width, height, depth : float
        Size of the bay, meters.
    opening : float
        Width of the window, meters.
    sill, spring : float
        Heights of the lower edge of the window and of the start of its round head, meters.
    segments : int
        Divisions of the head.
    """
    half, side = opening / 2, width / 2
    inner, outer = _arc(side, half, height - spring, segments)
    rise = np.array([0.0, spring])
    right, left = np.array([[half, sill]]), np.array([[-half, sill]])
    corner, other = np.array([[side, 0.0]]), np.array([[-side, 0.0]])
    return _pierced(
        np.concatenate([right, inner + rise, left, right]),
        np.concatenate([corner, outer + rise, other, corner]),
        depth,
    )


def arcade(
    bays: int, bay: float, pillar: float, rise: float, top: float, detail: float
) -> tuple[Mesh, Mesh]:
    """Return an arcade along x, centered on the origin: its wall, and its columns and cornice.

    Parameters
    ----------
    bays : int
        Number of arches; there is a column at both ends, too.
    bay : float
        Width of a bay, meters.
    pillar, rise, top : float
        Height of the columns, height of the bays of the arches on them, and that of the whole wall,
        meters.
    detail : float
        Factor on the number of triangles.
    """
    middles = [bay * (place - (bays - 1) / 2) for place in range(bays)]
    opening = arch(bay, 0.79 * bay, rise, 0.42, divisions(16, detail, 6))
    wall = repeated(opening, [(x, pillar, 0.0) for x in middles])
    half = bays * bay / 2
    upper = slab((-half, pillar + rise, -0.21), (half, top, 0.21))
    cornice = slab((-half, top - 0.01, -0.3), (half, top + 0.13, 0.3))
    feet = [(bay * (place - bays / 2), 0.0, 0.0) for place in range(bays + 1)]
    columns = repeated(column(pillar - 0.001, 0.15, 0.5 * detail), feet)
    return merge([wall, upper]), merge([columns, cornice])


def _arc(side: float, radius: float, height: float, segments: int) -> tuple[Floats, Floats]:
    """Return points of a half circle, from right to left, and their projections on the bay's edge.

    The projection is from the center of the circle.
    """
    corner = math.atan2(height, side)
    angles = np.linspace(0, math.pi, segments + 1)
    # Two of the rays must go to the corners of the edge, or they would be cut off.
    angles = np.unique(np.concatenate([angles, [corner, math.pi - corner]]))
    rays = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    rays[[0, -1], 1] = 0.0
    reach = 1 / np.maximum(np.abs(rays[:, 0]) / side, rays[:, 1] / height)
    return radius * rays, reach[:, None] * rays


def _pierced(inner: Floats, outer: Floats, depth: float) -> Mesh:
    """Return a pierced wall: both faces between two polygons, and the reveal along `inner`.

    The polygons have equally many points.
    """
    across = np.stack([inner, outer], axis=1)
    faces = [_facets(_at(across, depth / 2)), _facets(_at(across[:, ::-1], -depth / 2))]
    reveal = np.stack([_at(inner, -depth / 2), _at(inner, depth / 2)], axis=1)
    return merge([*faces, _facets(reveal)])


def _at(points: Floats, z: float) -> Floats:
    """Return points (x, y) in the plane z."""
    return np.concatenate([points, np.full((*points.shape[:-1], 1), z)], axis=-1)


def _facets(rungs: Floats) -> Mesh:
    """Return flat quadrilaterals between successive rungs, shape (n, 2, 3), except empty ones."""
    corners = np.concatenate([rungs[:-1], rungs[1:, ::-1]], axis=1)
    diagonals = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    normals = np.cross(*diagonals)
    area = np.linalg.norm(normals, axis=1)
    corners, normals = corners[area > 0], (normals / np.maximum(area, 1e-12)[:, None])[area > 0]
    starts = 4 * np.arange(len(corners))[:, None]
    triangles = np.concatenate([starts + np.array(half) for half in HALVES])
    positions = corners.reshape(-1, 3)
    # Roundings in double precision would hide an empty triangle.
    first, second, third = positions.astype(np.float32)[triangles].swapaxes(0, 1)
    whole = np.cross(second - first, third - first).any(axis=1)
    return Mesh.from_arrays(
        positions,
        triangles[whole],
        uvs=np.tile([[0, 0], [1, 0], [1, 1], [0, 1]], (len(corners), 1)),
        normals=np.repeat(normals, 4, axis=0),
    )


def lamp_post(height: float, arm: float, detail: float) -> Mesh:
    """Return a street lamp without its bulb: a post, an arm along +x and a shade at its end.

    Parameters
    ----------
    height : float
        Height of the rim of the shade, which opens downwards, meters.
    arm : float
        Distance from the post to the middle of the shade, meters.
    detail : float
        Factor on the number of triangles.
    """
    slices = divisions(16, detail, 6)
    corners = [(0.0, 0.0), (0.16, 0.0), (0.16, 0.25), (0.07, 0.40), (0.05, 1.2)]
    corners += [(0.04, height + 0.30), (0.0, height + 0.32)]
    post = lathe(smooth_curve(corners, divisions(24, detail, 10)), slices)
    beam = box((arm / 2, height + 0.24, 0), (arm, 0.04, 0.04))
    shade = smooth_curve(
        [(0.24, 0.0), (0.20, 0.08), (0.10, 0.16), (0.06, 0.2), (0.0, 0.215)],
        divisions(12, detail, 5),
    )
    hood = transform(lathe(shade, slices), translation((arm, height, 0)))
    return merge([post, beam, hood])


def globe(center: Vector, radius: float, detail: float) -> Mesh:
    """Return a round bulb; `center` and `radius` are in meters."""
    return sphere(center, radius, divisions(20, detail, 8), divisions(12, detail, 6))
