"""Wavy hair with a side parting, as curves from the scalp of `bust` to its shoulders."""

from __future__ import annotations

import math

import numpy as np

from oitbench.modeling.implicit import ellipsoid
from oitbench.modeling.placement import random_directions
from oitbench.modeling.props import bust
from oitbench.modeling.voxels import Voxels, sampled
from oitbench.scene import Floats, unit

# Height of the hairline in meters by the angle from straight ahead, radians.
ANGLES = (0.0, 0.5, 0.85, 1.15, 1.5, 1.75, 2.1, math.pi)
HAIRLINE = (0.080, 0.076, 0.060, 0.022, 0.004, -0.030, -0.050, -0.058)
PARTING = 0.024
"""Distance of the parting from the middle of the head, meters."""
GATHERED = (-0.082, 0.0, 0.030)
"""Place before one shoulder, meters, where all hair but that of the other side is gathered."""
LOCKS = 260
"""Number of locks, each of which follows one guide."""
_LOW, _HIGH, _CELL = (-0.27, -0.37, -0.20), (0.27, 0.17, 0.19), 0.012
_STEPS, _STEP = 64, 0.0075
"""Steps of a guide, and their length in meters."""


def grow(random: np.random.Generator, count: int, points: int) -> Floats:
    """Return the curves of `count` strands in random order, shape (count, points, 3)."""
    body = sampled(_obstacle, _LOW, _HIGH, _CELL)
    starts = _roots(random, LOCKS)
    guides = _fall(random, starts, body, points)
    roots = _roots(random, count)
    return _strands(random, roots, starts, guides, body)


def _obstacle(points: Floats) -> Floats:
    """Return the distance to the bust, and to the space before the face, which stays free."""
    face = ellipsoid(points, (-0.004, -0.03, 0.085), (0.053, 0.098, 0.075))
    return np.minimum(bust.distance(points), face)


def _roots(random: np.random.Generator, count: int) -> Floats:
    """Return random places on the scalp, shape (count, 3)."""
    center, radii = (np.asarray(part) for part in bust.CRANIUM)
    found: list[Floats] = []
    while sum(map(len, found)) < count:
        places = center + radii * random_directions(random, 4 * count)
        turn = np.arctan2(np.abs(places[:, 0]), places[:, 2] + 0.02)
        ragged = 0.004 * random.normal(size=len(places))
        found.append(places[places[:, 1] > np.interp(turn, ANGLES, HAIRLINE) + ragged])
    return np.concatenate(found)[:count]


def _fall(random: np.random.Generator, starts: Floats, body: Voxels, points: int) -> Floats:
    """Return the guides: combed away from the parting, then falling over head and shoulders."""
    center, radii = (np.asarray(part) for part in bust.CRANIUM)
    normals = unit((starts - center) / radii**2)
    side = np.where(starts[:, 0] > PARTING, 1.0, -1.0)
    front = np.clip((starts[:, 2] + 0.03) / 0.09, 0, 1)
    # Hair of the crown lies over that of the sides.
    high = np.clip((starts[:, 1] + 0.06) / 0.17, 0, 1)
    lift = 0.003 + 0.015 * high**1.5 + 0.004 * random.random(len(starts))
    comb = np.stack([side, -0.2 + 0 * side, -0.25 - 0.75 * front], axis=1)
    back = starts[:, 2] < -0.05
    comb[back] = (-0.8, -0.6, -0.4)
    swept = (starts[:, 0] < PARTING) | (starts[:, 2] < -0.02)
    comb -= (comb * normals).sum(axis=1, keepdims=True) * normals
    heading = unit(unit(comb) + (0.55 + 0.35 * high)[:, None] * normals)
    heading = unit(heading + 0.10 * random.normal(size=heading.shape))
    place = starts.copy()
    path = [place]
    for index in range(_STEPS - 1):
        pull = min(0.10 + 0.012 * index, 0.30)
        gather = swept * 0.05 * np.clip((-0.02 - place[:, 1]) / 0.08, 0, 1)
        aside = (np.asarray(GATHERED) - place) * [1, 0, 1] / 0.06
        heading = unit(heading + [0.0, -pull, 0.0] + gather[:, None] * aside)
        moved = place + _STEP * heading
        room = lift * min(1.0, (index + 1) / 6)
        moved = _pushed_out(moved, body, room)
        heading = unit(0.35 * heading + 0.65 * unit(moved - place))
        place = place + _STEP * unit(moved - place)
        path.append(place)
    long = np.stack(path, axis=1)
    length = 0.190 + 0.145 * high + 0.02 * random.normal(size=len(starts))
    return _resampled(long, np.clip(length / _STEP, 8, _STEPS - 1), points)


