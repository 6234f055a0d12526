"""A game of chess between red and clear glass men on a garden set, its king 0.9 m tall.

Subject of figure 19 of McGuire & Mara 2017, "Phenomenological Transparency".

Parameters
----------
detail : float
    Factor on the number of triangles.

The men of one color are one object, and men of both colors stand in front of and behind each other
all over the board: no order of the two objects is right. Each man is a solid that refracts light
and casts a colored shadow.
"""

from __future__ import annotations

import math

from oitbench.modeling.detail import DETAIL
from oitbench.modeling.mesh import box, grid
from oitbench.modeling.patterns import checkers
from oitbench.modeling.placement import merge, rotation, transform, translation
from oitbench.modeling.props.chessmen import piece
from oitbench.modeling.surroundings import Window, room
from oitbench.scene import (
    RGB,
    Camera,
    DirectionalLight,
    EnvironmentLight,
    Material,
    Mesh,
    Object,
    Scene,
    Vector,
)

KING_HEIGHT, SQUARE = 0.9, 0.48
GROUND_REACH = 60.0
"""Meters from the middle of the board to the sides of the ground, which are out of view."""
GAP = 0.001
"""Meters between the board and its men: coincident surfaces have no right picture."""
# The men of each color by their squares, in the order of submission.
POSITIONS: dict[str, dict[str, str]] = {
    "clear": {
        "g1": "king",
        "d3": "queen",
        "e1": "rook",
        "c4": "bishop",
        "f3": "knight",
        "e4": "pawn",
        "g2": "pawn",
        "b2": "pawn",
    },
    "red": {
        "g8": "king",
        "d6": "queen",
        "b4": "rook",
        "e6": "bishop",
        "c6": "knight",
        "e5": "pawn",
        "g7": "pawn",
        "g4": "bishop",
    },
}
# Transmission of one surface; light crosses at least two of them.
GLASS: dict[str, RGB] = {"clear": (0.90, 0.96, 0.93), "red": (0.92, 0.24, 0.22)}
INDEX = 1.5
IVORY = Material(albedo=(0.70, 0.64, 0.53), specular=0.0)
WALNUT = Material(albedo=(0.24, 0.14, 0.08), specular=0.0)
RIM = Material(albedo=(0.12, 0.07, 0.04), specular=0.0)
GROUND = Material(albedo=(0.42, 0.44, 0.42), specular=0.0)

quick = False
parameters = {
    "detail": DETAIL,
}


def build(*, name: str, detail: float) -> Scene:
    """Return the board on the ground, and one glass object for each color."""
    men = [
        Object(
            f"{color} men",
            _men(color, detail),
            Material(transmission=GLASS[color], index=INDEX, roughness=0.0, solid=True),
        )
        for color in POSITIONS
    ]
    return Scene(
        name=name,
        camera=Camera(position=(1.35, 2.0, 4.6), target=(0.08, 0.2, 0.25), fov_y=math.radians(35)),
        objects=(*_board(), *men),
        lights=(
            DirectionalLight(direction=(0.55, -1.0, 0.5), irradiance=(2.2, 2.1, 1.9)),
            _room(),
        ),
    )


def _men(color: str, detail: float) -> Mesh:
    """Return all men of one color. Clear men look away from the viewer, red men towards."""
    ahead = math.pi / 2 if color == "clear" else -math.pi / 2
    models: dict[str, Mesh] = {}
    placed = []
    for square, kind in POSITIONS[color].items():
        if kind not in models:
            turned = rotation((0, 1, 0), ahead - 0.5)
            models[kind] = transform(piece(kind, KING_HEIGHT, detail), turned)
        placed.append(transform(models[kind], translation(_middle(square))))
    return merge(placed)


def _middle(square: str) -> Vector:
    """Return the foot of a man on a square such as "e4"; the first rank is nearest."""
    column, row = "abcdefgh".index(square[0]), int(square[1]) - 1
    return (SQUARE * (column - 3.5), GAP, SQUARE * (3.5 - row))


def _board() -> list[Object]:
    """Return the squares, the slightly lower rim around them, and the ground."""
    half = 4 * SQUARE
    dark, light = checkers((0, 0, 0), (half, 0, 0), (0, 0, -half), 8, 8)
    width, thick = 2 * half + 0.3, 0.08
    rim = box((0, -thick / 2 - GAP, 0), (width, thick, width))
    ground = grid((0, -thick - 2 * GAP, 0), (GROUND_REACH, 0, 0), (0, 0, -GROUND_REACH))
    return [
        Object("dark squares", dark, WALNUT, casts=False),
        Object("light squares", light, IVORY, casts=False),
        Object("rim", rim, RIM),
        Object("ground", ground, GROUND, casts=False),
    ]


def _room() -> EnvironmentLight:
    """Return a bright room with tall windows ahead on the left and one behind on the right."""
    bright = (3.4, 3.5, 3.7)
    windows = (
        Window(azimuth=-0.9, elevation=0.3, width=0.4, height=0.8, radiance=bright),
        Window(azimuth=-0.35, elevation=0.3, width=0.4, height=0.8, radiance=bright),
        Window(azimuth=2.2, elevation=0.4, width=0.8, height=0.6, radiance=(2.0, 1.9, 1.8)),
    )
    return room((0.55, 0.56, 0.58), (0.42, 0.41, 0.40), (0.15, 0.13, 0.11), windows)
