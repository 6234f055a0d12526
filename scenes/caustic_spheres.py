"""Three clear balls and a clear knot over a tiled floor, with their caustics under a spot light.

Stands for figures 10 and 11 of McGuire & Mara 2017, "Phenomenological Transparency".

Parameters
----------
detail : float
    Factor on the number of triangles.
near : float
    Distance of the near plane from the camera, m. The knot begins at 5.0 m in the picture.

The balls have the refractive indices 1.0, 1.3 and 1.5. The first is a tinted volume that does not
refract and casts an even shadow. The others focus light in the middle of their shadows, the more
the higher their index. The knot is a knotted ring of index 1.5, and light through it crosses
several walls. All four have the same tint. Pale tiles show how they bend the view, and are smooth
enough to show the caustics.
"""

from __future__ import annotations

import math

import numpy as np

from oitbench.modeling.detail import DETAIL, divisions
from oitbench.modeling.mesh import sphere
from oitbench.modeling.patterns import checkers
from oitbench.modeling.surroundings import gradient_sky
from oitbench.scene import (
    RGB,
    Camera,
    Floats,
    Material,
    Mesh,
    Object,
    Scene,
    SpotLight,
    Vector,
    unit,
)

subject = "glass"
quick = False
near = 4.2
crops = {
    "caustics": (0.24, 0.48, 0.48, 0.26),
    "index_10": (0.0, 0.34, 0.25, 0.38),
    "index_13": (0.25, 0.34, 0.25, 0.38),
    "index_15": (0.5, 0.34, 0.25, 0.38),
    "knot": (0.75, 0.34, 0.25, 0.38),
}
parameters = {
    "detail": DETAIL,
}

TINT: RGB = (0.90, 0.82, 0.68)  # transmission of one wall
RADIUS = 0.42
# Tiles of the floor: rows and columns of 0.3 m, and their albedo.
TILES, TILE = 100, 0.3
PALE, GRAY = 0.64, 0.42
HEIGHT = 0.70  # of the middles above the floor, meters
# Refractive index of each ball, and its x, meters.
BALLS = ((1.0, -1.65), (1.3, -0.55), (1.5, 0.55))
KNOT: Vector = (1.65, HEIGHT, 0.0)
# The knot winds around a ring. Radii of the ring, of the winding and of the strand, meters.
RING, WINDING, STRAND = 0.235, 0.105, 0.075
TURNS, WINDINGS = 2, 3
SURROUNDINGS = ((-90.0, (0.08, 0.08, 0.08)), (0.0, (0.20, 0.20, 0.21)), (90.0, (0.12, 0.14, 0.17)))


def build(*, name: str, detail: float) -> Scene:
    """Return the floor, the balls by ascending index, and the knot."""
    camera = Camera(position=(0.0, 4.8, 4.0), target=(0.1, 0.30, 0.0), fov_y=math.radians(44))
    half = TILES * TILE / 2
    pale, gray = checkers((0, 0, 0), (half, 0, 0), (0, 0, -half), TILES, TILES)
    objects = [
        Object("pale tiles", pale, Material(albedo=(PALE,) * 3, specular=0.0), casts=False),
        Object("gray tiles", gray, Material(albedo=(GRAY,) * 3, specular=0.0), casts=False),
    ]
    slices = divisions(96, detail, 12)
    for index, x in BALLS:
        ball = sphere((x, HEIGHT, 0.0), RADIUS, slices, slices // 2)
        objects.append(Object(f"ball of index {index}", ball, _glass(index)))
    objects.append(Object("knot of index 1.5", _knot(detail), _glass(1.5)))
    spot = SpotLight(
        position=(-0.7, 5.5, -2.6),
        target=(0.1, 0.0, -0.9),
        intensity=(105.0, 102.0, 97.0),
        angle=math.radians(84),
    )
    return Scene(
        name, camera, tuple(objects), lights=(spot, gradient_sky(SURROUNDINGS)), full_samples=16
    )


def _glass(index: float) -> Material:
    """Return a tinted, clear solid of a refractive index."""
    return Material(transmission=TINT, index=index, roughness=0.0, solid=True)


def _knot(detail: float) -> Mesh:
    """Return a closed tube along a torus knot."""
    lengths, sides = divisions(240, detail, 48), divisions(20, detail, 6)
    along = np.arange(lengths) / lengths * 2 * math.pi
    center = _strand(along)
    tangent = unit(_strand(along + 1e-4) - _strand(along - 1e-4))
    # The direction away from the ring is never along the strand and is the same after one round.
    away = unit(center - _ring(along))
    side = np.cross(tangent, away)
    turn = (np.arange(sides) / sides * 2 * math.pi)[None, :, None]
    normals = np.cos(turn) * away[:, None] + np.sin(turn) * side[:, None]
    positions = np.asarray(KNOT) + center[:, None] + STRAND * normals
    row, column = np.meshgrid(np.arange(lengths), np.arange(sides), indexing="ij")
    next_row, next_column = (row + 1) % lengths, (column + 1) % sides
    corners = (
        row * sides + column,
        row * sides + next_column,
        next_row * sides + next_column,
        next_row * sides + column,
    )
    a, b, c, d = (corner.ravel() for corner in corners)
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return Mesh.from_arrays(positions.reshape(-1, 3), triangles, normals=normals.reshape(-1, 3))


def _strand(along: Floats) -> Floats:
    """Return points of the knot's center line about the origin, shape (n, 3)."""
    reach = RING + WINDING * np.cos(WINDINGS * along)
    return _tilted(reach, WINDING * np.sin(WINDINGS * along), TURNS * along)


def _ring(along: Floats) -> Floats:
    """Return the points of the ring that are nearest to those of the strand, shape (n, 3)."""
    return _tilted(np.full_like(along, RING), np.zeros_like(along), TURNS * along)


def _tilted(reach: Floats, height: Floats, angle: Floats) -> Floats:
    """Return points given in cylindrical coordinates, tilted towards the viewer, shape (n, 3)."""
    tilt = math.radians(50)
    x, y, z = reach * np.cos(angle), height, reach * np.sin(angle)
    turned = [x, math.cos(tilt) * y - math.sin(tilt) * z, math.sin(tilt) * y + math.cos(tilt) * z]
    return np.stack(turned, axis=1)
