"""Four bottles of colored plastic on a table, partly behind each other, under a lamp behind them.

Arranged as figure 12 of McGuire & Mara 2017, "Phenomenological Transparency".

Parameters
----------
detail : float
    Factor on the number of triangles.
coverage : float
    Coverage α of the plastic, in [0, 1].
near : float
    Distance of the near plane from the camera, m. The table begins at 0.79 m in the picture, and
    the bottles stand at 0.9 to 1.05 m.

A view ray meets up to four walls per bottle: the outer and the inner wall, at the front and at the
back. Each bottle is one object whose mesh holds both walls, as a modeling program would export it.
No order of the objects is therefore right: inside a bottle, triangles are drawn in the order of the
mesh. The lamp casts colored shadows towards the viewer.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from oitbench.modeling.detail import DETAIL, divisions
from oitbench.modeling.mesh import lathe, quad
from oitbench.modeling.placement import merge, transform, translation
from oitbench.modeling.profiles import inset, smooth_curve
from oitbench.modeling.surroundings import gradient_sky
from oitbench.parameters import Parameter
from oitbench.scene import (
    RGB,
    Camera,
    DirectionalLight,
    Floats,
    Material,
    Mesh,
    Object,
    Scene,
    Vector,
)

subject = "glass"
near = 0.7
crops = {"overlap": (0.42, 0.36, 0.26, 0.26), "shadows": (0.34, 0.76, 0.5, 0.22)}
parameters = {
    "detail": DETAIL,
    "coverage": Parameter(0.94, low=0.0, high=1.0, help="coverage of the plastic"),
}

WALL = 0.0025
"""Thickness of the plastic, meters."""
GAP = 0.001
"""Meters between the table and the bottles: coincident surfaces have no right picture."""
TABLE = 30.0  # half of its sides, meters; its edge is the horizon
# The lamp is behind the bottles, so that their shadows fall towards the viewer.
LAMP_DIRECTION: Vector = (0.62, -1.0, 0.62)
LAMP: RGB = (2.1, 2.0, 1.8)  # irradiance
# The table hides the lower half. It fades slowly, because a sharp edge would show how OpenGL rounds
# the lobes of rough reflections.
ROOM = (
    (-90.0, (0.0, 0.0, 0.0)),
    (-1.4, (0.66, 0.70, 0.72)),
    (14.0, (0.44, 0.55, 0.64)),
    (90.0, (0.34, 0.38, 0.44)),
)
PAPER = Material(albedo=(0.80, 0.77, 0.72), specular=0.0)
# Each wall of a bottle is a thin film, smooth enough for a highlight and slightly milky.
REFLECTANCE, ROUGHNESS = 0.05, 0.25
MILKINESS = 0.08  # albedo of a white wall


@dataclass(frozen=True)
class Bottle:
    """A bottle.

    Parameters
    ----------
    name : str
    foot : Vector
        Position of the middle of the foot, meters.
    transmission : RGB
        Transmission of one wall.
    radii, heights : tuple of float
        Corners of the outline from the foot to the mouth, millimeters. They will be rounded off.
    """

    name: str
    foot: Vector
    transmission: RGB
    radii: tuple[float, ...]
    heights: tuple[float, ...]

    def outline(self, count: int) -> Floats:
        """Return `count` points (radius, height) in meters, from the middle of the foot upwards."""
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
    """Return the table and the bottles, in an order that is right from no viewpoint."""
    camera = Camera(
        position=(0.03, 0.25, 0.98), target=(0.002, 0.142, 0.0), fov_y=math.radians(23.5)
    )
    objects = [Object("table", quad((0, 0, 0), (TABLE, 0, 0), (0, 0, -TABLE)), PAPER, casts=False)]
    for bottle in BOTTLES:
        objects.append(Object(bottle.name, _walls(bottle, detail), _plastic(bottle, coverage)))
        cap = Material(albedo=_shade(bottle, 0.75, 3, 0.05), specular=0.04, roughness=0.35)
        objects.append(Object(f"cap of {bottle.name}", _cap(bottle, detail), cap))
    lamp = DirectionalLight(LAMP_DIRECTION, LAMP)
    return Scene(name, camera, tuple(objects), lights=(lamp, gradient_sky(ROOM)), full_samples=40)


def _plastic(bottle: Bottle, coverage: float) -> Material:
    """Return the film of one wall, with a slight diffuse color."""
    return Material(
        coverage=coverage,
        transmission=bottle.transmission,
        albedo=_shade(bottle, MILKINESS, 2, 0.0),
        specular=REFLECTANCE,
        roughness=ROUGHNESS,
    )


def _shade(bottle: Bottle, scale: float, power: int, offset: float) -> RGB:
    """Return a darker, more saturated shade of the bottle's transmission."""
    red, green, blue = (scale * part**power + offset for part in bottle.transmission)
    return (red, green, blue)


def _walls(bottle: Bottle, detail: float) -> Mesh:
    """Return the outer and the inner wall as one mesh."""
    slices = divisions(96, detail, 8)
    outer = bottle.outline(divisions(96, detail, 16))
    inner = np.maximum(inset(outer, WALL), 0.0)
    shells = merge([lathe(outer, slices), lathe(inner[::-1], slices)])
    return transform(shells, translation(bottle.foot))


def _cap(bottle: Bottle, detail: float) -> Mesh:
    """Return a screw cap over the mouth."""
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
