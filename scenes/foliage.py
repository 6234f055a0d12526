"""Three potted plants in front of a sunlit wall, made of thousands of folded leaf cards.

Stands for figure 6 of McGuire & Mara 2017, "Phenomenological Transparency".

Parameters
----------
detail : float
    Factor on the number of leaves and triangles.
light : str
    "baked" for light baked into radiance, "sky" for a sun and a sky.
seed : int
    Seed of the leaves.
near : float
    Distance of the near plane from the camera, m. The ground begins at 3.4 m in the picture, and
    the nearest plant at 3.5 m.

The coverage of each leaf is a binary mask that only filtering makes smooth: opaque in the middle,
partial along the outline, empty outside. Leaves transmit nothing. Under `light=baked` a plant is
one object with its leaves in random order, five to twenty cards deep, and light through leaves is
baked in.

Under `light=sky` the sun casts shadows, the sky lights everything else, and surfaces hide the sky
from each other. A plant is then one object for each color of its leaves. Without ambient occlusion
the inside of a plant looks flat; with it, but without `inferred_ao`, leaves have bright outlines.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from oitbench.modeling.baking import (
    Rig,
    cone,
    diffuse,
    normals_of,
    sphere_chord,
    tint,
    with_radiance,
)
from oitbench.modeling.detail import DETAIL, divisions
from oitbench.modeling.mesh import grid, lathe, quad
from oitbench.modeling.placement import merge, scatter, transform, translation
from oitbench.modeling.profiles import smooth_curve
from oitbench.modeling.props.leaves import (
    Leaves,
    Plant,
    blossom,
    lance,
    leaf_card,
    leaf_mask,
    lobed,
    ovate,
    place_leaves,
)
from oitbench.modeling.surroundings import gradient_sky
from oitbench.parameters import Parameter
from oitbench.scene import (
    RGB,
    WHITE,
    Camera,
    DirectionalLight,
    Floats,
    Material,
    Mesh,
    Object,
    Scene,
    Vector,
    opposite,
)

subject = "foliage"
near = 3.0
crops = {"blossoms": (0.6, 0.12, 0.3, 0.3), "ivy": (0.34, 0.48, 0.34, 0.24)}
parameters = {
    "detail": DETAIL,
    "light": Parameter(
        "baked", choices=("baked", "sky"), help="baked into radiance, or a sun and a sky"
    ),
    "seed": Parameter(1, low=0, help="seed of the leaves"),
}

SUN = Rig(
    toward_key=(-0.62, 0.85, 0.75),
    key=(0.82, 0.74, 0.58),
    sky=(0.30, 0.36, 0.44),
    ground=(0.20, 0.17, 0.13),
)
SUN_SPREAD = math.radians(5)
BACKGROUND: RGB = (0.60, 0.52, 0.42)
# Under light=sky: irradiance of the sun, the sky, and the radius of ambient occlusion in meters.
SUNLIGHT: RGB = (1.5, 1.3, 1.0)
SKY = ((-90.0, (0.30, 0.25, 0.19)), (-5.0, (0.50, 0.46, 0.41)), (90.0, (0.95, 1.05, 1.20)))
OCCLUSION = 0.3
WALL = -0.55
COURT = (7.0, 3.2)  # half the width of floor and wall, half the height of the wall, meters
FLOOR, PLASTER, CLAY = (0.70, 0.62, 0.53), (0.88, 0.75, 0.58), (0.80, 0.40, 0.24)


LAUREL = Plant(
    "laurel",
    center=(-0.57, 0.82, -0.02),
    size=(0.40, 0.42, 0.40),
    shape=ovate,
    leaf=(0.034, 0.060),
    count=1500,
    colors=((0.06, 0.22, 0.08), (0.13, 0.36, 0.10), (0.32, 0.52, 0.13)),
)
IVY = Plant(
    "ivy",
    center=(0.06, 0.47, 0.34),
    size=(0.38, 0.27, 0.34),
    shape=lobed,
    leaf=(0.052, 0.052),
    count=900,
    colors=((0.05, 0.25, 0.17), (0.14, 0.43, 0.24), (0.48, 0.64, 0.30)),
    droop=0.9,
)
OLEANDER = Plant(
    "oleander",
    center=(0.60, 1.02, -0.06),
    size=(0.36, 0.60, 0.36),
    shape=lance,
    leaf=(0.018, 0.092),
    count=1800,
    colors=((0.10, 0.25, 0.12), (0.22, 0.42, 0.18), (0.44, 0.56, 0.26)),
    hollow=0.35,
    droop=-0.5,
)
BLOSSOMS = replace(
    OLEANDER,
    name="blossoms",
    shape=blossom,
    leaf=(0.034, 0.034),
    count=150,
    colors=((0.82, 0.16, 0.36), (0.93, 0.36, 0.52), (0.96, 0.62, 0.70)),
    hollow=0.95,
)
PLANTS = (LAUREL, IVY, OLEANDER)
# Foot, height and radius of the pot of each plant, meters.
POTS: dict[str, tuple[Vector, float, float]] = {
    "laurel": ((-0.57, 0, -0.02), 0.46, 0.25),
    "ivy": ((0.06, 0, 0.34), 0.28, 0.24),
    "oleander": ((0.60, 0, -0.06), 0.46, 0.25),
}


def build(*, name: str, detail: float, light: str, seed: int) -> Scene:
    """Return the wall, the floor, the pots and the plants."""
    camera = Camera(position=(0.25, 1.15, 4.3), target=(0.03, 0.75, 0.0), fov_y=math.radians(27.5))
    if light == "sky":
        lights = (DirectionalLight(opposite(SUN.toward_key), SUNLIGHT), gradient_sky(SKY))
        lit = _lit(detail, seed)
        return Scene(name, camera, lit, lights=lights, ambient_occlusion=OCCLUSION)
    objects = [Object("courtyard", _courtyard(detail), Material(emission=WHITE))]
    for plant in PLANTS:
        objects.append(
            Object(f"pot of {plant.name}", _shaded_pot(plant, detail), Material(emission=WHITE))
        )
    for plant, random in _streams(seed):
        material = Material(coverage=leaf_mask(plant.shape), emission=WHITE, binary_coverage=True)
        objects.append(
            Object(plant.name, _shaded_leaves(plant, place_leaves(plant, random, detail)), material)
        )
    return Scene(name=name, camera=camera, objects=tuple(objects), background=BACKGROUND)


def _lit(detail: float, seed: int) -> tuple[Object, ...]:
    """Return all objects with albedo instead of baked radiance."""
    wide, high = COURT
    floor = quad((0, 0, WALL + 2.2), (wide, 0, 0), (0, 0, -2.2))
    wall = quad((0, high, WALL), (wide, 0, 0), (0, high, 0))
    objects = [
        Object("floor", floor, Material(albedo=FLOOR), casts=False),
        Object("wall", wall, Material(albedo=PLASTER), casts=False),
    ]
    for plant in PLANTS:
        objects.append(Object(f"pot of {plant.name}", _pot(plant, detail), Material(albedo=CLAY)))
    for plant, random in _streams(seed):
        leaves, mask = place_leaves(plant, random, detail), leaf_mask(plant.shape)
        shades = np.round(leaves.shades * (len(plant.colors) - 1)).astype(int)
        for number, color in enumerate(plant.colors):
            chosen = leaves.placements[shades == number]
            if len(chosen):
                material = Material(coverage=mask, albedo=color, binary_coverage=True)
                objects.append(
                    Object(f"{plant.name} {number}", scatter(leaf_card(), chosen), material)
                )
    return tuple(objects)


def _streams(seed: int) -> Iterator[tuple[Plant, np.random.Generator]]:
    """Yield each plant with a stream of its own: none depends on the number of leaves of others."""
    for stream, plant in enumerate((*PLANTS, BLOSSOMS)):
        yield plant, np.random.default_rng([seed, stream])


def _shaded_leaves(plant: Plant, leaves: Leaves) -> Mesh:
    """Return the plant's cards with light baked in."""
    card = leaf_card()
    cards = scatter(card, leaves.placements)
    color = tint(leaves.shades, plant.colors)
    shade = _leaf_shade(plant, normals_of(cards), leaves.places.repeat(len(card.positions), axis=0))
    return with_radiance(cards, color.repeat(len(card.positions), axis=0) * shade)


