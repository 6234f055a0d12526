"""A hall with tall windows, through which the low sun casts shafts of light into fog.

Arranged as figure 14 of McGuire & Mara 2017, "Phenomenological Transparency".

Parameters
----------
detail : float
    Factor on the number of triangles.
extinction : float
    Extinction coefficient of the fog where its density is one, m⁻¹.
near : float
    Distance of the near plane from the camera, m. The fog begins at the camera.

The density of the fog is a grid of values, higher near the floor and in slow waves. The fog
scatters forward, towards the camera. Piers and window bars cut the light into shafts. Stained glass
in one window colors its shaft and its patch of light on the floor. A statue on a pedestal stands
half in the light and shadows the fog behind it.
"""

from __future__ import annotations

import math

import numpy as np

from oitbench.modeling.detail import DETAIL, divisions
from oitbench.modeling.mesh import grid, slab
from oitbench.modeling.placement import merge, repeated, rotation, transform, translation
from oitbench.modeling.props.architecture import column, window_wall
from oitbench.modeling.props.people import woman
from oitbench.parameters import Parameter
from oitbench.scene import (
    RGB,
    Camera,
    DirectionalLight,
    EnvironmentLight,
    Floats,
    Material,
    Medium,
    Mesh,
    Object,
    Scene,
    Vector,
    sample_density,
)

subject = "fog"
quick = False
near = 0.1
parameters = {
    "detail": DETAIL,
    "extinction": Parameter(
        0.15, low=0.0, high=10.0, help="extinction coefficient at density 1, 1/m"
    ),
}

# Meters. The hall reaches from z = NEAR to FAR. Its windows are at x = HALF and at z = FAR.
HALF, HEIGHT, NEAR, BAY, BAYS = 4.0, 6.2, 3.0, 3.0, 5
FAR = NEAR - BAY * BAYS
WALL = 0.5
OPENING, SILL, SPRING = 1.3, 1.1, 4.3
END_WINDOWS = (-HALF / 2, HALF / 2)
BAR = 0.05
STAINED_BAY = 2
# Transmission, and height of the lower and of the upper edge.
PANES: dict[str, tuple[RGB, float, float]] = {
    "blue glass": ((0.02, 0.14, 0.92), 1.1, 2.35),
    "gold glass": ((0.95, 0.52, 0.02), 2.35, 3.6),
    "red glass": ((0.92, 0.02, 0.02), 3.6, 4.95),
}
SUN = DirectionalLight(direction=(-0.68, -0.46, 0.55), irradiance=(20.0, 17.4, 13.5))
SKY: RGB = (0.018, 0.022, 0.030)
# Radiance that arrives in the fog from walls and other fog: the mean of a path-traced picture.
AROUND: RGB = (0.045, 0.022, 0.014)
STATUE: Vector = (0.6, 0.0, -4.8)
PEDESTAL = 0.6
COLUMNS = ((-2.6, -4.5), (-2.6, -7.5), (-2.6, -10.5))  # x and z

STONE = Material(albedo=(0.48, 0.45, 0.40))
PAVING = Material(albedo=(0.36, 0.33, 0.30))
MARBLE = Material(albedo=(0.78, 0.76, 0.72))
LEAD = Material(albedo=(0.05, 0.05, 0.06))


def build(*, name: str, detail: float, extinction: float) -> Scene:
    """Return the hall with its furniture and stained glass, in the fog."""
    # The box ends inside the walls, so that no surface coincides with its faces.
    low, high = (-HALF - 0.1, -0.1, FAR - 0.1), (HALF + 0.1, HEIGHT + 0.1, NEAR + 0.1)
    fog = Medium(
        extinction=extinction,
        low=low,
        high=high,
        albedo=(0.92, 0.92, 0.92),
        anisotropy=0.5,
        ambient=AROUND,
        density=sample_density(_density, low, high, (32, 24, 60)),
    )
    return Scene(
        name=name,
        camera=Camera(position=(-1.7, 1.7, 2.4), target=(0.5, 2.35, -7.0), fov_y=math.radians(56)),
        objects=(*_hall(detail), *_furniture(detail), *_stained_glass()),
        lights=(SUN, EnvironmentLight(SKY)),
        exposure=1.0,
        medium=fog,
        full_samples=512,
    )


