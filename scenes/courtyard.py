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
from oitbench.modeling.mesh import grid, quad
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
from oitbench.modeling.props.architecture import arcade
from oitbench.modeling.props.furniture import (
    FLAME,
    around_table,
    chair,
    cloth,
    oil_lamp,
    plate_of_china,
    pot,
    round_table,
)
from oitbench.modeling.props.glassware import wine_glass
from oitbench.modeling.props.leaves import (
    Plant,
    blossom,
    colored_cards,
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
    WHITE,
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
    as_vector,
    opposite,
    sample_density,
)
from oitbench.scene.paths import between

subject = "fog"
quick = False
near = 0.1
crops = {
    "crown": (0.3, 0.04, 0.26, 0.26),
    "leaves": (0.73, 0.02, 0.26, 0.26),
    "glasses": (0.19, 0.7, 0.26, 0.26),
    "far_table": (0.5, 0.46, 0.26, 0.26),
    "crown@tree": (0.3, 0.2, 0.4, 0.4),
}
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
TABLE_TOP = TABLE_HEIGHT + 0.008  # of the plates and glasses on it
SUNK = translation((0, -0.002, 0))  # the cloth is below them
SUNWARD: Vector = (-0.50, 0.78, -0.38)
SUN: RGB = (6.4, 4.7, 2.9)  # irradiance
SKY = (
    (-90.0, (0.06, 0.05, 0.04)),
    (0.0, (0.34, 0.31, 0.31)),
    (25.0, (0.26, 0.32, 0.42)),
    (90.0, (0.10, 0.18, 0.34)),
)
HAZE: RGB = (0.130, 0.108, 0.086)  # radiance that arrives in the haze from all sides

GLASS = Material(transmission=(0.98, 0.98, 0.98), index=1.5, roughness=0.0, solid=True)
WINE = Material(transmission=(0.62, 0.05, 0.08), index=1.34, roughness=0.0, solid=True)


def _paint(*albedo: float) -> Material:
    """Return a matte opaque paint."""
    red, green, blue = albedo
    return Material(albedo=(red, green, blue), specular=0.0)


