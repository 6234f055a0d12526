"""A court between two stories of arcades, in uniform fog under uniform ambient light.

Arranged as figure 13 of McGuire & Mara 2017, "Phenomenological Transparency".

Parameters
----------
detail : float
    Factor on the number of triangles.
extinction : float
    Extinction coefficient σ of the fog, m⁻¹.
near : float
    Distance of the near plane from the camera, m. The fog begins at the camera.

Surfaces glow as they would under an overcast sky, about as brightly as the sky itself. The fog
scatters equally to all sides, and its ambient radiance is the mean of what it receives from the
sky, the walls and the floor in a path-traced picture. Its effect then has a closed form: at
distance s, a surface of radiance C₀ appears as

    C₀ e^(−σs) + L (1 − e^(−σs)),

where L is the albedo of the fog times its ambient radiance. Banners of the same paints hang at
several distances for comparison.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from oitbench.modeling.baking import normals_of, with_radiance
from oitbench.modeling.detail import DETAIL, divisions
from oitbench.modeling.mesh import grid, lathe, slab
from oitbench.modeling.placement import merge, repeated, rotation, transform
from oitbench.modeling.profiles import smooth_curve
from oitbench.modeling.props.architecture import arch, column
from oitbench.parameters import Parameter
from oitbench.scene import (
    RGB,
    Camera,
    EnvironmentLight,
    Material,
    Medium,
    Mesh,
    Object,
    Scene,
    Vector,
)

subject = "fog"
quick = False
near = 0.1
parameters = {
    "detail": DETAIL,
    "extinction": Parameter(
        0.035, low=0.0, high=10.0, help="extinction coefficient of the fog, 1/m"
    ),
}

# Meters. The court lies along −z, between arcades whose columns stand at x = ±COURT.
COURT, AISLE, NEAR, BAY, BAYS = 4.2, 7.2, 2.0, 3.0, 8
FAR = NEAR - BAY * BAYS
SHAFT, LOWER, WALL = 0.30, 3.3, 0.7
UPPER_FLOOR, UPPER, TOP = 5.4, 2.1, 9.0
RAIL_HEIGHT = 0.95
BANNER_WIDTH, BANNER_TOP, BANNER_LENGTH = 0.62, 5.2, 2.6
FIRST_BANNER = 2  # the first pier from the camera that has banners
TILE = 1.2

AMBIENT: RGB = (0.46, 0.49, 0.54)
LIGHT: RGB = (1.0, 0.99, 0.97)  # radiance of a white surface that faces up
FOG_ALBEDO: RGB = (0.62, 0.62, 0.62)
# Radiance that arrives in the fog: half from the sky and half from the brown walls and the floor.
AROUND: RGB = (0.355, 0.321, 0.300)
# Radiance of a white surface that faces up, sideways and down, as fractions of LIGHT.
FACING_UP, FACING_ASIDE, FACING_DOWN = 1.0, 0.8, 0.55
SANDSTONE = Material(emission=(0.56, 0.46, 0.34))
MARBLE = Material(emission=(0.64, 0.60, 0.54))
PLASTER = Material(emission=(0.40, 0.24, 0.17))
LIGHT_TILES = Material(emission=(0.52, 0.48, 0.42))
DARK_TILES = Material(emission=(0.10, 0.10, 0.12))
WHITE_CLOTH = Material(emission=(0.86, 0.84, 0.78))
CLOTHS: dict[str, RGB] = {
    "red": (0.62, 0.04, 0.04),
    "blue": (0.04, 0.10, 0.48),
    "green": (0.03, 0.30, 0.09),
}


def build(*, name: str, detail: float, extinction: float) -> Scene:
    """Return the court with its banners, in the fog."""
    fog = Medium(
        extinction=extinction,
        low=(-AISLE - 0.2, -0.2, FAR - 0.2),
        high=(AISLE + 0.2, TOP + 0.6, NEAR + 0.8),
        albedo=FOG_ALBEDO,
        ambient=AROUND,
    )
    return Scene(
        name=name,
        camera=Camera(
            position=(0.9, 1.75, 1.6), target=(-0.25, 3.35, -10.0), fov_y=math.radians(58)
        ),
        objects=tuple(map(_glowing, (*_floors(), *_arcades(detail), *_banners(detail)))),
        lights=(EnvironmentLight(AMBIENT),),
        medium=fog,
        full_samples=24,
    )


def _glowing(item: Object) -> Object:
    """Return the object as lit by an overcast sky: brighter where it faces up."""
    upward = normals_of(item.mesh)[:, 1:2]
    shade = np.interp(upward, [-1, 0, 1], [FACING_DOWN, FACING_ASIDE, FACING_UP])
    return replace(item, mesh=with_radiance(item.mesh, shade * np.asarray(LIGHT)))


def _floors() -> tuple[Object, ...]:
    """Return a floor with tiles of two shades, and the walls behind the arcades."""
    tiles: tuple[list[Mesh], list[Mesh]] = ([], [])
    columns, rows = round(2 * AISLE / TILE), round((NEAR + 1 - FAR) / TILE)
    for place in range(columns):
        for row in range(rows):
            x, z = -AISLE + TILE * (place + 0.5), NEAR + 1 - TILE * (row + 0.5)
            tile = grid((x, 0, z), (TILE / 2, 0, 0), (0, 0, -TILE / 2))
            tiles[(place + row) % 2].append(tile)
    middle, half = (NEAR + 1 + FAR) / 2, (NEAR + 1 - FAR) / 2
    walls = [
        grid((side * AISLE, TOP / 2, middle), (0, 0, half * side), (0, TOP / 2, 0))
        for side in (-1, 1)
    ]
    walls.append(grid((0, TOP / 2, FAR), (AISLE, 0, 0), (0, TOP / 2, 0)))
    return (
        Object("light tiles", merge(tiles[0]), LIGHT_TILES),
        Object("dark tiles", merge(tiles[1]), DARK_TILES),
        Object("outer walls", merge(walls), PLASTER),
    )


def _arcades(detail: float) -> tuple[Object, ...]:
    """Return columns, arches, floors and railings of both stories, on both sides and at the end."""
    lower = column(LOWER, SHAFT, detail)
    upper = column(UPPER, 0.6 * SHAFT, 0.35 * detail)
    segments = divisions(18, detail, 6)
    low_arch = arch(BAY, BAY - 2.6 * SHAFT, UPPER_FLOOR - 0.3 - LOWER, WALL, segments)
    half = BAY / 2
    high_arch = arch(half, half - 0.42, TOP - 0.35 - UPPER_FLOOR - UPPER, 0.5 * WALL, segments)
    ends = [NEAR - BAY * index for index in range(BAYS + 1)]
    mids = [NEAR - half * (index + 0.5) for index in range(2 * BAYS)]
    halves = [NEAR - half * index for index in range(2 * BAYS + 1)]
    columns, arches = [], []
    for side in (-1, 1):
        x = side * COURT
        columns += [
            repeated(lower, [(x, 0, z) for z in ends]),
            repeated(upper, [(x, UPPER_FLOOR, z) for z in halves]),
        ]
        turn = rotation((0, 1, 0), math.pi / 2)
        arches += [
            repeated(transform(low_arch, turn), [(x, LOWER, z - half) for z in ends[:-1]]),
            repeated(transform(high_arch, turn), [(x, UPPER_FLOOR + UPPER, z) for z in mids]),
        ]
    return (
        Object("columns", merge(columns), MARBLE),
        Object("arches", merge(arches), SANDSTONE),
        Object("floors and cornices", _ledges(), SANDSTONE),
        Object("railings", _railings(detail), MARBLE),
    )


def _ledges() -> Mesh:
    """Return the upper floors with their edges, the cornices and the roofs of the galleries."""
    parts = []
    for side in (-1, 1):
        inner, outer = sorted((side * (COURT - WALL / 2 - 0.12), side * AISLE))
        parts.append(slab((inner, UPPER_FLOOR - 0.3, FAR), (outer, UPPER_FLOOR, NEAR + 1)))
        inner, outer = sorted((side * (COURT - WALL / 2 - 0.15), side * AISLE))
        parts.append(slab((inner, TOP - 0.35, FAR), (outer, TOP + 0.05, NEAR + 1)))
    # The far end has two ledges and the frame of a doorway.
    parts += [
        slab((-COURT, UPPER_FLOOR - 0.3, FAR), (COURT, UPPER_FLOOR, FAR + 0.5)),
        slab((-COURT, TOP - 0.35, FAR), (COURT, TOP + 0.05, FAR + 0.4)),
        slab((-1.5, 0, FAR), (-1.1, 3.4, FAR + 0.3)),
        slab((1.1, 0, FAR), (1.5, 3.4, FAR + 0.3)),
        slab((-1.7, 3.4, FAR), (1.7, 3.8, FAR + 0.4)),
    ]
    return merge(parts)


def _railings(detail: float) -> Mesh:
    """Return the balustrades of the upper story."""
    outline = [(0.05, 0.0), (0.05, 0.1), (0.085, 0.28), (0.035, 0.6), (0.05, RAIL_HEIGHT - 0.1)]
    profile = smooth_curve(outline, divisions(8, detail, 4))
    baluster = lathe(profile, divisions(6, detail, 4))
    count = divisions(5, detail, 2) * 2 * BAYS
    pitch = BAY * BAYS / count
    parts = []
    for side in (-1, 1):
        x = side * COURT
        places: list[Vector] = [(x, UPPER_FLOOR, NEAR - pitch * (i + 0.5)) for i in range(count)]
        parts.append(repeated(baluster, places))
        height = UPPER_FLOOR + RAIL_HEIGHT
        parts.append(slab((x - 0.09, height - 0.12, FAR), (x + 0.09, height, NEAR)))
    return merge(parts)


def _banners(detail: float) -> tuple[Object, ...]:
    """Return banners at each pier, in three paints in turn, with two white stripes each."""
    cloths: dict[str, list[Mesh]] = {paint: [] for paint in CLOTHS}
    stripes = []
    rows = divisions(10, detail, 3)
    for index in range(FIRST_BANNER, BAYS):
        z = NEAR - BAY * index
        for side in (-1, 1):
            paint = list(CLOTHS)[(index + (side > 0)) % len(CLOTHS)]
            x = side * (COURT - WALL / 2 - 0.16 - BANNER_WIDTH)
            middle = BANNER_TOP - BANNER_LENGTH / 2
            cloth = grid((x, middle, z), (BANNER_WIDTH, 0, 0), (0, BANNER_LENGTH / 2, 0), 2, rows)
            cloths[paint].append(cloth)
            for height in (BANNER_TOP - 0.45, middle - 0.75):
                stripes.append(grid((x, height, z + 0.012), (BANNER_WIDTH, 0, 0), (0, 0.14, 0)))
    objects = [
        Object(f"{paint} banners", merge(meshes), Material(emission=CLOTHS[paint]))
        for paint, meshes in cloths.items()
        if meshes
    ]
    return (*objects, Object("stripes", merge(stripes), WHITE_CLOTH))
