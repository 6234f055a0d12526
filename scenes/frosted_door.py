"""A frosted glass door at night, two people in the corridor behind it and lettering in front.

Arranged as figures 1 (left) and 21a of McGuire & Mara 2017, "Phenomenological Transparency".

Parameters
----------
detail : float
    Factor on the number of triangles.
collimation : float
    Collimation of the pane, in [0, 1]; 1 for clear glass.
near : float
    Distance of the near plane from the camera, m. The frame of the door is 2.4 m away, and the pane
    2.5 m.

One pane spreads the light that passes it. Objects blur more the farther they are behind it: the
woman's hand almost touches the glass and stays sharp, while the man two meters behind it and the
window at the end of the corridor dissolve. The frame and the lettering are in front of the pane and
do not blur.
"""

from __future__ import annotations

import math
from dataclasses import replace

from oitbench.modeling.detail import DETAIL, divisions
from oitbench.modeling.mesh import grid, slab
from oitbench.modeling.placement import merge, repeated, rotation, translation
from oitbench.modeling.props.lettering import lettering
from oitbench.modeling.props.people import Figure, hand, limb, man, woman_without_arms
from oitbench.parameters import Parameter
from oitbench.scene import (
    RGB,
    Camera,
    EnvironmentLight,
    Material,
    Mesh,
    Object,
    Scene,
    SpotLight,
    Vector,
)

subject = "frosted glass"
quick = False
near = 2.2
crops = {
    "lettering": (0.25, 0.1, 0.5, 0.28),
    "frame": (0.0, 0.1, 0.05, 0.8),
    "woman": (0.64, 0.52, 0.08, 0.12),
    "man": (0.32, 0.52, 0.06, 0.12),
    "far_wall": (0.42, 0.44, 0.06, 0.08),
}
parameters = {
    "detail": DETAIL,
    "collimation": Parameter(
        0.85, low=0.0, high=1.0, help="collimation of the pane; 1 for clear glass"
    ),
}

PANE: tuple[float, float, float, float] = (-0.80, 0.62, 0.80, 2.14)
"""Left, lower, right and upper edge of the pane in the plane z = 0, meters."""
# Meters. The corridor behind the pane reaches to z = −DEPTH.
DEPTH, HALF_WIDTH, HEIGHT = 5.5, 1.5, 2.75
RAIL = 0.11
LETTER_GAP = 0.012
WOMAN: Vector = (0.34, 0.0, -0.40)
MAN: Vector = (-0.62, 0.0, -2.4)
PALM: Vector = (0.01, 1.40, -0.045)
WINDOW: Vector = (-0.15, 1.34, -DEPTH + 0.01)
WINDOW_SIZE = (0.62, 0.47)
BLINDS = 6
DUSK: RGB = (0.030, 0.034, 0.042)

GLASS = Material(transmission=(0.88, 0.88, 0.88), specular=0.04, roughness=0.0)
WALL = Material(albedo=(0.50, 0.48, 0.44))
PANELS = Material(albedo=(0.16, 0.10, 0.06))
OFFICE = Material(albedo=(0.11, 0.13, 0.13))
FLOOR = Material(albedo=(0.34, 0.29, 0.24))
WOOD = Material(albedo=(0.24, 0.12, 0.06))
GILT = Material(albedo=(0.86, 0.68, 0.30))
DRESS = Material(albedo=(0.45, 0.06, 0.07))
COAT = Material(albedo=(0.10, 0.11, 0.13))
STREET = Material(emission=(1.5, 1.15, 0.62))

# Its cone ends on the dark panels, so that no edge of light shows on the walls.
CORRIDOR_LAMP = SpotLight(
    position=(0.10, 2.68, -3.0),
    target=(0.0, 0.0, -2.7),
    intensity=(15.0, 13.2, 10.0),
    angle=math.radians(74),
)
# Stands for the light that floor and panels reflect, which falls on the walls and the ceiling.
FILL = SpotLight(
    position=(0.0, 0.10, -3.3),
    target=(0.0, 1.0, -3.3),
    intensity=(8.0, 6.6, 4.7),
    angle=math.radians(168),
)
DESK_LAMP = SpotLight(
    position=(-3.0, 1.2, 2.3),
    target=(0.15, 1.40, 0.0),
    intensity=(19.0, 18.0, 16.0),
    angle=math.radians(80),
)


def build(*, name: str, detail: float, collimation: float) -> Scene:
    """Return the corridor with the people, and the office in front of the door."""
    left, low, right, high = PANE
    middle = ((left + right) / 2, (low + high) / 2)
    pane = grid((*middle, 0), ((right - left) / 2, 0, 0), (0, (high - low) / 2, 0))
    objects = (
        *_corridor(detail),
        *man(detail).transformed(translation(MAN)).objects("man", COAT),
        *_woman(detail).objects("woman", DRESS),
        Object("pane", pane, replace(GLASS, collimation=collimation)),
        Object("office wall", _office_wall(detail), OFFICE),
        Object("frame", _frame(), WOOD),
        Object("lettering", _sign(), GILT),
    )
    return Scene(
        name=name,
        camera=Camera(position=(0.12, 1.42, 2.5), target=(0, 1.37, 0), fov_y=math.radians(40)),
        objects=objects,
        lights=(CORRIDOR_LAMP, FILL, DESK_LAMP, EnvironmentLight(DUSK)),
        full_samples=16,
    )


