"""Polygons of files as triangles: fans, or cut ear by ear where they are concave."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from oitbench.errors import SceneError
from oitbench.importing.limits import Budget
from oitbench.importing.notes import Notes
from oitbench.importing.shapes import Indices, check, sound
from oitbench.scene import Floats

MOST_CORNERS = 1000


def cut(
    positions: Floats, polygons: Indices, budget: Budget, notes: Notes
) -> tuple[Indices, Indices]:
    """Return where the triangles of polygons with equally many corners have theirs.

    They are the rows, shape (k, 1), and the columns, shape (k, 3), of `polygons`, so that
    `polygons[cut(…)]` are the triangles. Those without area are left out.
    """
    corners = polygons.shape[1]
    if corners < 3:
        return np.zeros((0, 1), dtype=np.int64), np.zeros((0, 3), dtype=np.int64)
    budget.take("triangles", len(polygons) * (corners - 2))
    check(polygons, len(positions))
    columns = split(positions, polygons, budget, notes).reshape(-1, 3)
    rows = np.repeat(np.arange(len(polygons)), corners - 2)[:, None]
    kept = sound(positions, polygons[rows, columns])
    if not kept.all():
        notes.add("triangles without area are left out")
    return rows[kept], columns[kept]


def split(positions: Floats, polygons: Indices, budget: Budget, notes: Notes) -> Indices:
    """Return the corners of the triangles of each polygon, shape (m, corners − 2, 3)."""
    count = polygons.shape[1]
    if count > MOST_CORNERS:
        raise SceneError(f"a polygon has {count} corners; split those above {MOST_CORNERS}")
    first = np.arange(1, count - 1)
    fan = np.stack([np.zeros_like(first), first, first + 1], axis=1)
    found = np.broadcast_to(fan, (len(polygons), *fan.shape))
    if count == 3:
        return found
    concave = np.flatnonzero(_concave(positions, polygons, fan))
    if not len(concave):
        return found
    # Each ear is searched among all corners.
    steps = len(concave) * count**2
    if steps > budget.left("steps of cutting"):
        notes.add("many concave polygons are split as if they were convex; [limit=2] cuts more")
        return found
    budget.take("steps of cutting", steps)
    found = found.copy()
    for row in concave:
        found[row] = _ears(positions[polygons[row]])
    return found


def _concave(positions: Floats, polygons: Indices, fan: Indices) -> npt.NDArray[np.bool_]:
    """Return which polygons have a triangle in their fan that faces another way."""
    start = positions[polygons[:, 0]]
    normals = [
        np.cross(positions[polygons[:, b]] - start, positions[polygons[:, c]] - start)
        for _, b, c in fan
    ]
    total = np.sum(normals, axis=0)
    return np.asarray(np.any([(one * total).sum(axis=1) < 0 for one in normals], axis=0))


def _ears(places: Floats) -> Indices:
    """Cut a polygon, shape (n, 3), into n − 2 triangles of its corners (Meisters 1975)."""
    nexts = np.roll(places, -1, axis=0)
    normal = np.cross(places - places[0], nexts - places[0]).sum(axis=0)
    axis = int(np.argmax(np.abs(normal)))
    flat = np.delete(places, axis, axis=1) * [1, np.sign(normal[axis]) * (-1) ** axis or 1]
    left = list(range(len(flat)))
    cut = []
    while len(left) > 3:
        ear = next((k for k in range(len(left)) if _is_ear(flat, left, k)), 0)
        cut.append((left[ear - 1], left[ear], left[(ear + 1) % len(left)]))
        del left[ear]
    return np.array([*cut, left])


def _is_ear(flat: Floats, left: list[int], k: int) -> bool:
    a, b, c = left[k - 1], left[k], left[(k + 1) % len(left)]
    if _turn(flat[a], flat[b], flat[c]) <= 0:
        return False
    others = flat[[one for one in left if one not in (a, b, c)]]
    inside = np.ones(len(others), dtype=bool)
    for start, end in ((a, b), (b, c), (c, a)):
        inside &= _turn(flat[start], flat[end], others) >= 0
    return not inside.any()


def _turn(a: Floats, b: Floats, c: Floats) -> Floats:
    """Return twice the signed area of triangles; `c` may be several points."""
    return np.asarray((b[0] - a[0]) * (c[..., 1] - a[1]) - (b[1] - a[1]) * (c[..., 0] - a[0]))
