"""Parked vehicles: bodies with windows all around, wheels and lamps.

Meters, y up. A vehicle stands on y = 0 with its middle at the origin, and its front faces −x.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from oitbench.modeling.detail import divisions
from oitbench.modeling.mesh import box, lathe, lattice
from oitbench.modeling.placement import merge, rotation, transform, translation
from oitbench.modeling.profiles import smooth_curve
from oitbench.modeling.tubes import tubes
from oitbench.scene import Floats, Mesh, unit

TIRE, TIRE_WIDTH = 0.33, 0.21
"""Radius and width of a wheel."""
_FLOOR = 0.26
"""Height of the underside."""


@dataclass(frozen=True)
class Shape:
    """The outline of a vehicle from its front to its back.

    Parameters
    ----------
    belt : tuple of (float, float)
        (x, y) of the line between the lower body and the windows.
    glass : tuple of float
        x at the foot of the windshield, its head, the head of the rear window, and its foot.
    roof : float
        Height of the roof.
    width : float
        Of the lower body.
    taper : float
        Width of the roof over that of the body.
    axles : (float, float)
        x of the wheels.
    pillars : tuple of float
        x of the posts between the side windows.
    """

    belt: tuple[tuple[float, float], ...]
    glass: tuple[float, float, float, float]
    roof: float
    width: float
    taper: float
    axles: tuple[float, float]
    pillars: tuple[float, ...]


SEDAN = Shape(
    belt=(
        (-2.22, 0.62),
        (-2.12, 0.72),
        (-1.0, 0.92),
        (-0.6, 0.95),
        (1.3, 1.0),
        (2.1, 0.97),
        (2.2, 0.8),
    ),
    glass=(-0.95, -0.20, 0.85, 1.50),
    roof=1.45,
    width=1.74,
    taper=0.70,
    axles=(-1.35, 1.32),
    pillars=(0.38,),
)
VAN = Shape(
    belt=((-2.35, 0.70), (-2.25, 0.85), (-1.75, 1.08), (-1.4, 1.15), (2.2, 1.15), (2.35, 1.10)),
    glass=(-1.75, -1.05, 2.12, 2.28),
    roof=2.05,
    width=1.86,
    taper=0.84,
    axles=(-1.45, 1.45),
    pillars=(-0.35, 0.95),
)


@dataclass(frozen=True)
class Vehicle:
    """A vehicle in meshes of one material each.

    Parameters
    ----------
    paint, glass, rubber, metal : Mesh
        Body with roof and pillars; windows; tires and moldings; rims, bumpers and lamps.
    """

    paint: Mesh
    glass: Mesh
    rubber: Mesh
    metal: Mesh

    def transformed(self, matrix: Floats) -> Vehicle:
        """Return the vehicle under an affine (4, 4) matrix."""
        parts = (self.paint, self.glass, self.rubber, self.metal)
        return Vehicle(*(transform(part, matrix) for part in parts))


def vehicle(shape: Shape, detail: float) -> Vehicle:
    """Return a vehicle of a shape."""
    stations = divisions(56, detail, 14)
    paint = [_body(shape, stations), *_top(shape)]
    rubber, metal = [], []
    for x in shape.axles:
        for side in (-1, 1):
            tire, rim = _wheel(detail)
            place = translation((x, TIRE, side * (shape.width / 2 - 0.5 * TIRE_WIDTH + 0.015)))
            turn = rotation((1, 0, 0), side * math.pi / 2)
            rubber.append(transform(tire, place @ turn))
            metal.append(transform(rim, place @ turn))
    ends = shape.belt[0][0], shape.belt[-1][0]
    for x in (ends[0] + 0.02, ends[1] - 0.02):
        rubber.append(box((x, 0.42, 0), (0.12, 0.17, 0.98 * shape.width)))
        for side in (-1, 1):
            metal.append(box((x, 0.60, side * 0.36 * shape.width), (0.10, 0.10, 0.30)))
    return Vehicle(merge(paint), merge(_windows(shape)), merge(rubber), merge(metal))


def _body(shape: Shape, stations: int) -> Mesh:
    """Return the lower body, open below."""
    belt = smooth_curve(shape.belt, stations)
    x = belt[:, 0]
    span = x[-1] - x[0]
    nose = np.clip(np.minimum(x - x[0], x[-1] - x) / (0.10 * span), 0, 1)
    half = shape.width / 2 * (0.86 + 0.14 * np.sqrt(1 - (1 - nose) ** 2))
    heights = belt[:, 1]
    # A ring runs from the left sill over the belt and the hood to the right sill.
    levels = ((0.95, 0.0), (1.0, 0.25), (1.015, 0.6), (0.99, 0.9), (0.93, 1.0), (0.80, 1.025))
    left = [(part * half, _FLOOR + level * (heights - _FLOOR)) for part, level in levels]
    middle = (np.zeros_like(half), _FLOOR + 1.06 * (heights - _FLOOR))
    ring = [*left, middle, *((-z, y) for z, y in reversed(left))]
    points = np.stack([np.stack([x, y, -z], axis=1) for z, y in ring], axis=1)
    return merge([_sheet(points), *_caps(points)])


def _caps(points: Floats) -> list[Mesh]:
    """Return the front and the back, as fans."""
    caps = []
    for ring, way in ((points[0], -1.0), (points[-1], 1.0)):
        center = ring.mean(axis=0)
        fan = np.concatenate([center[None], ring])
        index = np.arange(1, len(ring))
        faces = np.stack([0 * index, index, index + 1][:: 1 if way < 0 else -1], axis=1)
        normals = np.tile([way, 0.0, 0.0], (len(fan), 1))
        uvs = np.zeros((len(fan), 2))
        caps.append(Mesh.from_arrays(fan, faces, normals=normals, uvs=uvs))
    return caps


def _sheet(points: Floats) -> Mesh:
    """Return a smooth sheet through a grid of points, shape (rows, columns, 3)."""
    rows, columns = points.shape[:2]
    normals = unit(np.cross(np.gradient(points, axis=1), np.gradient(points, axis=0)))
    faces = lattice(columns - 1, rows - 1)
    u, v = np.meshgrid(np.linspace(0, 1, columns), np.linspace(0, 1, rows))
    uvs = np.stack([u.ravel(), v.ravel()], axis=1)
    return Mesh.from_arrays(points.reshape(-1, 3), faces, normals=normals.reshape(-1, 3), uvs=uvs)


def _edges(shape: Shape) -> tuple[Floats, Floats]:
    """Return the feet of the four corner posts of the left side, and their heads; (4, 3) each.

    Windshield, front and rear ends of the roof, rear window; the second and third foot are below.
    """
    foot, head, last, end = shape.glass
    belt = np.asarray(shape.belt)
    half, top = 0.40 * shape.width, shape.taper * shape.width / 2

    def at(x: float) -> Floats:
        return np.array([x, np.interp(x, belt[:, 0], belt[:, 1]) - 0.01, -half * 1.12])

    feet = np.array([at(foot), at(head), at(last), at(end)])
    heads = np.array(
        [
            [head, shape.roof, -top],
            [head, shape.roof, -top],
            [last, shape.roof, -top],
            [last, shape.roof, -top],
        ]
    )
    return feet, heads


_MIRROR = np.array([1.0, 1.0, -1.0])


def _windows(shape: Shape) -> list[Mesh]:
    """Return windshield, rear window and side windows."""
    feet, heads = _edges(shape)
    panes = [
        np.stack([[feet[0], feet[0] * _MIRROR], [heads[0], heads[0] * _MIRROR]]),
        np.stack([[feet[3] * _MIRROR, feet[3]], [heads[3] * _MIRROR, heads[3]]]),
    ]
    for side in (np.ones(3), _MIRROR):
        lower = feet * side
        upper = heads * side
        upper[[0, 3]] = lower[[0, 3]] + 0.04 * (upper[[0, 3]] - lower[[0, 3]])
        order = slice(None, None, 1 if side[2] < 0 else -1)
        panes.append(np.stack([lower, upper], axis=0)[:, order])
    return [_sheet(np.asarray(pane)) for pane in panes]


def _top(shape: Shape) -> list[Mesh]:
    """Return the roof, slightly arched, and the posts around the windows."""
    feet, heads = _edges(shape)
    across = np.linspace(-1, 1, 9)
    along = np.linspace(0, 1, 6)
    first, last = heads[1], heads[2]
    x = first[0] + (last[0] - first[0]) * along
    y = shape.roof + 0.05 * (1 - across**2)
    points = np.stack(np.broadcast_arrays(x[:, None], y[None], first[2] * across[None]), axis=2)
    lines = [[feet[0], heads[0]], [feet[3], heads[3]], [heads[1], heads[2]]]
    for x_post in shape.pillars:
        low = np.array([x_post, np.interp(x_post, *np.asarray(shape.belt).T), feet[1][2]])
        lines.append([low, np.array([x_post, shape.roof, heads[1][2]])])
    posts = np.array(lines)
    both = np.concatenate([posts, posts * _MIRROR])
    bars = [[heads[1], heads[1] * _MIRROR], [heads[2], heads[2] * _MIRROR]]
    return [_sheet(points[:, ::-1]), tubes(np.concatenate([both, np.array(bars)]), 0.035, 6)]


def _wheel(detail: float) -> tuple[Mesh, Mesh]:
    """Return a tire and its rim about the y axis, whose outer side is up."""
    slices, half = divisions(28, detail, 10), TIRE_WIDTH / 2
    outline = [
        (0.20, -half),
        (0.30, -half),
        (TIRE, -0.6 * half),
        (TIRE, 0.6 * half),
        (0.30, half),
        (0.20, 0.92 * half),
    ]
    tire = lathe(smooth_curve(outline, divisions(18, detail, 8)), slices)
    rim = lathe(
        [(0.205, 0.85 * half), (0.12, 0.70 * half), (0.05, 0.80 * half), (0.0, 0.82 * half)], slices
    )
    return tire, rim
