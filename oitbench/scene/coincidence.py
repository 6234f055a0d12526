"""Surfaces that lie in one plane and overlap, of which at least one is transparent.

No depth test can order them: each rounds to a depth of its own. Renderers therefore take their
depth from the equation of the common plane, and order them by a rule (CONVENTIONS.md, "Coincident
surfaces"). Planes are compared in double precision, where only roundings separate equal planes, or
they are declared by `Object.decal_of`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from oitbench.scene.camera import Camera
from oitbench.scene.objects import Object
from oitbench.scene.vectors import Floats

_ROUNDING = 1e-9
"""Relative difference of two planes that roundings in double precision can cause."""
_MOST_PAIRS = 1 << 22
"""Pairs of triangles that are compared at once."""
_MIXING = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.uint64)
Numbers = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Coincidence:
    """The planes in which surfaces of a scene coincide.

    Parameters
    ----------
    planes : dict of str to array, shape (m, 3), float64
        By the name of an object, the dual point q of each triangle's plane, which contains the
        points x with q·x = 1, relative to `origin_of_planes`; 0 for a triangle that coincides with
        nothing.
    pair : (str, str)
        Two of the objects that coincide.
    """

    planes: dict[str, Floats]
    pair: tuple[str, str]


def origin_of_planes(camera: Camera) -> Floats:
    """Return a point that is in no plane which `camera` sees other than edge on, shape (3,).

    Behind an orthographic camera, by a distance at which there is a plane by a rare chance only.
    """
    eye = np.asarray(camera.position, dtype=np.float64)
    if not camera.orthographic:
        return eye
    return np.asarray(eye + 0.7321 * math.dist(camera.position, camera.target) * camera.axes[2])


def find_coincidence(
    objects: Sequence[Object], origin: npt.ArrayLike = (0.0, 0.0, 0.0)
) -> Coincidence | None:
    """Return where `objects` coincide; None for nowhere.

    Parameters
    ----------
    objects : sequence of Object
    origin : array, shape (3,)
        Planes through it are left out; see `origin_of_planes`.
    """
    corners = [item.mesh.positions[item.mesh.triangles] - np.asarray(origin) for item in objects]
    starts = np.cumsum([0, *map(len, corners)])
    triangles = np.concatenate(corners) if corners else np.zeros((0, 3, 3))
    owners = np.repeat(np.arange(len(objects)), np.diff(starts))
    clear = np.array([not item.opaque for item in objects], dtype=bool)
    duals = _dual_points(triangles)
    kept = np.zeros(len(triangles), dtype=bool)
    pair = _declared(objects, duals, triangles, owners, kept)
    for group in _groups(duals, owners, clear):
        found = _overlapping(triangles[group], owners[group], clear)
        if found is not None:
            pair = pair or (objects[found[0]].name, objects[found[1]].name)
            duals[group] = duals[group[0]]
            kept[group] = True
    if pair is None:
        return None
    duals[~kept] = 0
    parts = np.split(duals, starts[1:-1])
    return Coincidence(
        {item.name: part for item, part in zip(objects, parts, strict=True) if part.any()}, pair
    )


def coplanar_pairs(triangles: Floats, owners: Numbers) -> tuple[Numbers, Numbers]:
    """Return the pairs of triangles of different owners that lie in one plane and overlap.

    Parameters
    ----------
    triangles : array, shape (n, 3, 3)
    owners : array, shape (n,)
        Numbers from 0.

    Returns
    -------
    one, other : array, shape (m,)
        Numbers of triangles.
    """
    # No plane of the triangles contains the origin, unless by a rare chance.
    low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    seen = triangles - low + (high - low).max() * np.array([0.4142, 0.7321, 0.2361])
    clear = np.ones(int(owners.max()) + 1, dtype=bool)
    found = [np.zeros((2, 0), dtype=np.int64)]
    for group in _groups(_dual_points(seen), owners, clear):
        pairs = _overlaps(seen[group], owners[group], clear)
        found += [group[np.stack(numbers)] for numbers in pairs]
    one, other = np.concatenate(found, axis=1)
    return one, other


def _dual_points(triangles: Floats) -> Floats:
    """Return the dual point of each triangle's plane; 0 for an empty one, or one through 0."""
    first, second, third = triangles.swapaxes(0, 1)
    normals = np.cross(second - first, third - first)
    offsets = np.einsum("ij,ij->i", normals, first)
    reach = np.abs(triangles).max(axis=(1, 2), initial=0.0)
    seen = np.abs(offsets) > _ROUNDING * reach * np.linalg.norm(normals, axis=1)
    duals = np.zeros_like(normals)
    duals[seen] = normals[seen] / offsets[seen, None]
    return duals