PLASTER, OCHRE = _paint(0.62, 0.36, 0.20), _paint(0.66, 0.50, 0.30)
STONE, CLAY, BARK = _paint(0.56, 0.50, 0.42), _paint(0.52, 0.24, 0.13), _paint(0.20, 0.14, 0.09)
PALE_TILES, RED_TILES = _paint(0.44, 0.36, 0.27), _paint(0.36, 0.17, 0.10)
# What is on the floor and on the tables, in the order of submission.
LAID = {
    "chairs": _paint(0.24, 0.12, 0.06),
    "tables": _paint(0.22, 0.11, 0.06),
    "cloths": _paint(0.80, 0.76, 0.68),
    "plates": _paint(0.34, 0.44, 0.56),
    "lamps": _paint(0.42, 0.28, 0.10),
    "flames": Material(emission=(26.0, 13.0, 4.0)),
    "flues": Material(transmission=(0.97, 0.97, 0.97), index=1.5, roughness=0.0),
    "wine glasses": GLASS,
    "wine": WINE,
}
GREENS = ((0.05, 0.15, 0.03), (0.16, 0.30, 0.06))
PINKS = ((0.60, 0.03, 0.22), (0.72, 0.08, 0.34))
# Name, center, half axes, shape of leaf, half its width and length, number, colors, hollow, droop.
# fmt: off
TREE = Plant(
    "tree", (-1.75, 3.35, -4.3), (1.75, 0.95, 1.5), ovate, (0.05, 0.09), 3600, GREENS, 0.15
)
POTTED = (
    Plant("lily", (-3.9, 1, -4.0), (0.5, 0.55, 0.5), lance, (0.035, 0.26), 180, GREENS, 0.3, -0.4),
    Plant("laurel", (3.4, 0.95, -5.6), (0.5, 0.5, 0.5), ovate, (0.05, 0.08), 420, GREENS, 0.4),
    Plant("ivy", (-3.7, 0.72, -6.6), (0.45, 0.3, 0.45), lobed, (0.07, 0.07), 300, GREENS, 0.4, 0.9),
)
CLIMBING = (
    Plant("vine", (3.85, 2.9, -7.0), (0.4, 0.9, 1.5), lobed, (0.08, 0.08), 1200, GREENS, 0.3, 0.9),
    Plant("bough", (1.0, 1.86, 0.05), (0.62, 0.2, 0.4), ovate, (0.028, 0.055), 360, GREENS, 0, 0.7),
    Plant("creeper", (1, 3.85, -8.6), (2.9, 0.45, 0.3), lobed, (0.07, 0.07), 990, GREENS, 0.2, 0.9),
    Plant("blossoms", (1.4, 3.75, -8.5), (2.6, 0.5, 0.3), blossom, (0.06, 0.06), 320, PINKS, 0.5),
)
# fmt: on
CAMERA = Camera(position=(0.50, 1.30, 1.80), target=(-0.22, 1.28, -3.0), fov_y=math.radians(50))
VIEWS = {
    "table": Camera(position=(0.42, 1.12, 1.12), target=(0.10, 0.86, 0.28), fov_y=math.radians(42)),
    "tree": Camera(
        position=(0.30, 1.50, -2.20), target=(-1.80, 3.00, -4.60), fov_y=math.radians(55)
    ),
}


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
        camera=CAMERA,
        views=VIEWS,
        path=between(CAMERA, VIEWS["tree"], 24),
        objects=(*_buildings(detail), *_tables(detail), *_plants(seed, detail)),
        lights=(DirectionalLight(opposite(SUNWARD), SUN), _lamplight(), gradient_sky(SKY)),
        medium=haze,
        full_samples=120,
    )


def _density(points: Floats) -> Floats:
    """Return haze that thins with height and drifts in banks."""
    x, y, z = np.moveaxis(points, -1, 0)
    banks = 1 + 0.3 * np.sin(0.8 * x + 1.1 * y + 0.6) * np.cos(0.7 * z - 0.5 * x)
    return np.asarray(0.70 * banks * np.exp(-np.maximum(y, 0) / 5.0))


def _lamplight() -> SpotLight:
    """Return the light of the lamp on the nearest table, which shines on the glasses."""
    x, y, z = as_vector(np.add(TABLES[0][0], (0.0, TABLE_TOP + FLAME[1], 0.0)))
    return SpotLight((x, y, z), (x - 0.2, y - 0.12, z + 0.9), (0.55, 0.36, 0.16), math.radians(130))


def _buildings(detail: float) -> tuple[Object, ...]:
    """Return the tiled floor, two arcades, and the walls behind them and on the right."""
    wide, deep = RIGHT - LEFT + 4, FRONT - BACK + 4
    x, z = (RIGHT + LEFT) / 2 - 1, (FRONT + BACK) / 2 - 1
    across, along = (wide / 2, 0, 0), (0, 0, -deep / 2)
    floor = checkers((x, 0, z), across, along, round(wide / TILE), round(deep / TILE))
    aside = translation((LEFT, 0.003, BACK + 2.5 * BAY)) @ rotation((0, 1, 0), math.pi / 2)
    places = ((4, translation((0, 0.002, BACK))), (5, aside))
    walls, columns = [], []
    for bays, place in places:
        parts = arcade(bays, BAY, COLUMN, ARCH, ROOF, detail)
        walls.append(transform(parts[0], place))
        columns.append(transform(parts[1], place))
    outer = [
        grid((x, 2, BACK - 2.4), across, (0, 2.4, 0)),
        grid((LEFT - 2.4, 2, z), along, (0, 2.4, 0)),
        grid((RIGHT, 2.4, z), opposite(along), (0, 2.8, 0)),
    ]
    return (
        Object("pale tiles", floor[0], PALE_TILES, casts=False),
        Object("red tiles", floor[1], RED_TILES, casts=False),
        Object("arcades", merge(walls), PLASTER),
        Object("columns", merge(columns), STONE),
        Object("walls", merge(outer), OCHRE),
    )


