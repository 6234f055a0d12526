"""Parts of a piston engine, in millimeters.

The crankshaft runs along the z axis, and cylinders stand along y. Plates are parallel to the xy
plane and centered on it. Turned parts stand about the y axis.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from oitbench.modeling.detail import divisions
from oitbench.modeling.mesh import box
from oitbench.modeling.placement import merge, rotation, transform, translation
from oitbench.modeling.profiles import Corner, outline
from oitbench.modeling.solids import turned
from oitbench.modeling.sweeps import around, circle, cylinder, gear, helix, plate, tube
from oitbench.scene import Floats, Mesh, Vector, unit

AROUND = 40
"""Divisions of a round part about its axis at detail 1."""


def sides(detail: float, part: float = 1.0) -> int:
    """Return the divisions of a round part; `part` is a factor for large and small ones."""
    return divisions(AROUND * part, detail, 6)


def piston(radius: float, detail: float) -> Mesh:
    """Return a piston whose pin is at the origin: a crown with ring grooves, and a hollow skirt."""
    wall = radius - 5
    corners: list[Corner] = [(0, 20, 0), (wall, 20, 3), (wall, -26, 0), (radius, -26, 1)]
    for groove in (12.0, 19.0, 26.0):
        corners += [(radius, groove, 0), (radius - 3, groove + 0.01, 0)]
        corners += [(radius - 3, groove + 2.5, 0), (radius, groove + 2.51, 0)]
    corners += [(radius, 34, 1.5), (0.6 * radius, 34, 4), (0.5 * radius, 31, 4), (0, 31, 0)]
    return turned(outline(corners, detail), sides(detail))


def liner(inner: float, outer: float, low: float, high: float, detail: float) -> Mesh:
    """Return the open sleeve of a cylinder, between two heights."""
    count = sides(detail)
    ring = plate(circle(outer, count), circle(inner, count), high - low)
    return transform(
        ring, translation((0, (low + high) / 2, 0)) @ rotation((1, 0, 0), -math.pi / 2)
    )


def connecting_rod(length: float, pin: float, detail: float) -> Mesh:
    """Return a rod with its big end at the origin and its small end at y = `length`.

    Parameters
    ----------
    length, pin : float
        Distance of the two bores, and radius of the big one.
    detail : float
        Factor on the number of triangles.
    """
    count = sides(detail)
    big = plate(circle(pin + 9, count), circle(pin, count), 24)
    small = plate(circle(19, count), circle(11.5, count), 24)
    low, high = pin + 7, length - 17
    shank = np.array([(-13, low), (13, low), (9, high), (-9, high)])
    slot = np.array([(-7, low + 14), (7, low + 14), (4.5, high - 10), (-4.5, high - 10)])
    bolts = [
        cylinder((x, -24, 0), (x, 22, 0), 4.5, 0.5, sides(detail, 0.25)) for x in (-29.0, 29.0)
    ]
    return merge(
        [big, transform(small, translation((0, length, 0))), plate(shank, slot, 15), *bolts]
    )


def crank_web(throw: float, detail: float) -> Mesh:
    """Return a web whose pin is at y = `throw`, with its counterweight below."""
    count = 2 * sides(detail)
    angle = np.arange(count) / count * 2 * math.pi
    aside, ahead = np.cos(angle), np.sin(angle)
    past = 31.0**2 - (throw * aside) ** 2
    reach = np.maximum(35.0, np.where(past > 0, throw * ahead + np.sqrt(np.maximum(past, 0)), 0))
    heavy = np.clip((-ahead - 0.38) / 0.06, 0, 1)
    reach += heavy * (81.0 - reach)
    web = np.stack([reach * aside, reach * ahead], axis=1)
    return plate(web, circle(9.0, count), 13)


def crankshaft(throw: float, pin: float, pitch: float, turns: Floats, detail: float) -> Mesh:
    """Return a crankshaft about the z axis, centered on the origin.

    Parameters
    ----------
    throw, pin : float
        Distance of the pins from the axis, and their radius.
    pitch : float
        Distance of the cylinders.
    turns : array, shape (n,)
        Angle of each pin from straight up, clockwise, from the front to the rear.
    detail : float
        Factor on the number of triangles.
    """
    count = len(turns)
    parts = []
    for place in range(count + 1):
        z = (count / 2 - place) * pitch
        parts.append(cylinder((0, 0, z - 16), (0, 0, z + 16), 27, 1, sides(detail)))
    for place, turn in enumerate(turns):
        z = ((count - 1) / 2 - place) * pitch
        x, y = throw * math.sin(turn), throw * math.cos(turn)
        parts.append(cylinder((x, y, z - 15.5), (x, y, z + 15.5), pin, 1, sides(detail)))
        for side in (-22.6, 22.6):
            lever = translation((0, 0, z + side)) @ rotation((0, 0, 1), -turn)
            parts.append(transform(crank_web(throw, detail), lever))
    return merge(parts)


def valve(detail: float) -> Mesh:
    """Return a poppet valve that stands on its head at y = 0, and its bucket tappet on top."""
    stem = outline(
        [(0, 0, 0), (15.5, 0, 0.5), (15.5, 2.5, 0.5), (3.2, 16, 8), (3.2, 96, 0.5), (0, 96, 0)],
        detail,
    )
    bucket = outline(
        [(0, 98, 0), (12.5, 98, 1), (12.5, 82, 0), (15, 82, 0), (15, 103, 1), (0, 103, 0)], detail
    )
    return merge([turned(stem, sides(detail, 0.4)), turned(bucket, sides(detail, 0.5))])


def spring(low: float, high: float, radius: float, turns: float, detail: float) -> Mesh:
    """Return a coil spring between two heights."""
    path = helix(radius, high - low, turns, divisions(17 * turns, detail, 24))
    coil = tube(path, 1.9, divisions(6, detail, 3))
    return transform(coil, translation((0, low, 0)))


def camshaft(length: float, lobes: Floats, turns: Floats, detail: float) -> Mesh:
    """Return a camshaft along z, with a lobe at each of `lobes` that points to an angle of `turns`.

    Parameters
    ----------
    length : float
        The shaft is centered on the origin.
    lobes, turns : array, shape (n,)
        z of each lobe, and the angle of its nose from straight up, clockwise.
    detail : float
        Factor on the number of triangles.
    """
    count = sides(detail)
    nose = plate(around([(0, 0, 15), (0, 17, 7)], count), circle(11, count), 13)
    parts = [cylinder((0, 0, -length / 2), (0, 0, length / 2), 10.5, 1, sides(detail, 0.6))]
    for z, turn in zip(lobes, turns, strict=True):
        parts.append(transform(nose, translation((0, 0, z)) @ rotation((0, 0, 1), -turn)))
    return merge(parts)


def wheel(teeth: int, radius: float, bore: float, depth: float, detail: float) -> Mesh:
    """Return a gear wheel with a bore: a toothed rim, a thinner web, and a hub.

    Below detail 1, it has fewer and coarser teeth than `teeth`.
    """
    toothed = gear(min(teeth, divisions(teeth, detail, 10)), radius - 4, radius)
    rim = plate(toothed, 0.78 * radius * unit(toothed), depth)
    count = sides(detail, 1.5)
    web = plate(circle(0.775 * radius, count), circle(1.55 * bore, count), 0.35 * depth)
    hub = plate(circle(1.5 * bore, count), circle(bore, count), 1.1 * depth)
    return merge([rim, web, hub])


def bolt(length: float, radius: float, detail: float) -> Mesh:
    """Return a bolt: its hexagonal head stands on y = 0, and its shank reaches down."""
    head = plate(circle(1.75 * radius, 6), circle(0.5 * radius, 6), 1.2 * radius)
    raised = translation((0, 0.65 * radius, 0)) @ rotation((1, 0, 0), -math.pi / 2)
    shank = tube([(0, -length, 0), (0, -0.1, 0)], radius, divisions(8, detail, 4))
    return merge([transform(head, raised), shank])


def shell(
    circles: list[tuple[float, float, float]], wall: float, depth: float, detail: float
) -> Mesh:
    """Return a housing along z that is open at both ends: a band around circles, `wall` thick."""
    count = 2 * sides(detail)
    inner = [(x, y, radius - wall) for x, y, radius in circles]
    return plate(around(circles, count), around(inner, count), depth)


def strip(center: Vector, size: Vector) -> Mesh:
    """Return a box that can be merged with the other parts."""
    return replace(box(center, size), uvs=None)


def pulley(radius: float, wide: float, detail: float) -> Mesh:
    """Return a pulley: a drum between two cheeks that are `wide` apart."""
    count = sides(detail, 1.5)
    cheek = plate(circle(radius + 5, count), circle(14.5, count), 3)
    drum = cylinder((0, 0, 1.7 - wide / 2), (0, 0, wide / 2 - 1.7), radius, 1, sides(detail))
    cheeks = [transform(cheek, translation((0, 0, end * wide / 2))) for end in (-1, 1)]
    return merge([drum, *cheeks])


def belt(
    loop: list[tuple[float, float, float]], gap: float, thick: float, wide: float, detail: float
) -> Mesh:
    """Return a belt around circles (x, y, radius), at a distance of `gap` from them."""
    count = sides(detail, 1.5)
    inner, outer = (
        around([(x, y, radius + more) for x, y, radius in loop], count)
        for more in (gap, gap + thick)
    )
    return plate(outer, inner, wide)


def generator(detail: float) -> Mesh:
    """Return a generator behind the origin: a round body with fins."""
    count = sides(detail, 1.5)
    fin = plate(circle(61, count), circle(56, count), 3)
    body = cylinder((0, 0, -132), (0, 0, -20), 55, 8, sides(detail))
    return merge([body, *(transform(fin, translation((0, 0, z))) for z in range(-120, -31, 11))])
