"""Three potted plants before a sunlit wall, made of thousands of folded leaf cards.

Each leaf is a card with a binary mask as its coverage, anti-aliased only by filtering: opaque in
its middle, partly covering along its outline, empty beyond. A plant is one object with its leaves
in random order, five to twenty cards deep. No leaf transmits: light through leaves is baked in.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from oitbench.bake import (
    Floats,
    Rig,
    cone,
    diffuse,
    normals_of,
    sphere_chord,
    tint,
    with_radiance,
)
from oitbench.geometry import (
    divisions,
    frames,
    grid,
    lathe,
    merge,
    scatter,
    smooth_curve,
    transform,
    translation,
)
from oitbench.scene import RGB, WHITE, Camera, Material, Mesh, Object, Scene, Texture
from oitbench.selector import Parameter

parameters = {
    "detail": Parameter(1.0, low=0.0, high=100.0, help="factor on the number of leaves"),
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
WALL = -0.55
TEXTURE_SIDE = 128
BORDER = 4
SUBSAMPLES = 4
# How far the halves of a leaf fold up along its midrib, and how much its tip bends down.
FOLD, BEND = 0.45, 0.22


def _ovate(x: Floats, y: Floats) -> Floats:
    """Return > 0 inside an egg-shaped leaf with a pointed tip; x and y run over [−1, 1]."""
    along = np.clip(0.5 + 0.5 * y, 0, 1)
    return np.asarray(1.35 * along**0.62 * (1 - along) ** 0.75 - np.abs(x))


def _lance(x: Floats, y: Floats) -> Floats:
    """Return > 0 inside a slender leaf, pointed at both ends."""
    return np.asarray(0.9 * np.cos(0.5 * math.pi * np.clip(y, -1, 1)) ** 1.2 - np.abs(x))


def _lobed(x: Floats, y: Floats) -> Floats:
    """Return > 0 inside a five-lobed leaf like that of ivy, with its stalk at the bottom."""
    angle = np.arctan2(x, y + 0.25)
    reach = 0.72 + 0.16 * np.cos(5 * angle) + 0.17 * np.cos(angle)
    return np.asarray(np.where(y > -1, reach - np.hypot(x, y + 0.25), -1))


def _blossom(x: Floats, y: Floats) -> Floats:
    """Return > 0 inside a flower of five round petals."""
    return np.asarray(0.74 + 0.24 * np.cos(5 * np.arctan2(x, y)) - np.hypot(x, y))


@dataclass(frozen=True)
class Plant:
    """A cloud of leaves in an ellipsoid of half axes `size` round `center`, in metres.

    `leaf` is half the width and half the length of a card, `hollow` the innermost place of a leaf
    as a fraction of the ellipsoid, and `droop` how strongly the tips hang.
    """

    name: str
    center: RGB
    size: RGB
    mask: Callable[[Floats, Floats], Floats]
    leaf: tuple[float, float]
    count: int
    colors: tuple[RGB, ...]
    hollow: float = 0.5
    droop: float = 0.4


LAUREL = Plant(
    "laurel",
    center=(-0.57, 0.82, -0.02),
    size=(0.40, 0.42, 0.40),
    mask=_ovate,
    leaf=(0.034, 0.060),
    count=1500,
    colors=((0.06, 0.22, 0.08), (0.13, 0.36, 0.10), (0.32, 0.52, 0.13)),
)
IVY = Plant(
    "ivy",
    center=(0.06, 0.47, 0.34),
    size=(0.38, 0.27, 0.34),
    mask=_lobed,
    leaf=(0.052, 0.052),
    count=900,
    colors=((0.05, 0.25, 0.17), (0.14, 0.43, 0.24), (0.48, 0.64, 0.30)),
    droop=0.9,
)
OLEANDER = Plant(
    "oleander",
    center=(0.60, 1.02, -0.06),
    size=(0.36, 0.60, 0.36),
    mask=_lance,
    leaf=(0.018, 0.092),
    count=1800,
    colors=((0.10, 0.25, 0.12), (0.22, 0.42, 0.18), (0.44, 0.56, 0.26)),
    hollow=0.35,
    droop=-0.5,
)
BLOSSOMS = replace(
    OLEANDER,
    name="blossoms",
    mask=_blossom,
    leaf=(0.034, 0.034),
    count=150,
    colors=((0.82, 0.16, 0.36), (0.93, 0.36, 0.52), (0.96, 0.62, 0.70)),
    hollow=0.95,
)
PLANTS = (LAUREL, IVY, OLEANDER)
# Foot and height of the pot of each plant, and its radius at the rim, in metres.
POTS: dict[str, tuple[RGB, float, float]] = {
    "laurel": ((-0.57, 0, -0.02), 0.46, 0.25),
    "ivy": ((0.06, 0, 0.34), 0.28, 0.24),
    "oleander": ((0.60, 0, -0.06), 0.46, 0.25),
}


def build(*, name: str, detail: float, seed: int) -> Scene:
    """Return wall, floor, pots and plants."""
    camera = Camera(position=(0.25, 1.15, 4.3), target=(0.03, 0.75, 0.0), fov_y=math.radians(27.5))
    objects = [Object("courtyard", _courtyard(detail), Material(emission=WHITE))]
    for plant in PLANTS:
        objects.append(
            Object(f"pot of {plant.name}", _pot(plant, detail), Material(emission=WHITE))
        )
    for stream, plant in enumerate((*PLANTS, BLOSSOMS)):
        # A stream of its own, so that no plant changes with the others' numbers of leaves.
        random = np.random.default_rng([seed, stream])
        material = Material(coverage=_mask(plant), emission=WHITE, binary_coverage=True)
        objects.append(Object(plant.name, _leaves(plant, random, detail), material))
    return Scene(name=name, camera=camera, objects=tuple(objects), background=BACKGROUND)


def _mask(plant: Plant) -> Texture:
    """Return the leaf's outline, averaged from subsamples, inside an empty border."""
    side = TEXTURE_SIDE * SUBSAMPLES
    line = ((np.arange(side) + 0.5) / side * 2 - 1) / (1 - 2 * BORDER / TEXTURE_SIDE)
    x, y = np.meshgrid(line, line[::-1])
    inside = (plant.mask(x, y) > 0) & (np.maximum(np.abs(x), np.abs(y)) <= 1)
    blocks = inside.reshape(TEXTURE_SIDE, SUBSAMPLES, TEXTURE_SIDE, SUBSAMPLES)
    return Texture(blocks.mean(axis=(1, 3)).astype(np.float32))