def _tables(detail: float) -> tuple[Object, ...]:
    """Return laid tables, chairs and lamps."""
    parts: dict[str, list[Mesh]] = {kind: [] for kind in LAID}
    vessel = wine_glass(0.042, 0.205, 0.0022)
    for number, (place, chairs, glasses, turn) in enumerate(TABLES):
        fine = detail * (0.4 if number == 0 else 0.12)
        covers, seats = (around_table(reach, chairs, turn) for reach in (0.32, TABLE_RADIUS + 0.32))
        drinks = around_table(0.24, glasses, turn + 0.5)
        lamp = oil_lamp(2 * fine)
        on_floor = {
            "chairs": scatter(chair(fine), seats),
            "tables": round_table(TABLE_RADIUS, TABLE_HEIGHT, 0.6 * detail),
        }
        on_table = {
            "cloths": transform(cloth(TABLE_RADIUS + 0.012, 0.22, 9, 2 * fine), SUNK),
            "plates": scatter(plate_of_china(0.13, fine), covers),
            "wine glasses": scatter(vessel.glass(fine), drinks),
            "wine": scatter(vessel.filling(0.135, -0.0008, fine), drinks),
            "lamps": lamp.base,
            "flames": lamp.flame,
            "flues": lamp.flue,
        }
        for level, meshes in ((0.003, on_floor), (TABLE_TOP, on_table)):
            for kind, mesh in meshes.items():
                parts[kind].append(transform(mesh, translation((place[0], level, place[2]))))
    for hook in HOOKS:
        lamp = oil_lamp(0.2 * detail).transformed(translation(hook) @ scaling((1.6, 1.6, 1.6)))
        parts["lamps"] += [
            lamp.base,
            pipe([hook, as_vector(np.add(hook, (0, 0.9, 0)))], 0.012, 2, 4),
        ]
        parts["flames"].append(lamp.flame)
        parts["flues"].append(lamp.flue)
    return tuple(
        Object(
            kind,
            merge(parts[kind]),
            material,
            casts=kind != "flames",  # the light of a lamp comes from the middle of its flame
            priority=int(material is GLASS),
        )
        for kind, material in LAID.items()
    )


def _plants(seed: int, detail: float) -> Iterator[Object]:
    """Yield the trunk of the tree, the pots, and the leaves of each plant."""
    x, _, z = TREE.center
    sides = divisions(12, detail, 5)
    wood = [pipe([(x + 0.1, -0.02, z), (x - 0.05, 1.2, z), (x, 2.6, z)], 0.11, 8, sides)]
    for dx, dz in ((-0.4, 0.2), (0.4, -0.3), (0.1, 0.45)):
        bough = [(x, 2.2, z), (x + dx, 2.8, z + dz), (x + 2 * dx, 3.5, z + 1.6 * dz)]
        wood.append(pipe(bough, 0.05, 6, sides))
    yield Object("trunk", merge(wood), BARK)
    spots = [(plant.center[0], 0.003, plant.center[2]) for plant in POTTED]
    yield Object("pots", repeated(pot(0.3, 0.46, detail), spots), CLAY)
    card = quad((0, 0, 0), (1, 0, 0), (0, 1, 0))
    for stream, plant in enumerate((TREE, *POTTED, *CLIMBING)):
        leaves = place_leaves(plant, np.random.default_rng([seed, stream]), detail)
        mask = leaf_mask(plant.shape)
        material = Material(coverage=mask, albedo=WHITE, specular=0.0, binary_coverage=True)
        yield Object(plant.name, colored_cards(card, leaves, plant), material)
