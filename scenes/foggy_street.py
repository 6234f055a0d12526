"""A street at night in fog: lamps, lit windows and two people, the farther the more blurred.

The fog thickens with distance and near the ground. The woman has little of it before her; the man
stands deeper in it under a lamp, and the houses at the end dissolve. Two lamps throw beams, in
which bodies, shades and the leaves of a tree cast shadows through the fog. The arrangement is that
of figures 1 (right) and 21b of McGuire & Mara 2017, "Phenomenological Transparency".
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from oitbench.modeling.mesh import (
    divisions,
    frames,
    grid,
    lathe,
    merge,
    rotation,
    scatter,
    smooth_curve,
    transform,
    translation,
)
from oitbench.modeling.props.architecture import globe, lamp_post, repeated, slab
from oitbench.modeling.props.people import limb, man, woman
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
    SpotLight,
    Texture,
    sample_density,
)

Floats = npt.NDArray[np.float64]

quick = False
parameters = {
    "detail": Parameter(1.0, low=0.0, high=100.0, help="factor on the triangles of a surface"),
    "seed": Parameter(1, low=0, help="seed of the windows that are lit, and of the leaves"),
    "extinction": Parameter(0.09, low=0.0, high=1.0, help="of the thickest fog, per metre"),
    "collimation": Parameter(0.0, low=0.0, high=1.0, help="of the fog; 1 for no blur"),
}

# Metres. The street runs along -z between houses at x = ±HOUSES.
HOUSES, PAVEMENT, NEAR, FAR = 6.0, 3.4, 6.0, -66.0
CURB = 0.12
LAMP_HEIGHT, ARM, LAMP_SPACING, LAMPS = 3.9, 0.9, 6.3, 9
BULB = 0.13
WOMAN: RGB = (-0.95, 0.0, -5.2)
MAN: RGB = (0.9, 0.0, -11.0)
TREE: RGB = (4.6, CURB, -10.4)
LEAVES, LEAF, CROWN = 900, 0.11, (1.35, 1.1, 1.35)
CROWN_HEIGHT = 3.6
MASK_SIDE = 64
STOREY, WINDOW_PITCH = 2.9, 2.3
LIT = 0.38  # part of the windows that are lit

NIGHT: RGB = (0.010, 0.015, 0.028)
BULB_LIGHT = Material(emission=(14.0, 10.5, 6.0))
WARM = Material(emission=(1.3, 0.80, 0.30))
COOL = Material(emission=(0.50, 0.68, 0.75))
DARK = Material(albedo=(0.03, 0.035, 0.045))
ASPHALT = Material(albedo=(0.16, 0.16, 0.17))
STONE = Material(albedo=(0.30, 0.29, 0.28))
IRON = Material(albedo=(0.06, 0.07, 0.07))
DRESS = Material(albedo=(0.50, 0.07, 0.08))
COAT = Material(albedo=(0.22, 0.19, 0.16))
BARK = Material(albedo=(0.14, 0.10, 0.08))
LEAF_GREEN: RGB = (0.16, 0.28, 0.08)
PLASTER: tuple[RGB, ...] = ((0.38, 0.24, 0.18), (0.34, 0.33, 0.31), (0.42, 0.36, 0.26))


@dataclass(frozen=True)
class House:
    """A house of a row: side of the street, −1 or 1, ends in z, storeys and paint."""

    side: int
    near: float
    far: float
    storeys: int
    paint: int


ROW = (
    House(-1, NEAR, -9.0, 4, 0),
    House(-1, -9.0, -20.0, 3, 1),
    House(-1, -20.0, -33.0, 5, 2),
    House(-1, -33.0, FAR, 4, 1),
    House(1, NEAR, -5.5, 3, 2),
    House(1, -5.5, -17.0, 5, 1),
    House(1, -17.0, -30.0, 4, 0),
    House(1, -30.0, FAR, 3, 2),
)


def build(*, name: str, detail: float, seed: int, extinction: float, collimation: float) -> Scene:
    """Return street, houses, lamps, tree and people in the fog."""
    windows = np.random.default_rng([seed, 0])
    objects = (
        *_ground(detail),
        *_houses(windows),
        *_lamps(detail),
        Object("woman", _placed(woman(detail), WOMAN, 200), DRESS),
        Object("man", _placed(man(detail), MAN, 15), COAT),
        *_tree(np.random.default_rng([seed, 1]), detail),
    )
    # The box ends inside houses and ground: no surface lies in its faces.
    low, high = (-HOUSES - 0.5, -0.5, FAR - 0.5), (HOUSES + 0.5, 11.0, NEAR - 0.5)
    fog = Medium(
        extinction=extinction,
        low=low,
        high=high,
        albedo=(0.90, 0.90, 0.90),
        anisotropy=0.4,
        collimation=collimation,
        density=sample_density(_density, low, high, (16, 16, 96)),
    )
    return Scene(
        name=name,
        camera=Camera(position=(0.2, 1.6, 0.0), target=(0.25, 2.0, -12), fov_y=math.radians(48)),
        objects=objects,
        lights=(*_beams(), EnvironmentLight(NIGHT)),
        medium=fog,
    )


def _density(points: Floats) -> Floats:
    """Return fog that thickens between 1 and 22 m from the camera and thins with height."""
    x, y, z = np.moveaxis(points, -1, 0)
    away = np.clip((-z - 1.0) / 21.0, 0, 1)
    banks = 1 + 0.25 * np.sin(0.9 * x + 0.35 * z) * np.cos(0.23 * z + 1.0)
    return np.asarray((0.10 + 0.70 * away) * banks * (0.55 + 0.45 * np.exp(-y / 3.0)))


def _placed(mesh: Mesh, place: RGB, degrees: float) -> Mesh:
    return transform(mesh, translation(place) @ rotation((0, 1, 0), math.radians(degrees)))


def _ground(detail: float) -> tuple[Object, ...]:
    """Return the roadway between two pavements."""
    middle, half = (NEAR + FAR) / 2, (NEAR - FAR) / 2
    road = grid((0, 0, middle), (PAVEMENT, 0, 0), (0, 0, -half), divisions(8, detail), 24)
    walks = [
        slab((-HOUSES, -0.05, FAR), (-PAVEMENT, CURB, NEAR)),
        slab((PAVEMENT, -0.05, FAR), (HOUSES, CURB, NEAR)),
    ]
    return (
        Object("road", road, ASPHALT, casts=False),
        Object("pavements", merge(walks), STONE, casts=False),
    )


def _houses(random: np.random.Generator) -> tuple[Object, ...]:
    """Return the houses, with windows that are lit at random."""
    walls: dict[int, list[Mesh]] = {paint: [] for paint in range(len(PLASTER))}
    places: dict[tuple[str, int], list[RGB]] = {}
    for house in ROW:
        inner, outer = HOUSES * house.side, (HOUSES + 4) * house.side
        low, high = min(inner, outer), max(inner, outer)
        top = 0.8 + STOREY * house.storeys
        walls[house.paint].append(slab((low, 0, house.far), (high, top, house.near)))
        count = int((house.near - house.far) / WINDOW_PITCH)
        for index, storey in itertools.product(range(count), range(house.storeys)):
            z = house.near - (index + 0.5) * (house.near - house.far) / count
            lit = "dark" if random.random() > LIT else str(random.choice(["warm", "warm", "cool"]))
            places.setdefault((lit, house.side), []).append((inner, 1.9 + STOREY * storey, z))
    objects = [
        Object(f"houses {paint}", merge(meshes), Material(albedo=PLASTER[paint]), casts=False)
        for paint, meshes in walls.items()
    ]
    for kind, material in (("warm", WARM), ("cool", COOL), ("dark", DARK)):
        panes = [
            repeated(_pane(side), spots) for (what, side), spots in places.items() if what == kind
        ]
        if panes:
            objects.append(Object(f"{kind} windows", merge(panes), material, casts=False))
    bars = [repeated(_bars(side), spots) for (_, side), spots in places.items()]
    objects.append(Object("sills and bars", merge(bars), STONE, casts=False))
    end = grid((0, 6, FAR), (HOUSES + 4, 0, 0), (0, 6, 0))
    objects.append(Object("end of the street", end, Material(albedo=PLASTER[1]), casts=False))
    return tuple(objects)


def _pane(side: int) -> Mesh:
    """Return the glass of a window whose middle is the origin, on the wall of a side."""
    return grid((-0.01 * side, 0, 0), (0, 0, 0.5 * side), (0, 0.8, 0))


def _bars(side: int) -> Mesh:
    """Return the sill of a window, and its upright and cross bars."""
    bar, ledge = sorted((0.0, -0.05 * side)), sorted((0.0, -0.16 * side))
    return merge(
        [
            slab((ledge[0], -0.9, -0.6), (ledge[1], -0.8, 0.6)),
            slab((bar[0], -0.8, -0.03), (bar[1], 0.8, 0.03)),
            slab((bar[0], 0.22, -0.5), (bar[1], 0.27, 0.5)),
        ]
    )


def _lamp_places() -> list[tuple[int, float]]:
    """Return side and z of the lamps, left and right in turn."""
    return [(1 if index % 2 else -1, -6.0 - LAMP_SPACING * index) for index in range(LAMPS)]


def _lamps(detail: float) -> tuple[Object, ...]:
    """Return the posts and, apart for their glow, the bulbs."""
    posts, bulbs = [], []
    # Far lamps are small in the picture and get by with fewer triangles.
    for index, (side, z) in enumerate(_lamp_places()):
        fineness = detail / (1 + 0.5 * index)
        turn = 0 if side < 0 else 180
        foot = (4.0 * side, CURB, z)
        posts.append(_placed(lamp_post(LAMP_HEIGHT, ARM, fineness), foot, turn))
        x, y, z = _bulb(side, z)
        bulbs.append(globe((x, y, z), BULB, fineness))
    return (
        Object("lamp posts", merge(posts), IRON),
        Object("bulbs", merge(bulbs), BULB_LIGHT, casts=False),
    )


def _bulb(side: int, z: float) -> RGB:
    """Return the middle of a bulb, which hangs half out of its shade."""
    return ((4.0 - ARM) * side, CURB + LAMP_HEIGHT, z)


def _beams() -> tuple[SpotLight, ...]:
    """Return the light of the first two lamps, from just below their bulbs."""
    lights = []
    for side, z in _lamp_places()[:2]:
        x, y, _ = _bulb(side, z)
        below = y - BULB - 0.03
        lights.append(
            SpotLight(
                position=(x, below, z),
                target=(x - 0.45 * side, 0.0, z),
                intensity=(150.0, 118.0, 75.0),
                angle=math.radians(145),
            )
        )
    return tuple(lights)


def _tree(random: np.random.Generator, detail: float) -> tuple[Object, ...]:
    """Return a small street tree: trunk, boughs and a crown of leaf cards."""
    trunk = smooth_curve([(0.13, 0), (0.09, 0.5), (0.07, 2.2), (0.05, 3.2)], 8)
    slices = divisions(12, detail, 6)
    wood = [transform(lathe(trunk, slices), translation(TREE))]
    foot = np.asarray(TREE)
    for angle in np.linspace(0, 2 * math.pi, 7)[:-1]:
        x, z = TREE[0] + 0.8 * math.cos(angle), TREE[2] + 0.8 * math.sin(angle)
        y = TREE[1] + 3.3 + 0.5 * math.sin(3 * angle)
        wood.append(limb((TREE[0], TREE[1] + 2.3, TREE[2]), (x, y, z), 0.05, 0.015, detail))
    count = max(8, round(LEAVES * detail))
    outward = random.normal(size=(count, 3))
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    reach = 0.25 + 0.75 * random.random((count, 1)) ** 0.5
    centers = foot + [0, CROWN_HEIGHT, 0] + np.asarray(CROWN) * outward * reach
    tips = outward + 0.7 * random.normal(size=(count, 3))
    tips /= np.linalg.norm(tips, axis=1, keepdims=True)
    rights = np.cross(tips, random.normal(size=(count, 3)))
    rights /= np.linalg.norm(rights, axis=1, keepdims=True)
    # Fewer leaves are larger ones, so that the crown stays as dense.
    size = LEAF * max(1.0, math.sqrt(LEAVES / count))
    cards = scatter(
        grid((0, 0, 0), (1, 0, 0), (0, 1, 0)), frames(centers, size * rights, size * tips)
    )
    leaves = Material(coverage=_leaf_mask(), albedo=LEAF_GREEN, binary_coverage=True)
    return Object("tree", merge(wood), BARK), Object("leaves", cards, leaves)


def _leaf_mask() -> Texture:
    """Return the outline of three pointed leaves on a stalk, averaged from subsamples."""
    side, blocks = 4 * MASK_SIDE, (MASK_SIDE, 4, MASK_SIDE, 4)
    line = ((np.arange(side) + 0.5) / side * 2 - 1) * 1.15
    x, y = np.meshgrid(line, line[::-1])
    inside = np.zeros_like(x, dtype=bool)
    for angle in (-1.0, 0.0, 1.0):
        along = math.sin(angle) * x + math.cos(angle) * (y + 0.7)
        across = math.cos(angle) * x - math.sin(angle) * (y + 0.7)
        half = 0.36 * np.sin(np.clip(along / 1.5, 0, 1) * math.pi) ** 0.8
        inside |= (np.abs(across) < half) & (along < 1.5) & (along > 0)
    inside &= np.maximum(np.abs(x), np.abs(y)) <= 1.0
    return Texture(inside.reshape(blocks).mean(axis=(1, 3)).astype(np.float32))