def _card() -> Mesh:
    """Return a leaf of half-size 1 in the xy plane, folded along its midrib and bent lengthwise."""
    halves = []
    for side in (-1.0, 1.0):
        half = grid((0.5 * side, 0, 0), (0.5, 0, 0), (0, 1, 0), 1, 2)
        x, y = half.positions[:, 0], half.positions[:, 1]
        bent = np.stack([x, y, FOLD * np.abs(x) - BEND * y**2], axis=1)
        normals = np.stack([np.full_like(x, -FOLD * side), 2 * BEND * y, np.ones_like(x)], axis=1)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        uvs = 0.5 + 0.5 * half.positions[:, :2]
        halves.append(replace(half, positions=bent, normals=normals, uvs=uvs))
    return merge(halves)


def _leaves(plant: Plant, random: np.random.Generator, detail: float) -> Mesh:
    """Return the plant's cards: tips outwards and drooping, upper sides towards the sky."""
    count = max(8, round(plant.count * detail))
    outward = random.normal(size=(count, 3))
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    lumps = 1 + 0.10 * np.sin(outward @ np.array([4.1, 5.7, 3.2]) + 0.5)
    depth = plant.hollow + (1 - plant.hollow) * random.random(count) ** 0.6
    places = depth[:, None] * outward
    centers = np.asarray(plant.center) + np.asarray(plant.size) * places * lumps[:, None]
    tips = outward - plant.droop * np.array([0.0, 1.0, 0.0]) + 0.5 * random.normal(size=(count, 3))
    upper = 0.6 * outward + np.array([0.0, 0.7, 0.15]) + 0.4 * random.normal(size=(count, 3))
    tips /= np.linalg.norm(tips, axis=1, keepdims=True)
    rights = np.cross(tips, upper)
    rights /= np.linalg.norm(rights, axis=1, keepdims=True)
    # Fewer leaves are larger ones, so that the plants stay as dense.
    scale = random.uniform(0.75, 1.2, (count, 1)) * max(1.0, math.sqrt(plant.count / count))
    width, length = plant.leaf
    card = _card()
    cards = scatter(card, frames(centers, scale * width * rights, scale * length * tips))
    color = tint(random.random(count) ** 1.3, plant.colors)
    shade = _leaf_shade(plant, normals_of(cards), places.repeat(len(card.positions), axis=0))
    return with_radiance(cards, color.repeat(len(card.positions), axis=0) * shade)


