"""Five teapots behind five panes of glass that blur more and more from left to right.

Arranged as figure 8 of McGuire & Mara 2017, "Phenomenological Transparency".

Parameters
----------
detail : float
    Factor on the number of triangles.
distance : float
    Distance from each pane back to the axis of its teapot, meters.
near : float
    Distance of the near plane from the camera, m. The floor begins at 1.7 m in the picture, and the
    panes stand at 3 m.

The panes are thin sheets whose collimation falls from left to right. All teapots are alike and
equally far behind their panes, and go from sharp to blurred. A checkered box touches the back of
each pane and stays sharp, since light spreads only over the distance between the glass and the
background. The tiles of the floor and the stripes of the wall show that the blur grows with that
distance.
"""

from __future__ import annotations

import math

from oitbench.modeling.detail import DETAIL, divisions
from oitbench.modeling.mesh import box, grid
from oitbench.modeling.patterns import checkered_box, checkers
from oitbench.modeling.placement import rotation, transform, translation
from oitbench.modeling.props.teapot import teapot
from oitbench.modeling.surroundings import room
from oitbench.parameters import Parameter
from oitbench.scene import RGB, Camera, DirectionalLight, Material, Object, Scene

COLLIMATIONS = (1.0, 0.9, 0.75, 0.5, 0.25)
PITCH, WIDTH, HEIGHT = 0.34, 0.315, 0.78
TEAPOT_HEIGHT, TEAPOT_TURN = 0.26, math.radians(-56)
SPREAD = 1.1
"""Pitch of the teapots over that of the panes: each is seen in the middle of its pane."""
BOX, RAIL = 0.12, 0.02
"""Edge lengths of the boxes and of the cross section of the rail, meters."""
SQUARES = 2
GAP = 0.001
"""Meters between surfaces that seem to touch: coincident ones have no right picture."""
TILE, WALL = 0.16, -1.28
"""Edge length of a tile of the floor, and z of the back wall, meters."""
GLASS: RGB = (0.92, 0.92, 0.92)

CLAY = Material(albedo=(0.62, 0.20, 0.09), specular=0.05, roughness=0.35)
LIGHT_PAINT = Material(albedo=(0.80, 0.79, 0.75), specular=0.0)
DARK_PAINT = Material(albedo=(0.05, 0.09, 0.20), specular=0.0)
PALE_TILE = Material(albedo=(0.66, 0.65, 0.62), specular=0.0)
GRAY_TILE = Material(albedo=(0.42, 0.43, 0.44), specular=0.0)
PALE_PAPER = Material(albedo=(0.66, 0.68, 0.70), specular=0.0)
BLUE_PAPER = Material(albedo=(0.30, 0.43, 0.52), specular=0.0)
STEEL = Material(albedo=(0.10, 0.10, 0.11), specular=0.3, roughness=0.5)

subject = "frosted glass"
near = 1.55
crops = {
    "nearest_pot": (0.03, 0.5, 0.22, 0.22),
    "farthest_pot": (0.76, 0.5, 0.22, 0.22),
    "nearest_lid": (0.05, 0.54, 0.17, 0.09),
    "farthest_lid": (0.8, 0.54, 0.16, 0.09),
    "first_box": (0.04, 0.64, 0.08, 0.08),
    "second_box": (0.225, 0.64, 0.08, 0.08),
    "last_box": (0.79, 0.64, 0.08, 0.08),
    "panes": (0.0, 0.3, 1.0, 0.5),
}
parameters = {
    "detail": DETAIL,
    "distance": Parameter(
        0.38, low=0.3, high=1.0, help="meters from each pane back to the axis of its teapot"
    ),
}


def build(*, name: str, detail: float, distance: float) -> Scene:
    """Return the row of panes and teapots. Floor and wall cast no shadow, all other objects do.

    The surroundings are dim, because floor and wall hide half of them from each other.
    """
    objects = _stage()
    pot = transform(teapot(TEAPOT_HEIGHT, detail), rotation((0, 1, 0), TEAPOT_TURN))
    cells = (divisions(8, detail, 2), divisions(16, detail, 2))
    for number, collimation in enumerate(COLLIMATIONS):
        x = PITCH * (number - (len(COLLIMATIONS) - 1) / 2)
        place = translation((SPREAD * x + 0.012, GAP, -distance))
        objects.append(Object(f"teapot {number}", transform(pot, place), CLAY))
        corner = (x - WIDTH / 2 + 0.6 * BOX, BOX / 2 + GAP, -BOX / 2 - GAP)
        light, dark = checkered_box(corner, (BOX, BOX, BOX), SQUARES)
        objects.append(Object(f"light squares of box {number}", light, LIGHT_PAINT))
        objects.append(Object(f"dark squares of box {number}", dark, DARK_PAINT))
        sheet = grid((x, HEIGHT / 2 + GAP, 0), (WIDTH / 2, 0, 0), (0, HEIGHT / 2, 0), *cells)
        glass = Material(transmission=GLASS, specular=0.04, roughness=0.0, collimation=collimation)
        objects.append(Object(f"pane {number}", sheet, glass))
    return Scene(
        name=name,
        camera=Camera(position=(0, 0.66, 3.0), target=(0, 0.40, 0), fov_y=math.radians(33)),
        objects=tuple(objects),
        lights=(
            DirectionalLight(direction=(0.6, -0.85, -0.8), irradiance=(2.9, 2.8, 2.6)),
            room((0.24, 0.26, 0.30), (0.18, 0.19, 0.21), (0.10, 0.10, 0.10)),
        ),
        full_samples=16,
    )


def _stage() -> list[Object]:
    """Return the tiled floor, the striped wall, and the rail from which the panes hang."""
    columns, rows = 40, 24
    across, middle = (columns * TILE / 2, 0.0, 0.0), WALL + rows * TILE / 2
    pale, gray = checkers((0, 0, middle), across, (0, 0, -rows * TILE / 2), columns, rows)
    paper, stripes = checkers((0, 1.0, WALL), across, (0, 1.0, 0), columns // 2, 1)
    length = PITCH * len(COLLIMATIONS)
    rail = box((0, HEIGHT + 2 * GAP + RAIL / 2, 0), (length, RAIL, RAIL))
    return [
        Object("pale tiles", pale, PALE_TILE, casts=False),
        Object("gray tiles", gray, GRAY_TILE, casts=False),
        Object("pale paper", paper, PALE_PAPER, casts=False),
        Object("blue stripes", stripes, BLUE_PAPER, casts=False),
        Object("rail", rail, STEEL),
    ]