def _leaf_shade(plant: Plant, normals: Floats, places: Floats) -> Floats:
    """Return the light that leaves at `places` in the unit ball reflect and transmit."""
    toward = SUN.direction / np.asarray(plant.size)
    chord = sphere_chord(places, toward / np.linalg.norm(toward), (0, 0, 0), 1.05)
    lit = np.exp(-1.5 * np.maximum(chord - 0.15, 0))[:, None]
    openness = np.clip(np.linalg.norm(places, axis=1, keepdims=True), 0.2, 1) ** 2
    front = diffuse(normals, SUN, lit, openness)
    through = diffuse(-normals, SUN, lit, 0.0) * [0.75, 0.70, 0.25]
    return np.asarray(1.02 * front + through)


def _pot(plant: Plant, detail: float) -> Mesh:
    """Return a terracotta pot with a rim, filled with earth."""
    foot, height, radius = POTS[plant.name]
    outline = [(0, 0), (0.7, 0), (0.72, 0.04), (0.95, 0.8), (0.95, 0.8), (1.04, 0.8), (1.04, 0.82)]
    outline += [(1.04, 1), (1.0, 1), (0.94, 1), (0.94, 0.93), (0, 0.93)]
    profile = smooth_curve(np.asarray(outline) * [radius, height], divisions(80, detail, 20))
    return transform(lathe(profile, divisions(64, detail, 12)), translation(foot))