def _leaf_shade(plant: Plant, normals: Floats, places: Floats) -> Floats:
    """Return light on, through and from the gloss of leaves at `places` in the unit ball."""
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
    pot = transform(lathe(profile, divisions(64, detail, 12)), translation(foot))
    points, normals = pot.positions.astype(np.float64), normals_of(pot)
    clay = np.array([0.80, 0.40, 0.24]) * diffuse(normals, SUN, _sunlight(points + 2e-3 * normals))
    below = np.clip((points[:, 1:2] - 0.02) / 0.2, 0, 1)
    return with_radiance(pot, clay * (0.6 + 0.4 * below))


def _courtyard(detail: float) -> Mesh:
    """Return floor and wall in one sheet, shaded by the plants and their pots."""
    columns, rows = divisions(140, detail, 24), divisions(120, detail, 20)
    wide, wall = 7.0, 3.2
    floor = grid((0, 0, WALL + 2.2), (wide, 0, 0), (0, 0, -2.2), columns, rows)
    back = grid((0, wall, WALL), (wide, 0, 0), (0, wall, 0), columns, rows)
    sheets = []
    for sheet, paint in ((floor, (0.70, 0.62, 0.53)), (back, (0.88, 0.75, 0.58))):
        # Columns and rows crowd where the plants stand.
        points = sheet.positions.astype(np.float64)
        points[:, 0] = wide * (0.22 * points[:, 0] / wide + 0.78 * (points[:, 0] / wide) ** 5)
        points[:, 1] *= 0.35 + 0.65 * (points[:, 1] / (2 * wall)) ** 2
        normals = normals_of(sheet)
        corner = np.where(normals[:, 1] > 0.5, points[:, 2] - WALL, points[:, 1])
        openness = 1 - 0.4 * np.exp(-corner / 0.25)[:, None]
        shade = np.asarray(paint) * diffuse(
            normals, SUN, _sunlight(points), openness * _sky(points)
        )
        placed = replace(sheet, positions=points.astype(np.float32))
        sheets.append(with_radiance(placed, shade))
    return merge(sheets)


def _sunlight(points: Floats) -> Floats:
    """Return the fraction of sunlight that passes the plants and pots, shape (n, 1)."""
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
    """Return the fraction of the sky seen past the pots, shape (n, 1)."""
    seen = np.ones(len(points))
    for foot, height, radius in POTS.values():
        gap = np.hypot(points[:, 0] - foot[0], points[:, 2] - foot[2]) - 0.72 * radius
        gap = np.hypot(np.maximum(gap, 0), np.maximum(points[:, 1] - 0.5 * height, 0))
        seen *= 1 - 0.55 * np.exp(-gap / 0.10)
    return seen[:, None]