def _density(points: Floats) -> Floats:
    """Return a density that falls with height and varies in slow waves."""
    x, y, z = np.moveaxis(points, -1, 0)
    waves = np.sin(0.8 * x + 0.5 * z) * np.cos(0.6 * z - 0.4 * x + 0.9 * y)
    return np.asarray((0.35 + 0.45 * np.exp(-np.maximum(y, 0) / 1.6)) * (1 + 0.25 * waves))


def _hall(detail: float) -> tuple[Object, ...]:
    """Return the floor, the walls and the roof, of which those that block the sun cast shadows."""
    middle, half = (NEAR + FAR) / 2, (NEAR - FAR) / 2
    cells = divisions(12, detail)
    floor = grid((0, 0, middle), (HALF, 0, 0), (0, 0, -half), cells, cells)
    blind = grid((-HALF, HEIGHT / 2, middle), (0, 0, -half), (0, HEIGHT / 2, 0), cells, cells)
    segments = divisions(24, detail, 6)
    bay = window_wall(BAY, HEIGHT, WALL, OPENING, SILL, SPRING, segments)
    turned = transform(bay, rotation((0, 1, 0), -math.pi / 2))
    places: list[Vector] = [(HALF + WALL / 2, 0, z) for z in _bays()]
    end = window_wall(HALF, HEIGHT, WALL, OPENING, SILL, SPRING, segments)
    ends: list[Vector] = [(x, 0, FAR - WALL / 2) for x in END_WINDOWS]
    corner = slab((HALF, 0, FAR - WALL), (HALF + WALL, HEIGHT, FAR))
    roof = slab((-HALF, HEIGHT, FAR - WALL), (HALF + WALL, HEIGHT + 0.3, NEAR + WALL))
    return (
        Object("floor", floor, PAVING, casts=False),
        Object("blind wall", blind, STONE, casts=False),
        Object("window wall", repeated(turned, places), STONE),
        Object("end wall", merge([repeated(end, ends), corner]), STONE),
        Object("window bars", _bars(), LEAD),
        Object("roof", roof, STONE),
    )


def _bays() -> list[float]:
    """Return the z of the middle of each side window, from the far end."""
    return [FAR + BAY * (index + 0.5) for index in range(BAYS)]


def _bars() -> Mesh:
    """Return an upright bar in each window, and three cross bars in each side window."""
    x, top = HALF + WALL / 2, SPRING + OPENING / 2
    parts = []
    for z in _bays():
        parts.append(slab((x - BAR, SILL, z - BAR), (x + BAR, top, z + BAR)))
        for height in (2.35, 3.6, 4.3):
            low = (x - 0.8 * BAR, height - BAR, z - OPENING / 2)
            parts.append(slab(low, (x + 0.8 * BAR, height + BAR, z + OPENING / 2)))
    z = FAR - WALL / 2
    for x in END_WINDOWS:
        parts.append(slab((x - BAR, SILL, z - BAR), (x + BAR, top, z + BAR)))
    return merge(parts)


def _furniture(detail: float) -> tuple[Object, ...]:
    """Return a row of columns in front of the blind wall, and a statue on a pedestal."""
    stand = [(x, 0.0, z) for x, z in COLUMNS]
    x, y, z = STATUE
    turn = rotation((0, 1, 0), math.radians(35))
    statue = transform(woman(detail).whole(), translation((x, y + PEDESTAL, z)) @ turn)
    pedestal = merge(
        [
            slab((x - 0.42, 0, z - 0.42), (x + 0.42, 0.12, z + 0.42)),
            slab((x - 0.33, 0.12, z - 0.33), (x + 0.33, PEDESTAL + 0.06, z + 0.33)),
        ]
    )
    return (
        Object("columns", repeated(column(HEIGHT, 0.28, detail), stand), STONE),
        Object("statue", statue, MARBLE),
        Object("pedestal", pedestal, STONE),
    )


def _stained_glass() -> tuple[Object, ...]:
    """Return thin panes of three colors, one above the other, in one window."""
    x, z = HALF + WALL / 2 + 0.01, _bays()[STAINED_BAY]
    return tuple(
        Object(
            color,
            grid((x, (low + high) / 2, z), (0, 0, OPENING / 2), (0, (high - low) / 2, 0)),
            Material(transmission=transmission),
        )
        for color, (transmission, low, high) in PANES.items()
    )
