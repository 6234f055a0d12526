"""A street at night in fog, with lamps, lit windows and two people, blurred more with distance.

Arranged as figures 1 (right) and 21b of McGuire & Mara 2017, "Phenomenological Transparency".

Parameters
----------
detail : float
    Factor on the number of triangles and leaves.
seed : int
    Seed of the lit windows and of the leaves.
extinction : float
    Extinction coefficient of the fog where its density is one, m⁻¹.
collimation : float
    Collimation of the fog, in [0, 1]; 1 for no blur.
near : float
    Distance of the near plane from the camera, m. The fog begins at the camera.

The fog thickens with distance and towards the ground. There is little of it in front of the woman.
The man is deeper in it, and the houses at the end dissolve. Two lamps cast beams, in which people,
lamp shades and the leaves of a tree cast shadows through the fog.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from oitbench.modeling.detail import DETAIL, copies, divisions, enlargement
from oitbench.modeling.mesh import grid, lathe, quad, slab
from oitbench.modeling.placement import (
    merge,
    random_directions,
    repeated,
    rotation,
    scatter,
    transform,
    translation,
)
from oitbench.modeling.profiles import smooth_curve
from oitbench.modeling.props.architecture import globe, lamp_post
from oitbench.modeling.props.leaves import card_frames, leaf_mask, trefoil
from oitbench.modeling.props.people import limb, man, woman
from oitbench.parameters import Parameter
from oitbench.scene import (
    RGB,
    Camera,
    EnvironmentLight,
    Floats,
    Material,
    Medium,
    Mesh,
    Object,
    Scene,
    SpotLight,
    Vector,
    sample_density,
)

subject = "fog"
quick = False
near = 0.1
crops = {
    "woman": (0.22, 0.58, 0.05, 0.12),
    "man": (0.55, 0.56, 0.03, 0.06),
    "houses": (0.26, 0.2, 0.08, 0.08),
}
parameters = {
    "detail": DETAIL,
    "seed": Parameter(1, low=0, help="seed of the lit windows and of the leaves"),
    "extinction": Parameter(
        0.09, low=0.0, high=1.0, help="extinction coefficient at density 1, 1/m"
    ),
    "collimation": Parameter(0.9, low=0.0, high=1.0, help="collimation of the fog; 1 for no blur"),
}

# Meters. The street runs along −z between houses at x = ±HOUSES; the road is where |x| < ROAD.
HOUSES, ROAD, NEAR, FAR = 6.0, 3.4, 6.0, -66.0
CURB = 0.12
LAMP_HEIGHT, ARM, LAMP_SPACING, LAMPS = 3.9, 0.9, 6.3, 9
BULB = 0.13
WOMAN: Vector = (-0.95, 0.0, -5.2)
MAN: Vector = (0.9, 0.0, -11.0)
TREE: Vector = (4.6, CURB, -10.4)
# Number of leaves, half the size of a leaf, and half axes of the crown.
LEAVES, LEAF, CROWN = 900, 0.11, (1.35, 1.1, 1.35)
CROWN_HEIGHT = 3.6
MASK_SIDE, MASK_EDGE = 64, 1.15  # texels, and the leaf's coordinate at their edge
STORY, WINDOW_PITCH = 2.9, 2.3
LIT = 0.38  # fraction of the windows that are lit

NIGHT: RGB = (0.010, 0.015, 0.028)
# Radiance that arrives in the fog from walls and other fog: the mean of a path-traced picture.
AROUND: RGB = (0.177, 0.137, 0.084)
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
    """A house on the left (side −1) or right (side 1) of the street, between two z in meters.

    `paint` is the index of its color in `PLASTER`.
    """

    side: int
    near: float
    far: float
    stories: int
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
    """Return the street with houses, lamps, a tree and two people, in the fog."""
    windows = np.random.default_rng([seed, 0])
    objects = (
        *_ground(detail),
        *_houses(windows),
        *_lamps(detail),
        *woman(detail).transformed(_at(WOMAN, 200)).objects("woman", DRESS),
        *man(detail).transformed(_at(MAN, 15)).objects("man", COAT),
        *_tree(np.random.default_rng([seed, 1]), detail),
    )
    # The box ends inside the houses and the ground, so that no surface coincides with its faces.
    low, high = (-HOUSES - 0.5, -0.5, FAR - 0.5), (HOUSES + 0.5, 11.0, NEAR - 0.5)
    fog = Medium(
        extinction=extinction,
        low=low,
        high=high,
        albedo=(0.90, 0.90, 0.90),
        anisotropy=0.4,
        ambient=AROUND,
        collimation=collimation,
        density=sample_density(_density, low, high, (16, 16, 96)),
    )
    return Scene(
        name=name,
        camera=Camera(position=(0.2, 1.6, 0.0), target=(0.25, 2.0, -12), fov_y=math.radians(48)),
        objects=objects,
        lights=(*_beams(), EnvironmentLight(NIGHT)),
        medium=fog,
        full_samples=112,
    )


def _density(points: Floats) -> Floats:
    """Return a density that rises between 1 and 22 m from the camera and falls with height."""
    x, y, z = np.moveaxis(points, -1, 0)
    away = np.clip((-z - 1.0) / 21.0, 0, 1)
    banks = 1 + 0.25 * np.sin(0.9 * x + 0.35 * z) * np.cos(0.23 * z + 1.0)
    return np.asarray((0.10 + 0.70 * away) * banks * (0.55 + 0.45 * np.exp(-y / 3.0)))


def _at(place: Vector, degrees: float) -> Floats:
    """Return the (4, 4) matrix that turns about the y axis and moves to `place`."""
    return np.asarray(translation(place) @ rotation((0, 1, 0), math.radians(degrees)))


def _ground(detail: float) -> tuple[Object, ...]:
    """Return the road between two sidewalks."""
    middle, half = (NEAR + FAR) / 2, (NEAR - FAR) / 2
    road = grid((0, 0, middle), (ROAD, 0, 0), (0, 0, -half), divisions(8, detail), 24)
    walks = [
        slab((-HOUSES, -0.05, FAR), (-ROAD, CURB, NEAR)),
        slab((ROAD, -0.05, FAR), (HOUSES, CURB, NEAR)),
    ]
    return (
        Object("road", road, ASPHALT, casts=False),
        Object("pavements", merge(walks), STONE, casts=False),
    )


def _houses(random: np.random.Generator) -> tuple[Object, ...]:
    """Return the houses and their windows, of which a random choice is lit."""
    walls: dict[int, list[Mesh]] = {paint: [] for paint in range(len(PLASTER))}
    places: dict[tuple[str, int], list[Vector]] = {}
    for house in ROW:
        inner, outer = HOUSES * house.side, (HOUSES + 4) * house.side
        low, high = min(inner, outer), max(inner, outer)
        top = 0.8 + STORY * house.stories
        walls[house.paint].append(slab((low, 0, house.far), (high, top, house.near)))
        count = int((house.near - house.far) / WINDOW_PITCH)
        for index, story in itertools.product(range(count), range(house.stories)):
            z = house.near - (index + 0.5) * (house.near - house.far) / count
            kind = "dark" if random.random() > LIT else str(random.choice(["warm", "warm", "cool"]))
            places.setdefault((kind, house.side), []).append((inner, 1.9 + STORY * story, z))
    objects = [
        Object(f"houses {paint}", merge(meshes), Material(albedo=PLASTER[paint]), casts=False)
        for paint, meshes in walls.items()
    ]
    for kind, material in (("warm", WARM), ("cool", COOL), ("dark", DARK)):
        panes = [
            repeated(_pane(side), spots) for (found, side), spots in places.items() if found == kind
        ]
        if panes:
            objects.append(Object(f"{kind} windows", merge(panes), material, casts=False))
    bars = [repeated(_bars(side), spots) for (_, side), spots in places.items()]
    objects.append(Object("sills and bars", merge(bars), STONE, casts=False))
    end = grid((0, 6, FAR), (HOUSES + 4, 0, 0), (0, 6, 0))
    objects.append(Object("end of the street", end, Material(albedo=PLASTER[1]), casts=False))
    return tuple(objects)


def _pane(side: int) -> Mesh:
    """Return the pane of a window about the origin, on the wall of one side of the street."""
    return grid((-0.01 * side, 0, 0), (0, 0, 0.5 * side), (0, 0.8, 0))


def _bars(side: int) -> Mesh:
    """Return the sill and the bars of a window about the origin."""
    bar, ledge = sorted((0.0, -0.05 * side)), sorted((0.0, -0.16 * side))
    return merge(
        [
            slab((ledge[0], -0.9, -0.6), (ledge[1], -0.8, 0.6)),
            slab((bar[0], -0.8, -0.03), (bar[1], 0.8, 0.03)),
            slab((bar[0], 0.22, -0.5), (bar[1], 0.27, 0.5)),
        ]
    )


def _lamp_places() -> list[tuple[int, float]]:
    """Return the side and the z of each lamp; left and right alternate."""
    return [(1 if index % 2 else -1, -6.0 - LAMP_SPACING * index) for index in range(LAMPS)]


def _lamps(detail: float) -> tuple[Object, ...]:
    """Return the posts, and the bulbs as an object of their own because they glow."""
    posts, bulbs = [], []
    # Far lamps are small in the picture and need fewer triangles.
    for index, (side, z) in enumerate(_lamp_places()):
        fineness = detail / (1 + 0.5 * index)
        turn = 0 if side < 0 else 180
        foot = (4.0 * side, CURB, z)
        posts.append(transform(lamp_post(LAMP_HEIGHT, ARM, fineness), _at(foot, turn)))
        bulbs.append(globe(_bulb(side, z), BULB, fineness))
    return (
        Object("lamp posts", merge(posts), IRON),
        Object("bulbs", merge(bulbs), BULB_LIGHT, casts=False),
    )


def _bulb(side: int, z: float) -> Vector:
    """Return the center of a bulb; half of the bulb is below its shade."""
    return ((4.0 - ARM) * side, CURB + LAMP_HEIGHT, z)


def _beams() -> tuple[SpotLight, ...]:
    """Return spot lights just below the bulbs of the first two lamps."""
    lights = []
    for side, z in _lamp_places()[:2]:
        x, y, _ = _bulb(side, z)
        lights.append(
            SpotLight(
                position=(x, y - BULB - 0.03, z),
                target=(x - 0.45 * side, 0.0, z),
                intensity=(150.0, 118.0, 75.0),
                angle=math.radians(145),
            )
        )
    return tuple(lights)


def _tree(random: np.random.Generator, detail: float) -> tuple[Object, ...]:
    """Return a small street tree: a trunk with boughs, and a crown of leaf cards."""
    trunk = smooth_curve([(0.13, 0), (0.09, 0.5), (0.07, 2.2), (0.05, 3.2)], 8)
    slices = divisions(12, detail, 6)
    wood = [transform(lathe(trunk, slices), translation(TREE))]
    foot = np.asarray(TREE)
    for angle in np.linspace(0, 2 * math.pi, 7)[:-1]:
        x, z = TREE[0] + 0.8 * math.cos(angle), TREE[2] + 0.8 * math.sin(angle)
        y = TREE[1] + 3.3 + 0.5 * math.sin(3 * angle)
        wood.append(limb((TREE[0], TREE[1] + 2.3, TREE[2]), (x, y, z), 0.05, 0.015, detail))
    count = copies(LEAVES, detail)
    outward = random_directions(random, count)
    reach = 0.25 + 0.75 * random.random((count, 1)) ** 0.5
    centers = foot + [0, CROWN_HEIGHT, 0] + np.asarray(CROWN) * outward * reach
    tips = outward + 0.7 * random.normal(size=(count, 3))
    size = LEAF * enlargement(LEAVES, count)  # fewer leaves are larger: the crown stays as dense
    placements = card_frames(centers, tips, random.normal(size=(count, 3)), size, size)
    cards = scatter(quad((0, 0, 0), (1, 0, 0), (0, 1, 0)), placements)
    mask = leaf_mask(trefoil, MASK_SIDE, MASK_EDGE)
    leaves = Material(coverage=mask, albedo=LEAF_GREEN, binary_coverage=True)
    return Object("tree", merge(wood), BARK), Object("leaves", cards, leaves)