def _corridor(detail: float) -> tuple[Object, ...]:
    """Return the floor, walls with dark panels, and a lit window with blinds at the end."""
    cells = divisions(12, detail)
    middle, half = -DEPTH / 2, DEPTH / 2
    floor = grid((0, 0, middle), (HALF_WIDTH, 0, 0), (0, 0, -half), cells, cells)
    end = grid((0, HEIGHT / 2, -DEPTH), (HALF_WIDTH, 0, 0), (0, HEIGHT / 2, 0), cells, cells)
    sides = [
        grid(
            (HALF_WIDTH * side, HEIGHT / 2, middle),
            (0, 0, half * side),
            (0, HEIGHT / 2, 0),
            cells,
            cells,
        )
        for side in (-1, 1)
    ]
    x, y, z = WINDOW
    width, height = WINDOW_SIZE
    ceiling = grid((0, HEIGHT, middle), (HALF_WIDTH, 0, 0), (0, 0, half), cells, cells)
    window = grid(WINDOW, (width, 0, 0), (0, height, 0))
    slat = slab((x - width, y - height, z + 0.02), (x + width, y - height + 0.06, z + 0.025))
    pitch = 2 * height / BLINDS
    blinds = repeated(slat, [(0, pitch * (index + 0.4), 0) for index in range(BLINDS)])
    bars = [
        slab((x - 0.02, y - height, z + 0.03), (x + 0.02, y + height, z + 0.04)),
        slab((x - width, y - height - 0.07, z), (x + width, y - height, z + 0.08)),
        slab((x - width, y + height, z), (x + width, y + height + 0.07, z + 0.08)),
    ]
    panels = [
        slab((-HALF_WIDTH, 0, -DEPTH), (HALF_WIDTH, 0.85, -DEPTH + 0.02)),
        slab((-HALF_WIDTH, 0, -DEPTH), (-HALF_WIDTH + 0.02, 0.85, 0)),
        slab((HALF_WIDTH - 0.02, 0, -DEPTH), (HALF_WIDTH, 0.85, 0)),
    ]
    return (
        Object("corridor floor", floor, FLOOR, casts=False),
        Object("corridor walls", merge([*sides, end, ceiling]), WALL, casts=False),
        Object("panels", merge(panels), PANELS, casts=False),
        Object("far window", window, STREET, casts=False),
        Object("blinds", merge([blinds, *bars]), PANELS, casts=False),
    )


def _woman(detail: float) -> Figure:
    """Return the woman, turned sideways, with a hand close to the glass."""
    turned = translation(WOMAN) @ rotation((0, 1, 0), math.radians(-25))
    body = woman_without_arms(detail).transformed(turned)
    x, _, z = WOMAN
    shoulder, elbow = (x - 0.16, 1.38, z + 0.05), (x - 0.26, 1.17, z + 0.16)
    other, hip = (x + 0.15, 1.38, z - 0.05), (x + 0.27, 1.10, z - 0.02)
    arms = [
        limb(shoulder, elbow, 0.05, 0.036, detail),
        limb(elbow, PALM, 0.036, 0.026, detail),
        limb(other, hip, 0.05, 0.036, detail),
        limb(hip, (x + 0.14, 0.98, z + 0.08), 0.036, 0.028, detail),
        hand(PALM, detail),
    ]
    return Figure(body.clothes, merge([body.skin, *arms]), body.hair)


def _office_wall(detail: float) -> Mesh:
    """Return the wall around the door, on the camera's side."""
    left, low, right, high = PANE
    edge = (left - RAIL, low - RAIL, right + RAIL, high + RAIL)
    wide, tall, cells = 2.6, 3.2, divisions(6, detail)
    return merge(
        [
            slab((-wide, 0, -0.05), (edge[0], tall, 0.03), cells),
            slab((edge[2], 0, -0.05), (wide, tall, 0.03), cells),
            slab((edge[0], edge[3], -0.05), (edge[2], tall, 0.03), cells),
            slab((edge[0], 0, -0.05), (edge[2], edge[1], 0.03), cells),
        ]
    )


def _frame() -> Mesh:
    """Return the frame around the pane, a bar across it and a handle."""
    left, low, right, high = PANE
    bar = low + 0.26 * (high - low)
    return merge(
        [
            slab((left - RAIL, low - RAIL, -0.03), (left + 0.01, high + RAIL, 0.05)),
            slab((right - 0.01, low - RAIL, -0.03), (right + RAIL, high + RAIL, 0.05)),
            slab((left + 0.01, high - 0.01, -0.03), (right - 0.01, high + RAIL, 0.05)),
            slab((left + 0.01, low - RAIL, -0.03), (right - 0.01, low + 0.01, 0.05)),
            slab((left + 0.01, bar - 0.02, 0.004), (right - 0.01, bar + 0.02, 0.03)),
            limb((right + 0.05, 0.90, 0.09), (right + 0.05, 1.14, 0.09), 0.014, 0.014, 1.0),
        ]
    )


def _sign() -> Mesh:
    """Return two lines of lettering just in front of the pane."""
    return merge(
        [
            lettering("PRIVATE", (-0.02, 1.95, LETTER_GAP), 0.17, 0.03),
            lettering("EYE", (-0.02, 1.70, LETTER_GAP), 0.17, 0.03),
        ]
    )
