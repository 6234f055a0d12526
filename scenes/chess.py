"""A game of chess between red and clear glass men on a table in a furnished room.

Subject of figure 19 of McGuire & Mara 2017, "Phenomenological Transparency".

Parameters
----------
detail : float
    Factor on the number of triangles.
near : float
    Distance of the near plane from the camera, m. The table begins at 0.3 m in the picture.

The men of one color are one object, and men of both colors stand in front of and behind each other
all over the board: no order of the two objects is right. Each man is a solid that refracts light
and casts a colored shadow. A lamp behind the board on the left lights the table. Behind it are a
wall with two windows, a bookcase, a picture and a chair, which show in the glass upside down.

Lengths are in decimeters and as in life: the king is 9 cm tall.
"""

from __future__ import annotations

import math

from oitbench.modeling.detail import DETAIL
from oitbench.modeling.mesh import box, grid, slab
from oitbench.modeling.patterns import checkers
from oitbench.modeling.placement import merge, rotation, transform, translation
from oitbench.modeling.props.chessmen import piece
from oitbench.modeling.surroundings import Window, room
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

KING_HEIGHT, SQUARE = 0.9, 0.48
GAP = 0.005
"""Decimeters between the board and its men: coincident surfaces have no right picture."""
BOARD = 0.08  # thickness
# Decimeters from the middle of the board.
TABLE_FRONT, TABLE_BACK, TABLE_SIDE, TABLE_TOP = 7.0, -4.5, 9.0, -0.1
FLOOR, CEILING, WALL, SIDE = -7.6, 18.0, -24.0, 22.0
# Left, lower, right and upper edge of each window.
WINDOWS = ((-13.0, -1.0, -6.5, 12.0), (-4.0, -1.0, 2.5, 12.0))
PICTURE = (6.6, 3.6, 10.6, 6.6)
SHELVES = 5
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
GLASS: dict[str, RGB] = {"clear": (0.92, 0.92, 0.92), "red": (0.92, 0.24, 0.22)}
INDEX = 1.5
IVORY = Material(albedo=(0.70, 0.64, 0.53), specular=0.0)
WALNUT = Material(albedo=(0.24, 0.14, 0.08), specular=0.0)
RIM = Material(albedo=(0.12, 0.07, 0.04), specular=0.0)
TABLE = Material(albedo=(0.30, 0.17, 0.09), specular=0.0)
WALLPAPER = Material(albedo=(0.42, 0.50, 0.46), specular=0.0)
PANELING = Material(albedo=(0.66, 0.64, 0.58), specular=0.0)
OAK = Material(albedo=(0.34, 0.20, 0.10), specular=0.0)
DAYLIGHT = Material(emission=(0.70, 0.86, 1.0))
LINEN = Material(albedo=(0.72, 0.60, 0.42), specular=0.0)
# Paints of the spines of books.
BOOKS: tuple[RGB, ...] = ((0.42, 0.08, 0.06), (0.08, 0.16, 0.32), (0.46, 0.34, 0.12))

subject = "glass"
quick = False
near = 0.27
crops = {
    "red_pieces": (0.44, 0.32, 0.44, 0.28),
    "red_men@left": (0.66, 0.3, 0.32, 0.36),
    "red_men@right": (0.62, 0.3, 0.32, 0.36),
}
parameters = {
    "detail": DETAIL,
}

LAMP = SpotLight(
    position=(-4.6, 8.0, -4.2),
    target=(0.0, 0.0, 0.2),
    intensity=(3.5, 3.25, 2.8),
    angle=math.radians(46),
)


def build(*, name: str, detail: float) -> Scene:
    """Return the room, the board on the table, and one glass object for each color."""
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
        camera=Camera(position=(1.0, 1.95, 4.9), target=(0.0, 0.42, 0.0), fov_y=math.radians(41)),
        objects=(*_room(), *_board(), *men),
        lights=(LAMP, _daylight()),
        meters_per_unit=0.1,
        full_samples=96,
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
    """Return the squares, the slightly lower rim around them, and the table."""
    half = 4 * SQUARE
    dark, light = checkers((0, 0, 0), (half, 0, 0), (0, 0, -half), 8, 8)
    width = 2 * half + 0.3
    rim = box((0, -BOARD / 2 - GAP, 0), (width, BOARD, width))
    middle, depth = (TABLE_FRONT + TABLE_BACK) / 2, (TABLE_FRONT - TABLE_BACK) / 2
    table = grid((0, TABLE_TOP, middle), (TABLE_SIDE, 0, 0), (0, 0, -depth))
    return [
        Object("dark squares", dark, WALNUT, casts=False),
        Object("light squares", light, IVORY, casts=False),
        Object("rim", rim, RIM),
        Object("table", table, TABLE, casts=False),
    ]


