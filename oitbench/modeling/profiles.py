"""Profiles: polygons with smooth or rounded corners, from which meshes are turned.

A profile is an array of points (radius, height) in meters, shape (n, 2).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from oitbench.modeling.detail import divisions
from oitbench.scene import Floats

Corner = tuple[float, float, float]
"""Corner of an outline: (radius, height, radius of the fillet), meters."""
STEPS_PER_TURN = 20
"""Chords at detail 1 of a fillet that turns through a full circle."""


def smooth_curve(corners: npt.ArrayLike, count: int) -> Floats:
    """Return `count` points, evenly spaced, on the polygon `corners` with its corners rounded off.

    Parameters
    ----------
    corners : array, shape (n, d)
        Open polygon. The curve starts and ends at its ends and stays inside its convex hull.
    count : int
        Number of points returned, at least 2.

    Returns
    -------
    array, shape (count, d), float64

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


def outline(corners: Sequence[Corner], detail: float) -> Floats:
    """Return the polygon `corners` with each corner rounded by an arc of its own radius.

    Parameters
    ----------
    corners : sequence of Corner
        (radius, height, fillet) in meters. The two ends, and corners with fillet 0, stay sharp.
    detail : float
        Factor on the number of triangles of a mesh that is turned from the outline.

    Returns
    -------
    array, shape (n, 2), float64
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


def outward(profile: Floats) -> Floats:
    """Return normals of a profile, not of unit length, on the outer side of one that runs up."""
    tangent = np.gradient(profile, axis=0)
    return np.stack([tangent[:, 1], -tangent[:, 0]], axis=1)


def inset(profile: Floats, distance: float) -> Floats:
    """Return a profile that runs upwards from the axis, moved inwards by `distance` meters.

    Its first point stays on the axis.
    """
    normals = outward(profile)
    inner = profile - distance * normals / np.linalg.norm(normals, axis=1, keepdims=True)
    inner[0, 0] = 0.0
    return np.asarray(inner)