def _groups(duals: Floats, owners: Numbers, clear: npt.NDArray[np.bool_]) -> list[Numbers]:
    """Return the triangles of each plane that holds several objects, one of them transparent."""
    lengths = np.linalg.norm(duals, axis=1)
    usable = np.flatnonzero(lengths > 0)
    directions = duals[usable] / lengths[usable, None]
    numbers = np.column_stack([directions, np.log(lengths[usable])]) / (10 * _ROUNDING)
    rounded = np.rint(numbers).astype(np.int64).view(np.uint64)
    keys = rounded[:, 3].copy()
    for axis in range(3):
        keys = (keys ^ rounded[:, axis]) * _MIXING[axis]
    order = np.argsort(keys, kind="stable")
    keys, usable = keys[order], usable[order]
    edges = np.flatnonzero(np.diff(keys)) + 1
    begins = np.concatenate([[0], edges]).astype(np.int64)
    if not len(usable):
        return []
    least = np.minimum.reduceat(owners[usable], begins)
    most = np.maximum.reduceat(owners[usable], begins)
    see_through = np.maximum.reduceat(clear[owners[usable]].astype(np.int8), begins)
    ends = np.append(begins[1:], len(usable))
    chosen = np.flatnonzero((least != most) & (see_through > 0))
    return [usable[begins[k] : ends[k]] for k in chosen]


def _overlapping(
    triangles: Floats, owners: Numbers, clear: npt.NDArray[np.bool_]
) -> tuple[int, int] | None:
    """Return two objects, one of them transparent, of which triangles of one plane overlap."""
    found = next(_overlaps(triangles, owners, clear), None)
    return None if found is None else (int(owners[found[0][0]]), int(owners[found[1][0]]))


def _overlaps(
    triangles: Floats, owners: Numbers, clear: npt.NDArray[np.bool_]
) -> Iterator[tuple[Numbers, Numbers]]:
    """Yield pairs of triangles of one plane that overlap, of which one is transparent."""
    first, second, third = triangles[0]
    normal = np.cross(second - first, third - first)
    dropped = int(np.abs(normal).argmax())
    flat = np.delete(triangles, dropped, axis=2)
    low, high = flat.min(axis=1), flat.max(axis=1)
    slack = _ROUNDING * np.abs(flat).max()
    order = np.argsort(low[:, 0], kind="stable")
    flat, low, high, owners = flat[order], low[order], high[order], owners[order]
    last = np.searchsorted(low[:, 0], high[:, 0] - slack)
    for begin in range(0, len(flat), max(1, _MOST_PAIRS // len(flat))):
        rows = np.arange(begin, min(begin + max(1, _MOST_PAIRS // len(flat)), len(flat)))
        columns = np.arange(len(flat))
        near = (columns > rows[:, None]) & (columns < last[rows, None])
        near &= owners[rows, None] != owners
        near &= clear[owners[rows, None]] | clear[owners]
        near &= low[rows, None, 1] < high[:, 1] - slack
        near &= low[:, 1] < high[rows, None, 1] - slack
        one, other = np.nonzero(near)
        one = rows[one]
        cut = ~(_apart(flat[one], flat[other], slack) | _apart(flat[other], flat[one], slack))
        if cut.any():
            yield order[one[cut]], order[other[cut]]


def _apart(ones: Floats, others: Floats, slack: float) -> npt.NDArray[np.bool_]:
    """Return whether an edge of each triangle separates it from the other one."""
    edges = np.roll(ones, -1, axis=1) - ones
    across = np.stack([-edges[..., 1], edges[..., 0]], axis=-1)
    across /= np.maximum(np.linalg.norm(across, axis=-1, keepdims=True), 1e-300)
    mine = np.einsum("nec,nkc->nek", across, ones)
    theirs = np.einsum("nec,nkc->nek", across, others)
    gap = np.maximum(theirs.min(axis=2) - mine.max(axis=2), mine.min(axis=2) - theirs.max(axis=2))
    return np.asarray((gap > -slack).any(axis=1))


def _declared(
    objects: Sequence[Object],
    duals: Floats,
    triangles: Floats,
    owners: Numbers,
    kept: npt.NDArray[np.bool_],
) -> tuple[str, str] | None:
    """Give the triangles of declared decals the nearest plane of the object beneath."""
    pair = None
    names = {item.name: number for number, item in enumerate(objects)}
    for number, item in enumerate(objects):
        if not item.decal_of:
            continue
        pair = pair or (item.name, item.decal_of)
        beneath = np.flatnonzero(owners == names[item.decal_of])
        beneath = beneath[duals[beneath].any(axis=1)]
        for index in np.flatnonzero(owners == number) if len(beneath) else ():
            away = np.abs(triangles[index] @ duals[beneath].T - 1).max(axis=0)
            chosen = beneath[int(away.argmin())]
            duals[index], kept[index], kept[chosen] = duals[chosen], True, True
            same = np.abs(duals[beneath] - duals[chosen]).max(axis=1)
            kept[beneath[same <= _ROUNDING * np.abs(duals[chosen]).max()]] = True
    return pair