def _shaded_pot(plant: Plant, detail: float) -> Mesh:
    """Return a plant's pot with light baked in."""
    pot = _pot(plant, detail)
    points, normals = pot.positions.astype(np.float64), normals_of(pot)
    clay = np.array(CLAY) * diffuse(normals, SUN, _sunlight(points + 2e-3 * normals))
    below = np.clip((points[:, 1:2] - 0.02) / 0.2, 0, 1)
    return with_radiance(pot, clay * (0.6 + 0.4 * below))


def _courtyard(detail: float) -> Mesh:
    """Return the floor and the wall as one mesh, in the shadow of the plants and their pots."""
    columns, rows = divisions(140, detail, 24), divisions(120, detail, 20)
    wide, wall = COURT
    floor = grid((0, 0, WALL + 2.2), (wide, 0, 0), (0, 0, -2.2), columns, rows)
    back = grid((0, wall, WALL), (wide, 0, 0), (0, wall, 0), columns, rows)
    sheets = []
    for sheet, paint in ((floor, FLOOR), (back, PLASTER)):
        # Columns and rows are denser where the plants stand.
        points = sheet.positions.copy()
        points[:, 0] = wide * (0.22 * points[:, 0] / wide + 0.78 * (points[:, 0] / wide) ** 5)
        points[:, 1] *= 0.35 + 0.65 * (points[:, 1] / (2 * wall)) ** 2
        normals = normals_of(sheet)
        corner = np.where(normals[:, 1] > 0.5, points[:, 2] - WALL, points[:, 1])
        openness = 1 - 0.4 * np.exp(-corner / 0.25)[:, None]
        shade = np.asarray(paint) * diffuse(
            normals, SUN, _sunlight(points), openness * _sky(points)
        )
        placed = replace(sheet, positions=points)
        sheets.append(with_radiance(placed, shade))
    return merge(sheets)


def _sunlight(points: Floats) -> Floats:
    """Return the fraction of sunlight that passes through the plants, shape (n, 1)."""
    total = np.zeros(len(points))
    directions = cone(SUN.direction, SUN_SPREAD, 12)
    for direction in directions:
        depth = np.zeros(len(points))
        for plant in PLANTS:
            scaled = direction / np.asarray(plant.size)
            local = (points - np.asarray(plant.center)) / np.asarray(plant.size)
            chord = sphere_chord(local, scaled / np.linalg.norm(scaled), (0, 0, 0), 1.0)
            depth += 2.5 * chord
        total += np.exp(-depth) / len(directions)
    return total[:, None]


def _sky(points: Floats) -> Floats:
    """Return the fraction of the sky that the pots leave visible, shape (n, 1)."""
    seen = np.ones(len(points))
    for foot, height, radius in POTS.values():
        gap = np.hypot(points[:, 0] - foot[0], points[:, 2] - foot[2]) - 0.72 * radius
        gap = np.hypot(np.maximum(gap, 0), np.maximum(points[:, 1] - 0.5 * height, 0))
        seen *= 1 - 0.55 * np.exp(-gap / 0.10)
    return seen[:, None]
