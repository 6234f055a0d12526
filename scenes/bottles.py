"""Four colored plastic bottles on a table, standing partly behind each other.

A view ray meets up to four walls per bottle: outer and inner wall, at the front and at the back.
One bottle is one object and its mesh holds both shells, as a modeler would export it. So no order
of the objects is right: inside a bottle the triangles come in the order of the mesh. A lamp behind
them throws their colors on the table. The arrangement is that of figure 12 of McGuire & Mara 2017,
"Phenomenological Transparency".
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from oitbench.modeling.mesh import (
    Floats,
    divisions,
    lathe,
    merge,
    quad,
    smooth_curve,
    transform,
    translation,
)
from oitbench.modeling.skies import gradient_sky
from oitbench.parameters import Parameter
from oitbench.scene import RGB, Camera, DirectionalLight, Material, Mesh, Object, Scene

parameters = {
    "detail": Parameter(1.0, low=0.0, high=100.0, help="factor on the triangles of a surface"),
    "coverage": Parameter(0.94, low=0.0, high=1.0, help="coverage of the plastic"),
}

WALL = 0.0025
# The bottles stand off the table by a millimetre: coincident surfaces have no right picture.
GAP = 0.001
TABLE = 30.0  # half of its sides, metres: its edge is the horizon
# The lamp stands behind the bottles, so that their shadows fall towards the viewer.
LAMP_DIRECTION: RGB = (0.62, -1.0, 0.62)
LAMP: RGB = (2.1, 2.0, 1.8)  # irradiance
ROOM = (
    (-90.0, (0.40, 0.39, 0.37)),
    (0.0, (0.66, 0.70, 0.72)),
    (14.0, (0.44, 0.55, 0.64)),
    (90.0, (0.34, 0.38, 0.44)),
)
PAPER = Material(albedo=(0.80, 0.77, 0.72), specular=0.0)
# Both of its walls are thin films: smooth enough for a highlight, and slightly milky.
REFLECTANCE, ROUGHNESS = 0.05, 0.25
MILKINESS = 0.08  # albedo of a white wall


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
    objects = [Object("table", quad((0, 0, 0), (TABLE, 0, 0), (0, 0, -TABLE)), PAPER, casts=False)]
    for bottle in BOTTLES:
        objects.append(Object(bottle.name, _walls(bottle, detail), _plastic(bottle, coverage)))
        cap = Material(albedo=_shade(bottle, 0.75, 3, 0.05), specular=0.04, roughness=0.35)
        objects.append(Object(f"cap of {bottle.name}", _cap(bottle, detail), cap))
    lamp = DirectionalLight(LAMP_DIRECTION, LAMP)
    return Scene(name, camera, tuple(objects), lights=(lamp, gradient_sky(ROOM)))


def _plastic(bottle: Bottle, coverage: float) -> Material:
    """Return the film of one wall, with a hint of body color under the reflections."""
    return Material(
        coverage=coverage,
        transmission=bottle.transmission,
        albedo=_shade(bottle, MILKINESS, 2, 0.0),
        specular=REFLECTANCE,
        roughness=ROUGHNESS,
    )


def _shade(bottle: Bottle, scale: float, power: int, offset: float) -> RGB:
    """Return a darker, more saturated shade of what passes the bottle."""
    red, green, blue = (scale * part**power + offset for part in bottle.transmission)
    return (red, green, blue)


def _walls(bottle: Bottle, detail: float) -> Mesh:
    """Return outer and inner wall as one mesh."""
    slices = divisions(96, detail, 8)
    outer = bottle.outline(divisions(96, detail, 16))
    shells = merge([lathe(outer, slices), lathe(_inset(outer)[::-1], slices)])
    return transform(shells, translation(bottle.foot))


def _inset(outline: Floats) -> Floats:
    """Return `outline` moved inwards by the thickness of the wall, closed at the axis."""
    tangent = np.gradient(outline, axis=0)
    normal = np.stack([tangent[:, 1], -tangent[:, 0]], axis=1)
    inner = outline - WALL * normal / np.linalg.norm(normal, axis=1, keepdims=True)
    inner[0, 0] = 0.0
    return np.asarray(np.maximum(inner, 0.0))


def _cap(bottle: Bottle, detail: float) -> Mesh:
    """Return an opaque screw cap over the mouth."""
    radius, top = bottle.radii[-1] / 1000 + WALL, bottle.heights[-1] / 1000
    side = smooth_curve(
        [(radius, top - 0.017), (radius, top), (radius, top)], divisions(8, detail, 2)
    )
    lid = smooth_curve(
        [(radius, top), (radius, top + 0.0035), (radius - 0.003, top + 0.0035), (0, top + 0.0035)],
        divisions(16, detail, 6),
    )
    slices = divisions(64, detail, 8)
    return transform(merge([lathe(side, slices), lathe(lid, slices)]), translation(bottle.foot))