def _resampled(curves: Floats, ends: Floats, points: int) -> Floats:
    """Return curves from their starts to the places `ends`, counted in points, shape (n,)."""
    at = np.linspace(0, 1, points)[None] * ends[:, None]
    low = np.minimum(at.astype(int), curves.shape[1] - 2)
    rows = np.arange(len(curves))[:, None]
    part = (at - low)[..., None]
    return np.asarray(curves[rows, low] * (1 - part) + curves[rows, low + 1] * part)


def _strands(
    random: np.random.Generator, roots: Floats, starts: Floats, guides: Floats, body: Voxels
) -> Floats:
    """Return strands that follow the guides of their neighborhood, gathered in wavy locks."""
    from scipy import spatial

    count, points = len(roots), guides.shape[1]
    parted = np.array([0.35, 0.0, 0.0])
    sides = np.sign(starts[:, :1] - PARTING), np.sign(roots[:, :1] - PARTING)
    # The two sides of the parting are moved apart, so that no strand mixes them.
    tree = spatial.cKDTree(starts + parted * sides[0])
    gaps, near = tree.query(roots + parted * sides[1], k=3)
    weights = 1 / (gaps + 1e-3) ** 2
    weights /= weights.sum(axis=1, keepdims=True)
    shift = guides - starts[:, None]
    flow = (weights[..., None, None] * shift[near]).sum(axis=1) + roots[:, None]
    t = np.linspace(0, 1, points)[None, :, None]
    lock = guides[near[:, 0]]
    disc = random.normal(size=(count, 1, 3)) * (0.0054 - 0.0034 * t)
    gathered = 0.80 * np.clip(1.6 * t - 0.10, 0, 1) ** 1.1
    curves = flow * (1 - gathered) + (lock + disc) * gathered
    # Waves, in step within a lock.
    along = unit(np.gradient(lock, axis=1))
    right = unit(np.cross(along, [0.31, 0.2, 0.93]))
    upper = np.cross(right, along)
    phase = (random.random(len(guides)) * 6.3)[near[:, 0], None, None]
    phase = phase + 0.35 * random.normal(size=(count, 1, 1))
    pace = (random.uniform(0.85, 1.2, len(guides)))[near[:, 0], None, None]
    arc = np.linalg.norm(np.diff(lock, axis=1), axis=2).cumsum(axis=1)
    arc = np.concatenate([np.zeros((count, 1)), arc], axis=1)[..., None]
    angle = phase + pace * arc * (2 * math.pi / 0.062)
    swing = 0.0075 * np.clip(1.9 * t - 0.35, 0, 1) * random.uniform(0.8, 1.2, (count, 1, 1))
    curves = curves + swing * (np.cos(angle) * right + np.sin(angle) * upper)
    # A few strands stray.
    stray = np.where(random.random((count, 1, 1)) < 0.06, 0.020, 0.0022)
    wander = np.cumsum(random.normal(size=(count, points, 3)), axis=1) / points**0.5
    curves = curves + stray * wander * t
    curves = _pushed_out(curves, body, 0.0015)
    curves[:, 0] = roots
    return curves


def _pushed_out(points: Floats, body: Voxels, room: Floats | float) -> Floats:
    """Return points, shape (..., 3), moved to a distance of at least about `room` from a body."""
    points = points.copy()
    for _ in range(2):
        lacking = room - body.at(points)
        inside = lacking > 0
        points[inside] += lacking[inside][:, None] * body.gradient(points[inside])
    return points
