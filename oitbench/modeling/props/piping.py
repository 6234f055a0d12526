"""Parts of a plant of process industry: routes of pipes, frames of steel, gratings and vessels.

Meters, y up.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from oitbench.modeling.detail import divisions
from oitbench.modeling.mesh import box, lathe
from oitbench.modeling.placement import merge, transform, translation
from oitbench.modeling.tubes import straight, tubes
from oitbench.scene import Floats, Mesh, Texture, Vector, unit

_ELBOW = 3
"""Points of an elbow."""
GRATING_SIDE, _BORDER = 256, 4
"""Texels along a side of a grating, and empty ones along each edge."""


def rounded(corners: Floats, radius: float) -> Floats:
    """Return routes of pipes with round elbows.

    Parameters
    ----------
    corners : array, shape (n, k, 3)
        Polygons, in which successive points differ.
    radius : float
        Distance from a corner at which an elbow begins, meters; at most 0.45 of an edge.

    Returns
    -------
    array, shape (n, 2 + 3 (k - 2), 3)
    """
    edges = np.diff(corners, axis=1)
    lengths = np.linalg.norm(edges, axis=2, keepdims=True)
    ways = edges / lengths
    reach = np.minimum(radius, 0.45 * np.minimum(lengths[:, :-1], lengths[:, 1:]))
    middle = corners[:, 1:-1]
    start, end = middle - reach * ways[:, :-1], middle + reach * ways[:, 1:]
    # The middle of a quarter circle is 0.29 of the way from the chord to the corner.
    inner = (start + end) / 2 + (2 - math.sqrt(2)) * (middle - (start + end) / 2)
    elbows = np.stack([start, inner, end], axis=2).reshape(len(corners), -1, 3)
    return np.concatenate([corners[:, :1], elbows, corners[:, -1:]], axis=1)


def beams(starts: Floats, ends: Floats, width: float) -> Mesh:
    """Return square beams between points, shape (n, 3), `width` meters wide."""
    middles, spans = (starts + ends) / 2, np.abs(ends - starts)
    parts = [
        box(tuple(middle), tuple(np.maximum(span, width)))
        for middle, span in zip(middles.tolist(), spans, strict=True)
    ]
    return merge(parts)


def grating() -> Texture:
    """Return the coverage of a walkway's grating: bars with gaps, inside an empty border."""
    line = np.arange(GRATING_SIDE)
    bars = (line % 8 < 3)[None, :] | (line % 32 < 3)[:, None]
    inner = np.zeros((GRATING_SIDE, GRATING_SIDE), dtype=bool)
    inner[_BORDER:-_BORDER, _BORDER:-_BORDER] = True
    frame = inner.copy()
    rim = _BORDER + 4
    frame[rim:-rim, rim:-rim] = False
    return Texture(((bars & inner) | frame).astype(np.float32))


def railing(
    corners: Sequence[Vector], sides: int, height: float = 1.1, pitch: float = 1.25
) -> Mesh:
    """Return the posts and the two rails of a railing above a polygon, meters."""
    points = np.asarray(corners, dtype=np.float64)
    feet: list[Floats] = []
    for start, end in itertools.pairwise(points):
        count = max(1, round(float(np.linalg.norm(end - start)) / pitch))
        feet.append(start + (end - start) * (np.arange(count)[:, None] / count))
    if (points[0] != points[-1]).any():
        feet.append(points[-1:])
    posts = np.concatenate(feet)
    up = np.array([0.0, height, 0.0])
    rails = [straight(points[:-1] + part * up, points[1:] + part * up) for part in (0.52, 1.0)]
    return merge(
        [
            tubes(straight(posts, posts + up), 0.022, sides),
            tubes(np.concatenate(rails), 0.025, sides),
        ]
    )


def vessel(foot: Vector, radius: float, height: float, detail: float, dome: float = 0.35) -> Mesh:
    """Return an upright vessel with domed ends; `dome` is the height of a dome in radii."""
    turn = np.linspace(0, math.pi / 2, divisions(7, detail, 3))
    curve = np.stack([radius * np.sin(turn), dome * radius * (1 - np.cos(turn))], axis=1)
    curve[0, 0] = 0.0
    top = np.stack([curve[::-1, 0], height - curve[::-1, 1]], axis=1)
    rings = np.linspace(curve[-1, 1], top[0, 1], divisions(6, detail, 2))[1:-1]
    wall = np.stack([np.full(len(rings), radius), rings], axis=1)
    profile = np.concatenate([curve, wall, top])
    return transform(lathe(profile, divisions(40, detail, 10)), translation(foot))


def drum(center: Vector, radius: float, length: float, detail: float, along: Vector) -> Mesh:
    """Return a lying vessel whose axis is `along`, x or z."""
    upright = vessel((0, -length / 2, 0), radius, length, detail)
    axis = unit(np.asarray(along, dtype=np.float64))
    side = np.cross(axis, [0.0, 1.0, 0.0])
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([side, axis, np.cross(side, axis)], axis=1)
    matrix[:3, 3] = center
    return transform(upright, matrix)


def flanges(places: Floats, ways: Floats, radii: Floats, sides: int) -> Mesh:
    """Return rings around pipes at places, shape (n, 3), across the directions `ways`."""
    half = 0.05
    at = np.array([-half, -half, half, half])[None, :, None] + [[[0.0], [1e-4], [-1e-4], [0.0]]]
    curves = places[:, None] + at * ways[:, None]
    return tubes(curves, radii[:, None] * np.array([1.0, 1.45, 1.45, 1.0]), sides)
