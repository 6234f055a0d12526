"""Furniture of a patio: tables, chairs, plates, oil lamps and pots.

Meters, y up. Everything stands on y = 0 at the origin, and a chair faces +z.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from oitbench.modeling.detail import divisions
from oitbench.modeling.mesh import lathe, slab, sphere
from oitbench.modeling.placement import merge, rotation, scaling, transform, translation
from oitbench.modeling.profiles import Corner, outline
from oitbench.modeling.solids import turned
from oitbench.modeling.sweeps import pipe, tube
from oitbench.scene import Floats, Mesh, Vector

TURNED = 40
"""Divisions of a turned part about its axis at detail 1."""


def round_table(radius: float, height: float, detail: float) -> Mesh:
    """Return a round table on one foot; `height` is that of its upper face."""
    corners: list[Corner] = [(0, 0, 0), (0.62 * radius, 0, 0.01), (0.60 * radius, 0.03, 0.01)]
    corners += [(0.05, 0.09, 0.04), (0.04, 0.5 * height, 0.3), (0.06, height - 0.05, 0.02)]
    corners += [(radius - 0.01, height - 0.035, 0.004), (radius, height - 0.02, 0.006)]
    corners += [(radius, height, 0.006), (0, height, 0)]
    return turned(outline(corners, detail), divisions(TURNED, detail, 10))


def cloth(radius: float, drop: float, folds: int, detail: float) -> Mesh:
    """Return a round tablecloth at y = 0 that hangs down in folds at the edge, seen from outside.

    Parameters
    ----------
    radius, drop : float
        Radius of the flat part, and how far the edge hangs down, meters.
    folds : int
        Number of folds around the edge.
    detail : float
        Factor on the number of triangles.
    """
    slices = divisions(folds * 8, detail, 4 * folds)
    angle = np.arange(slices) / slices * 2 * math.pi
    rows = divisions(8, detail, 3)
    hang = np.linspace(0, 1, rows + 1)
    wave = 1 + 0.09 * hang[:, None] * np.cos(folds * angle)
    skirt = np.stack(
        [
            (radius + 0.05 * hang[:, None]) * wave * np.cos(angle),
            -drop * hang[:, None] * np.ones_like(wave),
            -(radius + 0.05 * hang[:, None]) * wave * np.sin(angle),
        ],
        axis=-1,
    )
    return _open(np.concatenate([skirt[::-1], np.zeros((1, slices, 3))]))


def _open(points: Floats) -> Mesh:
    """Return the mesh of rings of points, shape (rings, slices, 3), the last of which is a point.

    Normals are smooth within the skirt and up on the flat part.
    """
    rings, slices = points.shape[:2]
    around = np.roll(points, -1, axis=1) - np.roll(points, 1, axis=1)
    along = np.gradient(points[:-1], axis=0)
    normals = np.cross(around[:-1], along)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    up = np.broadcast_to([0.0, 1.0, 0.0], (slices, 3))
    # The rim belongs to the skirt and, a second time, to the flat part.
    positions = np.concatenate([points[:-1].reshape(-1, 3), points[-2], points[-1]])
    shades = np.concatenate([normals.reshape(-1, 3), up, up])
    this = np.arange(slices)
    following = np.roll(this, -1)
    start = np.arange(rings - 2)[:, None] * slices
    lower, right = (start + this).ravel(), (start + following).ravel()
    rim = (rings - 1) * slices
    triangles = np.concatenate(
        [
            np.stack([lower, right, right + slices], axis=1),
            np.stack([lower, right + slices, lower + slices], axis=1),
            np.stack([rim + this, rim + following, rim + slices + this], axis=1),
        ]
    )
    return Mesh.from_arrays(positions, triangles, normals=shades)


def chair(detail: float) -> Mesh:
    """Return a wooden chair with a slatted back; its seat is 0.46 m high."""
    sides = divisions(8, detail, 4)
    legs = [
        tube([(x, 0, z), (0.92 * x, 0.44, 0.92 * z)], 0.018, sides)
        for x in (-0.2, 0.2)
        for z in (-0.2, 0.2)
    ]
    posts = [
        pipe([(x, 0.45, -0.19), (x, 0.7, -0.2), (x, 0.95, -0.27)], 0.017, 6, sides)
        for x in (-0.19, 0.19)
    ]
    slats = [
        slab((-0.19, y, z - 0.006), (0.19, y + 0.055, z + 0.006))
        for y, z in ((0.62, -0.203), (0.74, -0.216), (0.87, -0.245))
    ]
    wood = [slab((-0.21, 0.44, -0.21), (0.21, 0.47, 0.21)), *slats]
    return merge([*legs, *posts, *(replace(part, uvs=None) for part in wood)])


def plate_of_china(radius: float, detail: float) -> Mesh:
    """Return a plate with a rim."""
    corners: list[Corner] = [(0, 0.002, 0), (0.6 * radius, 0, 0.002), (radius, 0.016, 0.001)]
    corners += [(radius, 0.019, 0.001), (0.62 * radius, 0.006, 0.01), (0, 0.006, 0)]
    return turned(outline(corners, detail), divisions(TURNED, detail, 10))


def pot(radius: float, height: float, detail: float) -> Mesh:
    """Return a flower pot with a rim, filled with earth."""
    corners: list[Corner] = [(0, 0, 0), (0.68 * radius, 0, 0.01), (0.93 * radius, 0.82 * height, 0)]
    corners += [(radius, 0.83 * height, 0.005), (radius, height, 0.008)]
    corners += [(0.9 * radius, height, 0.008), (0.9 * radius, 0.93 * height, 0)]
    corners += [(0, 0.95 * height, 0)]
    return turned(outline(corners, detail), divisions(TURNED, detail, 10))


@dataclass(frozen=True)
class OilLamp:
    """An oil lamp in three meshes, one for each material.

    Parameters
    ----------
    base, flame, flue : Mesh
        Opaque metal, the flame, and the thin glass around the flame, which is open at both ends.
    """

    base: Mesh
    flame: Mesh
    flue: Mesh

    def transformed(self, matrix: Floats) -> OilLamp:
        """Return the lamp under an affine (4, 4) matrix."""
        return OilLamp(*(transform(part, matrix) for part in (self.base, self.flame, self.flue)))


FLAME: Vector = (0.0, 0.190, 0.0)
"""Middle of the flame of an oil lamp, meters."""


def oil_lamp(detail: float) -> OilLamp:
    """Return an oil lamp, 0.36 m tall."""
    slices = divisions(TURNED, detail, 8)
    corners: list[Corner] = [
        (0, 0, 0), (0.055, 0, 0.004), (0.05, 0.012, 0.006), (0.018, 0.03, 0.006),
        (0.020, 0.045, 0.004), (0.058, 0.075, 0.012), (0.050, 0.115, 0.012), (0.024, 0.130, 0.004),
        (0.030, 0.140, 0.002), (0.030, 0.150, 0.002), (0.008, 0.152, 0), (0.006, 0.165, 0),
        (0, 0.166, 0),
    ]  # fmt: skip
    ball = replace(
        sphere((0, 0, 0), 1.0, divisions(16, detail, 6), divisions(10, detail, 4)), uvs=None
    )
    flame = transform(ball, translation(FLAME) @ scaling((0.009, 0.022, 0.009)))
    glass = outline(
        [(0.027, 0.152, 0), (0.026, 0.165, 0.01), (0.042, 0.205, 0.03), (0.022, 0.26, 0.04),
         (0.020, 0.36, 0)], detail,
    )  # fmt: skip
    return OilLamp(
        turned(outline(corners, detail), slices), flame, replace(lathe(glass, slices), uvs=None)
    )


def around_table(radius: float, count: int, turn: float) -> Floats:
    """Return frames for `scatter` of `count` things on a circle that look at its middle.

    The first stands `turn` radians about the y axis from +z. Shape (count, 3, 4).
    """
    angles = turn + np.arange(count) / count * 2 * math.pi
    turned_by = (rotation((0, 1, 0), angle) @ translation((0, 0, radius)) for angle in angles)
    facing = rotation((0, 1, 0), math.pi)
    return np.stack([(matrix @ facing)[:3] for matrix in turned_by])
