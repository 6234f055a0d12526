"""Drinking glasses, the drinks in them, ice, and tanks: each one closed solid.

Meters. Glasses stand on y = 0 about the y axis.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace

import numpy as np

from oitbench.modeling.detail import divisions
from oitbench.modeling.mesh import box, box_faces, grid
from oitbench.modeling.placement import merge
from oitbench.modeling.profiles import Corner, inset, outline
from oitbench.modeling.solids import turned
from oitbench.scene import Mesh, Vector

SLICES = 56
"""Divisions of a glass about its axis at detail 1."""


@dataclass(frozen=True)
class Vessel:
    """A drinking glass, given by the outlines of the two sides of its wall.

    Parameters
    ----------
    outside : tuple of Corner
        From the middle of the foot up to the rim.
    inside : tuple of Corner
        From the rim down to the middle of the bottom on the inside, where it ends on the axis.
    """

    outside: tuple[Corner, ...]
    inside: tuple[Corner, ...]

    def glass(self, detail: float) -> Mesh:
        """Return both sides of the wall as one closed solid."""
        profile = outline(self.outside + self.inside, detail)
        return turned(profile, divisions(SLICES, detail, 8))

    def filling(self, level: float, gap: float, detail: float) -> Mesh:
        """Return the drink in the glass as a closed solid.

        Parameters
        ----------
        level : float
            Height of the drink's surface in meters, within the straight part of the wall.
        gap : float
            Air between drink and glass in meters. If it is negative, the drink reaches into the
            glass, which must have a higher `Object.priority`. Not 0: no two surfaces may coincide.
        detail : float
            Factor on the number of triangles.
        """
        wall = inset(outline(self.inside[::-1], detail), gap)
        radius = float(np.interp(level, wall[:, 1], wall[:, 0]))
        edge = 2 * abs(gap)
        below: list[Corner] = [(r, h, 0.0) for r, h in wall if h < level - 2 * edge]
        return turned(
            outline([*below, (radius, level, edge), (0.0, level, 0.0)], detail),
            divisions(SLICES, detail, 8),
        )


def tumbler(foot: float, rim: float, height: float, wall: float, bottom: float) -> Vessel:
    """Return a straight-sided glass.

    Parameters
    ----------
    foot, rim : float
        Outer radii at its two ends, meters.
    height : float
        Meters.
    wall, bottom : float
        Thickness of the side and of the bottom, meters.
    """
    within = foot + (rim - foot) * bottom / height - wall
    return Vessel(
        outside=((0.0, 0.0, 0.0), (foot, 0.0, 1.2 * wall), (rim, height, 0.45 * wall)),
        inside=(
            (rim - wall, height, 0.45 * wall),
            (within, bottom, 2.5 * wall),
            (0.0, bottom, 0.0),
        ),
    )


def wine_glass(bowl: float, height: float, wall: float) -> Vessel:
    """Return a stemmed glass.

    Parameters
    ----------
    bowl : float
        Largest outer radius of the bowl, meters; the radius of the foot is 0.95 of it.
    height : float
        From the foot to the rim, meters.
    wall : float
        Thickness of the bowl, meters.
    """
    deep, stem, rim = 0.44 * height, 0.10 * bowl, 0.80 * bowl
    within = bowl - wall
    return Vessel(
        outside=(
            (0.0, 0.0, 0.0),
            (0.95 * bowl, 0.0, 0.005 * height),
            (0.95 * bowl, 0.015 * height, 0.005 * height),
            (stem, 0.05 * height, 0.5 * bowl),
            (stem, deep, 0.20 * bowl),
            (bowl, deep + 0.08 * height, 0.65 * bowl),
            (rim, height, 0.45 * wall),
        ),
        inside=(
            (rim - wall, height, 0.45 * wall),
            (within, deep + 0.08 * height + wall, 0.65 * bowl),
            (0.0, deep + 2 * wall, 0.0),
        ),
    )


def ice_cube(size: Vector, rounding: float, detail: float) -> Mesh:
    """Return a box about the origin with rounded edges and corners.

    Parameters
    ----------
    size : Vector
        Edge lengths along x, y and z, meters.
    rounding : float
        Radius of the rounding in meters, below half the shortest edge length.
    detail : float
        Factor on the number of triangles.
    """
    cells = divisions(6, detail, 2) * 2
    # Whole numbers make faces agree exactly on their common edges.
    step = box((0, 0, 0), (cells, cells, cells), cells).positions.astype(np.float64)
    triangles = box((0, 0, 0), (1, 1, 1), cells).triangles
    half = np.asarray(size) / 2
    core = half - rounding
    # Half of the steps are on the rounded rims, each of which turns by 45°.
    along = 2 * np.abs(step) / cells
    flat = np.minimum(2 * along, 1.0) * core
    rim = np.maximum(2 * along - 1, 0.0)
    bulge = np.sign(step) * np.tan(rim * np.pi / 4)
    normals = bulge / np.linalg.norm(bulge, axis=1, keepdims=True)
    positions = np.sign(step) * flat + rounding * normals
    return Mesh.from_arrays(positions, triangles, normals=normals)


def tank(size: Vector, wall: float) -> Mesh:
    """Return a rectangular tank of glass that stands on y = 0 and is open above.

    Parameters
    ----------
    size : Vector
        Outer edge lengths along x, y and z, meters.
    wall : float
        Thickness of the walls and of the bottom, meters.
    """
    width, height, depth = size
    outer = _sides((0, height / 2, 0), size)
    inner_size = (width - 2 * wall, height - wall, depth - 2 * wall)
    inner = _sides((0, (height + wall) / 2, 0), inner_size)
    rim = []
    for first, last in itertools.pairwise([0, 1, 2, 3, 0]):
        turns = np.array([(1, 1), (1, -1), (-1, -1), (-1, 1)])[[first, last]]
        corners = [
            (x * (width / 2 - inset), height, z * (depth / 2 - inset))
            for inset, ends in ((0.0, turns), (wall, turns[::-1]))
            for x, z in ends
        ]
        rim.append(
            Mesh.from_arrays(
                corners, [(0, 1, 2), (0, 2, 3)], normals=np.tile([0.0, 1.0, 0.0], (4, 1))
            )
        )
    assert inner.normals is not None
    inwards = Mesh.from_arrays(inner.positions, inner.triangles[:, ::-1], normals=-inner.normals)
    return merge([outer, inwards, *rim])


def _sides(center: Vector, size: Vector) -> Mesh:
    """Return the faces of a box but the upper one, without uvs."""
    faces = [face for face in box_faces(center, size) if face[0][1] <= center[1] + 1e-9]
    return replace(merge([grid(*face) for face in faces]), uvs=None)