def _room() -> list[Object]:
    """Return the walls with windows, a bookcase with books, a picture and a chair."""
    height, level = (CEILING - FLOOR) / 2, (CEILING + FLOOR) / 2
    walls = [grid((0, level, WALL), (SIDE, 0, 0), (0, height, 0))]
    for side in (-1, 1):
        walls.append(grid((side * SIDE, level, 0), (0, 0, -side * WALL), (0, height, 0)))
    floor = grid((0, FLOOR, 0), (SIDE, 0, 0), (0, 0, WALL))
    glass, frames = [], []
    for left, low, right, high in WINDOWS:
        x, y = (left + right) / 2, (low + high) / 2
        glass.append(grid((x, y, WALL + 0.1), ((right - left) / 2, 0, 0), (0, (high - low) / 2, 0)))
        frames += _frame(left, low, right, high, 0.5)
        frames.append(slab((x - 0.15, low, WALL + 0.15), (x + 0.15, high, WALL + 0.4)))
        for part in (1, 2, 3):
            bar = low + part * (high - low) / 4
            frames.append(slab((left, bar - 0.12, WALL + 0.15), (right, bar + 0.12, WALL + 0.35)))
    frames.append(slab((-SIDE, -3.4, WALL + 0.05), (SIDE, -2.9, WALL + 0.3)))
    left, low, right, high = PICTURE
    canvas = grid(
        ((left + right) / 2, (low + high) / 2, WALL + 0.1),
        ((right - left) / 2, 0, 0),
        (0, (high - low) / 2, 0),
    )
    return [
        Object("walls", merge(walls), WALLPAPER, casts=False),
        Object("floor", floor, OAK, casts=False),
        Object("windows", merge(glass), DAYLIGHT, casts=False),
        Object("window frames", merge(frames), PANELING, casts=False),
        Object("picture", canvas, LINEN, casts=False),
        *_furniture(),
    ]


def _frame(left: float, low: float, right: float, high: float, wide: float) -> list[Mesh]:
    """Return the four sides of a frame on the wall, around a rectangle."""
    z, front = WALL + 0.05, WALL + 0.7
    return [
        slab((left - wide, low - wide, z), (left, high + wide, front)),
        slab((right, low - wide, z), (right + wide, high + wide, front)),
        slab((left, low - wide, z), (right, low, front)),
        slab((left, high, z), (right, high + wide, front)),
    ]


def _furniture() -> list[Object]:
    """Return a bookcase with books, the frame of the picture, and a chair at the table."""
    left, right, depth = 11.8, 19.0, WALL + 3.0
    pitch = (10.0 - FLOOR) / SHELVES
    wood = [
        slab((left - 0.3, FLOOR, WALL + 0.05), (left, 10.2, depth)),
        slab((right, FLOOR, WALL + 0.05), (right + 0.3, 10.2, depth)),
        *_frame(*PICTURE, 0.3),
    ]
    books: dict[RGB, list[Mesh]] = {paint: [] for paint in BOOKS}
    for shelf in range(SHELVES + 1):
        y = FLOOR + shelf * pitch
        wood.append(slab((left, y, WALL + 0.05), (right, y + 0.25, depth)))
        if shelf == SHELVES:
            continue
        for place in range(12):
            # Heights vary without random numbers.
            top = 1.9 + 0.6 * math.sin(7.3 * place + 2.1 * shelf)
            x = left + 0.15 + 0.58 * place
            paint = BOOKS[(place * place + shelf) % len(BOOKS)]
            spine = slab((x, y + 0.26, WALL + 1.0), (x + 0.5, y + 0.26 + top, depth - 0.3))
            books[paint].append(spine)
    x, z = -2.2, -8.5
    for side in (-1.9, 1.9):
        wood.append(slab((x + side - 0.2, FLOOR, z - 0.2), (x + side + 0.2, 2.6, z + 0.2)))
    for y in (-1.6, 0.1, 1.8):
        wood.append(slab((x - 1.7, y, z - 0.1), (x + 1.7, y + 0.55, z + 0.1)))
    return [
        Object("furniture", merge(wood), OAK, casts=False),
        *(
            Object(f"books {number}", merge(books[paint]), Material(albedo=paint), casts=False)
            for number, paint in enumerate(BOOKS)
        ),
    ]


def _daylight() -> EnvironmentLight:
    """Return the same room as surroundings, with a further window behind the viewer."""
    bright = (2.6, 2.8, 3.0)
    windows = (
        Window(azimuth=-0.42, elevation=0.22, width=0.28, height=0.5, radiance=bright),
        Window(azimuth=-0.05, elevation=0.22, width=0.28, height=0.5, radiance=bright),
        Window(azimuth=2.2, elevation=0.4, width=0.9, height=0.7, radiance=(3.0, 2.9, 2.7)),
    )
    return room((0.26, 0.27, 0.28), (0.24, 0.25, 0.24), (0.05, 0.04, 0.03), windows)
