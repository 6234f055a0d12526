"""A patio with trees, wine glasses and oil lamps on laid tables, in the haze of a late afternoon.

Stands for figures 15 and 25 of McGuire & Mara 2017, "Phenomenological Transparency", which show the
scene San Miguel; it has the character of that scene and none of its geometry.

Parameters
----------
detail : float
    Factor on the number of leaves and triangles.
extinction : float
    Extinction coefficient of the haze at its densest, m⁻¹.
seed : int
    Seed of the leaves.
near : float
    Distance of the near plane from the camera, m. The fog begins at the camera.

All kinds of transparency meet in one picture: leaves whose coverage is a binary mask that only
filtering makes smooth, thin flues of lamps, wine glasses that refract and hold red wine, and haze
in which the sun draws shafts through the crown of a tree. The lamps are lit, and the one on the
nearest table shines on the glasses around it.

Wine touches its glass: it reaches into the wall, which has the higher `Object.priority`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from oitbench.modeling.detail import DETAIL, divisions
from oitbench.modeling.mesh import grid, quad, slab
from oitbench.modeling.patterns import checkers
from oitbench.modeling.placement import (
    merge,
    repeated,
    rotation,
    scaling,
    scatter,
    transform,
    translation,
)
from oitbench.modeling.props.architecture import arch, column
from oitbench.modeling.props.furniture import (
    FLAME,
    chair,
    cloth,
    oil_lamp,
    plate_of_china,
    pot,
    ring_of,
    round_table,
)
from oitbench.modeling.props.glassware import wine_glass
from oitbench.modeling.props.leaves import (
    Plant,
    blossom,
    lance,
    leaf_mask,
    lobed,
    ovate,
    place_leaves,
)
from oitbench.modeling.surroundings import gradient_sky
from oitbench.modeling.sweeps import pipe
from oitbench.parameters import Parameter
from oitbench.scene import (
    RGB,
    Camera,
    DirectionalLight,
    Floats,
    Material,
    Medium,
    Mesh,
    Object,
    Scene,
    SpotLight,
    Vector,
    opposite,
    sample_density,
)

quick = False
near = 0.1
parameters = {
    "detail": DETAIL,
    "extinction": Parameter(0.11, low=0.0, high=10.0, help="extinction of the densest haze, 1/m"),
    "seed": Parameter(1, low=0, help="seed of the leaves"),
}

# Meters. Arcades stand on the left and at the back; the wall on the right is plain.
LEFT, RIGHT, BACK, FRONT = -5.2, 4.3, -9.0, 3.4
BAY, COLUMN, ARCH, ROOF = 2.6, 2.2, 1.5, 5.1
TILE = 0.4
TABLE_HEIGHT, TABLE_RADIUS = 0.74, 0.50
# Place of each table, its number of chairs and of glasses, and the turn of the first chair.
TABLES = (
    ((0.12, 0.0, 0.30), 3, 4, 2.5),
    ((-2.5, 0.0, -2.0), 4, 3, 0.3),
    ((2.2, 0.0, -2.7), 4, 3, 0.8),
    ((-0.1, 0.0, -5.6), 4, 2, 0.1),
)
# Feet of the lamps that hang in the arches at the back.
HOOKS = tuple((BAY * (place - 1.5), 2.3, BACK) for place in range(4))
LAMP_AT = (0.0, TABLE_HEIGHT + 0.006, -0.04)  # on each table
SUNWARD: Vector = (-0.50, 0.78, -0.38)
SUN: RGB = (6.4, 4.7, 2.9)  # irradiance
SKY = (
    (-90.0, (0.06, 0.05, 0.04)),
    (0.0, (0.34, 0.31, 0.31)),
    (25.0, (0.26, 0.32, 0.42)),
    (90.0, (0.10, 0.18, 0.34)),
)
HAZE: RGB = (0.130, 0.108, 0.086)  # radiance that arrives in the haze from all sides

FLAMES = Material(emission=(26.0, 13.0, 4.0))
GLASS = Material(transmission=(0.98, 0.98, 0.98), index=1.5, roughness=0.0, solid=True)
WINE = Material(transmission=(0.62, 0.05, 0.08), index=1.34, roughness=0.0, solid=True)
FLUE = Material(transmission=(0.97, 0.97, 0.97), index=1.5, roughness=0.0)


def _paint(albedo: RGB) -> Material:
    return Material(albedo=albedo, specular=0.0)


PLASTER, OCHRE = _paint((0.62, 0.36, 0.20)), _paint((0.66, 0.50, 0.30))
STONE, PALE_TILES, RED_TILES = (
    _paint((0.56, 0.50, 0.42)),
    _paint((0.44, 0.36, 0.27)),
    _paint((0.36, 0.17, 0.10)),
)
WOOD, LINEN, CHINA = (
    _paint((0.24, 0.12, 0.06)),
    _paint((0.80, 0.76, 0.68)),
    _paint((0.78, 0.77, 0.74)),
)
CLAY, BRASS, BARK = (
    _paint((0.52, 0.24, 0.13)),
    _paint((0.42, 0.28, 0.10)),
    _paint((0.20, 0.14, 0.09)),
)
GREENS = ((0.05, 0.15, 0.03), (0.16, 0.30, 0.06))
TREE = Plant(
    "tree", (-1.75, 3.35, -4.3), (1.75, 0.95, 1.5), ovate, (0.055, 0.10), 2200, GREENS, 0.15
)
PINKS = ((0.60, 0.03, 0.22), (0.72, 0.08, 0.34))
# Name, center, half axes, shape of leaf, half its width and length, number, colors, hollow, droop.
PLANTS = (
    TREE,
    Plant("vine", (3.95, 3.3, -5.6), (0.4, 1.0, 2.0), lobed, (0.08, 0.08), 800, GREENS, 0.3, 0.9),
    Plant(
        "creeper", (1.0, 3.85, -8.6), (2.9, 0.45, 0.3), lobed, (0.07, 0.07), 900, GREENS, 0.2, 0.9
    ),
    Plant(
        "blossoms", (1.4, 3.75, -8.5), (2.6, 0.5, 0.3), blossom, (0.06, 0.06), 320, PINKS, 0.5, 0.6
    ),
    Plant(
        "lily", (-3.9, 1.0, -4.0), (0.5, 0.55, 0.5), lance, (0.035, 0.26), 180, GREENS, 0.3, -0.4
    ),
    Plant("laurel", (3.4, 0.95, -5.6), (0.5, 0.52, 0.5), ovate, (0.05, 0.08), 420, GREENS, 0.4),
    Plant(
        "ivy", (-3.7, 0.72, -6.6), (0.45, 0.32, 0.45), lobed, (0.07, 0.07), 300, GREENS, 0.4, 0.9
    ),
)
POTTED = ("lily", "laurel", "ivy")


def build(*, name: str, detail: float, extinction: float, seed: int) -> Scene:
    """Return the patio with its tables, plants and lamps, in the haze."""
    low, high = (LEFT - 0.7, -0.4, BACK - 0.7), (RIGHT + 0.3, ROOF + 2.2, FRONT + 0.3)
    haze = Medium(
        extinction=extinction,
        low=low,
        high=high,
        albedo=(0.94, 0.94, 0.94),
        anisotropy=0.55,
        ambient=HAZE,
        density=sample_density(_density, low, high, (24, 16, 24)),
    )
    return Scene(
        name=name,
        camera=Camera(
            position=(0.50, 1.30, 1.80), target=(-0.22, 1.28, -3.0), fov_y=math.radians(50)
        ),
        objects=(*_buildings(detail), *_tables(detail), *_plants(seed, detail)),
        lights=(DirectionalLight(opposite(SUNWARD), SUN), _lamplight(), gradient_sky(SKY)),
        medium=haze,
        full_samples=64,
    )


def _density(points: Floats) -> Floats:
    """Return haze that thins with height and drifts in banks."""
    x, y, z = np.moveaxis(points, -1, 0)
    banks = 1 + 0.3 * np.sin(0.8 * x + 1.1 * y + 0.6) * np.cos(0.7 * z - 0.5 * x)
    return np.asarray(0.70 * banks * np.exp(-np.maximum(y, 0) / 5.0))


def _lamplight() -> SpotLight:
    """Return the light of the lamp on the nearest table, which shines on the glasses."""
    flame = np.asarray(TABLES[0][0]) + np.asarray(LAMP_AT) + np.asarray(FLAME)
    x, y, z = (float(part) for part in flame)
    return SpotLight((x, y, z), (x - 0.2, y - 0.12, z + 0.9), (0.55, 0.36, 0.16), math.radians(150))


def _buildings(detail: float) -> tuple[Object, ...]:
    """Return the tiled floor, two arcades under a wall, the walls behind them, and that on the right."""
    wide, deep = RIGHT - LEFT + 4, FRONT - BACK + 4
    middle = ((RIGHT + LEFT) / 2 - 1, 0.0, (FRONT + BACK) / 2 - 1)
    floor = checkers(
        middle, (wide / 2, 0, 0), (0, 0, -deep / 2), round(wide / TILE), round(deep / TILE)
    )
    segments = divisions(16, detail, 6)
    bay = merge(
        [
            arch(BAY, BAY - 0.55, ARCH, 0.42, segments),
            slab((-BAY / 2, ARCH, -0.21), (BAY / 2, ROOF - COLUMN, 0.21)),
        ]
    )
    cornice = slab((-BAY / 2, ROOF - COLUMN, -0.3), (BAY / 2, ROOF - COLUMN + 0.14, 0.3))
    support = column(COLUMN, 0.15, 0.5 * detail)
    spots = {
        "back": (translation((0, 0, BACK)), [BAY * (place - 1.5) for place in range(4)]),
        "left": (
            translation((LEFT, 0, BACK)) @ rotation((0, 1, 0), math.pi / 2),
            [-BAY * (place + 0.5) for place in range(5)],
        ),
    }
    plaster, stone = [], []
    for matrix, middles in spots.values():
        plaster.append(transform(repeated(bay, [(x, COLUMN, 0) for x in middles]), matrix))
        stone.append(transform(repeated(cornice, [(x, COLUMN, 0) for x in middles]), matrix))
        feet = [(x - BAY / 2, 0.003, 0.0) for x in middles]
        stone.append(transform(repeated(support, feet), matrix))
    back = grid((-1, 2, BACK - 2.4), (wide / 2, 0, 0), (0, 2.4, 0))
    left = grid((LEFT - 2.4, 2, (FRONT + BACK) / 2 - 1), (0, 0, -deep / 2), (0, 2.4, 0))
    right = grid((RIGHT, 2.4, (FRONT + BACK) / 2 - 1), (0, 0, deep / 2), (0, 2.8, 0))
    return (
        Object("pale tiles", floor[0], PALE_TILES, casts=False),
        Object("red tiles", floor[1], RED_TILES, casts=False),
        Object("arcades", merge(plaster), PLASTER),
        Object("columns", merge(stone), STONE),
        Object("walls", merge([back, left, right]), OCHRE, casts=False),
    )


def _tables(detail: float) -> tuple[Object, ...]:
    """Return tables with cloths, chairs, plates, lamps, and glasses of wine."""
    parts: dict[str, list[Mesh]] = {}
    vessel = wine_glass(0.042, 0.205, 0.0022)
    for number, (place, chairs, glasses, turn) in enumerate(TABLES):
        fine = detail * (0.4 if number == 0 else 0.12)
        at = translation(place)
        on_table = at @ translation((0, TABLE_HEIGHT + 0.006, 0))
        lamp = oil_lamp(2 * fine).transformed(at @ translation(LAMP_AT))
        found = {
            "chairs": [
                (chair(fine), at @ spot) for spot in _spots(TABLE_RADIUS + 0.32, chairs, turn)
            ],
            "tables": [
                (
                    round_table(TABLE_RADIUS, TABLE_HEIGHT, 0.6 * detail),
                    at @ translation((0, 0.003, 0)),
                )
            ],
            "cloths": [(cloth(TABLE_RADIUS + 0.012, 0.22, 9, 2 * fine), on_table)],
            "plates": [
                (plate_of_china(0.13, fine), on_table @ translation((0, 0.002, 0)) @ spot)
                for spot in _spots(0.32, chairs, turn)
            ],
            "lamps": [(lamp.base, np.eye(4))],
            "flames": [(lamp.flame, np.eye(4))],
            "flues": [(lamp.flue, np.eye(4))],
            "wine glasses": [
                (vessel.glass(fine), on_table @ translation((0, 0.002, 0)) @ spot)
                for spot in _spots(0.24, glasses, turn + 0.5)
            ],
            "wine": [
                (vessel.filling(0.135, -0.0008, fine), on_table @ translation((0, 0.002, 0)) @ spot)
                for spot in _spots(0.24, glasses, turn + 0.5)
            ],
        }
        for kind, placed in found.items():
            parts.setdefault(kind, []).extend(transform(mesh, matrix) for mesh, matrix in placed)
    for hook in HOOKS:
        at = translation(hook)
        lamp = oil_lamp(0.2 * detail).transformed(at @ scaling((1.6, 1.6, 1.6)))
        parts["lamps"] += [lamp.base, pipe([hook, np.add(hook, (0, 0.9, 0))], 0.012, 2, 4)]
        parts["flames"].append(lamp.flame)
        parts["flues"].append(lamp.flue)
    materials = {
        "chairs": WOOD, "tables": WOOD, "cloths": LINEN, "plates": CHINA, "lamps": BRASS,
        "flames": FLAMES, "flues": FLUE, "wine glasses": GLASS, "wine": WINE,
    }  # fmt: skip
    return tuple(
        Object(kind, merge(parts[kind]), material, priority=int(material is GLASS))
        for kind, material in materials.items()
    )


def _spots(radius: float, count: int, turn: float) -> Iterator[Floats]:
    """Yield matrices that place things around a table, turned towards its middle."""
    for place, angle in ring_of(radius, count, turn):
        yield translation(place) @ rotation((0, 1, 0), angle)


def _plants(seed: int, detail: float) -> Iterator[Object]:
    """Yield the trunk of the tree, pots, and the leaves of all plants, an object for each color."""
    x, _, z = TREE.center
    boughs = [
        [(x, 2.2, z), (x + dx, 2.8, z + dz), (x + 2 * dx, 3.5, z + 1.6 * dz)]
        for dx, dz in ((-0.4, 0.2), (0.4, -0.3), (0.1, 0.45))
    ]
    sides = divisions(12, detail, 5)
    wood = [pipe([(x + 0.1, -0.02, z), (x - 0.05, 1.2, z), (x, 2.6, z)], 0.11, 8, sides)]
    wood += [pipe(bough, 0.05, 6, sides) for bough in boughs]
    yield Object("trunk", merge(wood), BARK)
    spots = [plant.center for plant in PLANTS if plant.name in POTTED]
    yield Object(
        "pots",
        merge([transform(pot(0.3, 0.46, detail), translation((a, 0.003, c))) for a, _, c in spots]),
        CLAY,
    )
    card = quad((0, 0, 0), (1, 0, 0), (0, 1, 0))
    for stream, plant in enumerate(PLANTS):
        leaves = place_leaves(plant, np.random.default_rng([seed, stream]), detail)
        mask = leaf_mask(plant.shape)
        shades = np.round(leaves.shades * (len(plant.colors) - 1)).astype(int)
        for number, color in enumerate(plant.colors):
            material = Material(coverage=mask, albedo=color, specular=0.0, binary_coverage=True)
            mesh = scatter(card, leaves.placements[shades == number])
            yield Object(f"{plant.name} {number}", mesh, material)
