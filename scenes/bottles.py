"""Four colored plastic bottles on a table, standing partly behind each other.

A view ray meets up to four walls per bottle: outer and inner wall, at the front and at the back.
One bottle is one object and its mesh holds both shells, as a modeler would export it. So no order
of the objects is right: inside a bottle the triangles come in the order of the mesh. The
arrangement is that of figure 12 of McGuire & Mara 2017, "Phenomenological Transparency".
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from oitbench.bake import (
    Floats,
    Rig,
    cone,
    diffuse,
    gloss,
    normals_of,
    revolved_chord,
    tint,
    with_radiance,
)
from oitbench.geometry import divisions, grid, lathe, merge, smooth_curve, transform, translation
from oitbench.scene import RGB, WHITE, Camera, Material, Mesh, Object, Scene
from oitbench.selector import Parameter

parameters = {
    "detail": Parameter(1.0, low=0.0, high=100.0, help="factor on the triangles of a surface"),
    "coverage": Parameter(0.94, low=0.0, high=1.0, help="coverage of the plastic"),
}

WALL = 0.0025
# The bottles stand off the table by a millimetre: coincident surfaces have no right picture.
GAP = 0.001
BACKGROUND: RGB = (0.42, 0.52, 0.60)
# The lamp behind the bottles throws colored shadows towards the viewer; a window in front of
# them makes the highlights.
LAMP = Rig(
    toward_key=(-0.62, 1.0, -0.62),
    key=(0.54, 0.51, 0.45),
    sky=(0.50, 0.51, 0.53),
    ground=(0.46, 0.46, 0.46),
)
WINDOW = Rig(
    toward_key=(-0.75, 0.55, 0.75),
    key=(0.24, 0.25, 0.26),
    sky=(0.55, 0.60, 0.66),
    ground=(0.22, 0.21, 0.20),
)
LAMP_SPREAD = math.radians(4)


@dataclass(frozen=True)
class Bottle:
    """A bottle's foot, its transmission per wall, and its outline from the foot to the mouth.

    `radii` and `heights` are the corners of the outline in millimetres, rounded off later.
    """

    name: str
    foot: RGB
    transmission: RGB
    radii: tuple[float, ...]
    heights: tuple[float, ...]

    def outline(self, count: int) -> Floats:
        """Return `count` points (radius, height) in metres, from the foot's middle upwards."""
        return smooth_curve(np.stack([self.radii, self.heights], axis=1) / 1000, count)


BOTTLES = (
    Bottle(
        "ruby",
        foot=(-0.090, GAP, 0.020),
        transmission=(0.94, 0.46, 0.47),
        radii=(0, 41, 41, 39, 33, 40, 41, 36, 13, 13),
        heights=(0, 0, 20, 80, 105, 135, 180, 215, 235, 262),
    ),
    Bottle(
        "emerald",
        foot=(-0.042, GAP, -0.075),
        transmission=(0.50, 0.90, 0.60),
        radii=(0, 34, 34, 34, 34, 12, 12, 12),
        heights=(0, 0, 30, 200, 235, 250, 290, 325),
    ),
    Bottle(
        "amber",
        foot=(0.032, GAP, 0.050),
        transmission=(0.96, 0.76, 0.38),
        radii=(0, 52, 54, 52, 44, 18, 14, 14),
        heights=(0, 0, 20, 60, 110, 145, 165, 192),
    ),
    Bottle(
        "sapphire",
        foot=(0.090, GAP, -0.040),
        transmission=(0.46, 0.64, 0.94),
        radii=(0, 46, 47, 47, 47, 34, 15, 15),
        heights=(0, 0, 20, 120, 165, 200, 215, 245),
    ),
)


def build(*, name: str, detail: float, coverage: float) -> Scene:
    """Return the table and the bottles, in an order of submission that no view would choose."""
    camera = Camera(
        position=(0.03, 0.25, 0.98), target=(0.002, 0.142, 0.0), fov_y=math.radians(23.5)
    )
    objects = [Object("table", _table(detail), Material(emission=WHITE))]
    for bottle in BOTTLES:
        plastic = Material(coverage=coverage, transmission=bottle.transmission, emission=WHITE)
        objects.append(Object(bottle.name, _plastic(bottle, camera, detail), plastic))
        cap = _cap(bottle, camera, detail)
        objects.append(Object(f"cap of {bottle.name}", cap, Material(emission=WHITE)))
    return Scene(name=name, camera=camera, objects=tuple(objects), background=BACKGROUND)


def _plastic(bottle: Bottle, camera: Camera, detail: float) -> Mesh:
    """Return outer and inner wall as one mesh, with a hint of body color under the reflections."""
    slices = divisions(96, detail, 8)
    outer = bottle.outline(divisions(96, detail, 16))
    shells = merge([lathe(outer, slices), lathe(_inset(outer)[::-1], slices)])
    placed = transform(shells, translation(bottle.foot))
    body = 0.10 * np.asarray(bottle.transmission) ** 2 * diffuse(normals_of(placed), WINDOW)
    return with_radiance(placed, body + gloss(placed, camera, WINDOW, exponent=70, rim=0.5))


def _inset(outline: Floats) -> Floats:
    """Return `outline` moved inwards by the thickness of the wall, closed at the axis."""
    tangent = np.gradient(outline, axis=0)
    normal = np.stack([tangent[:, 1], -tangent[:, 0]], axis=1)
    inner = outline - WALL * normal / np.linalg.norm(normal, axis=1, keepdims=True)
    inner[0, 0] = 0.0
    return np.asarray(np.maximum(inner, 0.0))


def _cap(bottle: Bottle, camera: Camera, detail: float) -> Mesh:
    """Return an opaque screw cap over the mouth, in a dark shade of the bottle's color."""
    radius, top = bottle.radii[-1] / 1000 + WALL, bottle.heights[-1] / 1000
    side = smooth_curve(
        [(radius, top - 0.017), (radius, top), (radius, top)], divisions(8, detail, 2)
    )
    lid = smooth_curve(
        [(radius, top), (radius, top + 0.0035), (radius - 0.003, top + 0.0035), (0, top + 0.0035)],
        divisions(16, detail, 6),
    )
    slices = divisions(64, detail, 8)
    cap = transform(merge([lathe(side, slices), lathe(lid, slices)]), translation(bottle.foot))
    paint = 0.75 * np.asarray(bottle.transmission) ** 3 + 0.1
    shade = paint * diffuse(normals_of(cap), WINDOW) + 0.5 * gloss(cap, camera, WINDOW, 40, 0.3)
    return with_radiance(cap, shade)


def _table(detail: float) -> Mesh:
    """Return a sheet that lies as the table and bends up into the backdrop, with baked shadows."""
    columns, rows = divisions(150, detail, 24), divisions(180, detail, 28)
    # Rows and columns crowd where the shadows fall.
    flat = grid((0, 0, 0), (1, 0, 0), (0, 1, 0), columns, rows).positions.astype(np.float64)
    across = 0.35 * flat[:, 0] + 1.65 * flat[:, 0] ** 5
    along = np.interp(flat[:, 1], [-1, -0.75, 0.4, 1], [-0.6, -0.28, 0.3, 2.4])
    path = smooth_curve([(0.6, 0), (-0.45, 0), (-0.95, 0), (-0.95, 0.6), (-0.95, 1.8)], 400)
    reach = np.linspace(-0.6, 2.4, len(path))
    sheet = grid((0, 0, 0), (1, 0, 0), (0, 0, -1), columns, rows)
    z, y = (np.interp(along, reach, column) for column in path.T)
    positions = np.stack([across, y, z], axis=1)
    slope = np.gradient(path, axis=0)
    normal_y, normal_z = (np.interp(along, reach, column) for column in (-slope[:, 0], slope[:, 1]))
    normals = np.stack([np.zeros_like(y), normal_y, normal_z], axis=1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    mesh = Mesh(positions.astype(np.float32), sheet.triangles, normals=normals.astype(np.float32))
    return with_radiance(mesh, _table_radiance(positions, normals))


def _table_radiance(positions: Floats, normals: Floats) -> Floats:
    """Return warm paper below and a cool gradient above, under the bottles' colored shadows."""
    lit, openness = np.ones((2, len(positions), 3))
    near = np.flatnonzero((np.abs(positions[:, 0]) < 0.4) & (np.abs(positions[:, 2]) < 0.4))
    ground = positions[near]
    directions = cone(LAMP.direction, LAMP_SPREAD, 16)
    arriving = np.zeros((len(near), 3))
    for direction in directions:
        passed = np.ones((len(near), 3))
        for bottle in BOTTLES:
            passed *= _transmitted(bottle, ground, direction)
        arriving += passed / len(directions)
    lit[near] = arriving
    for bottle in BOTTLES:
        gap = np.hypot(ground[:, 0] - bottle.foot[0], ground[:, 2] - bottle.foot[2])
        gap -= bottle.radii[1] / 1000
        openness[near] *= 1 - 0.5 * np.exp(-np.maximum(gap, 0) / 0.018)[:, None]
    height = np.clip((positions[:, 1] - 0.02) / 0.75, 0, 1)
    paper = tint(height, [(0.88, 0.84, 0.78), (0.70, 0.80, 0.86), (0.42, 0.60, 0.76)])
    distance = np.hypot(positions[:, 0] + 0.05, 0.7 * (positions[:, 2] - 0.05))
    falloff = 0.72 + 0.28 / (1 + (distance / 0.55) ** 2)
    return paper * falloff[:, None] * diffuse(normals, LAMP, lit, openness)


def _transmitted(bottle: Bottle, points: Floats, direction: Floats) -> Floats:
    """Return what the lamp's light keeps, shape (n, 3): four walls, thinner where it grazes."""
    chord = revolved_chord(points, direction, bottle.outline(64), bottle.foot)
    walls = 4 * np.clip(chord / 0.02, 0, 1)[:, None]
    return np.asarray(np.asarray(bottle.transmission) ** walls)
