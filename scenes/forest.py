"""A path through a misty forest against the morning sun: thousands of cards of twigs and ferns.

Stands for scene FOREST in figures 1 (right), 6 and 7 and table 1 of Salvi et al. 2011, "Adaptive
Transparency".

Parameters
----------
detail : float
    Factor on the number of triangles and cards; fewer cards are larger.
seed : int
    Seed of trees and undergrowth.
near : float
    Distance of the near plane from the camera, m. The nearest leaves are 2.5 to 3 m away.

A card shows a whole twig, the frond of a fern or a tuft of grass, drawn once with smooth edges into
a texture of coverage: foliage is composited, not tested against a threshold. Depth complexity is
moderate, up to some 45, but it spreads over 60 m, and most slices of an even division are empty.
Light is baked in: the sun with the shadow of all foliage, the glow of leaves before it, the sky,
and mist that thickens with distance.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from oitbench.modeling.baking import Rig, diffuse, normals_of, tint, with_radiance
from oitbench.modeling.detail import DETAIL, copies, divisions, enlargement
from oitbench.modeling.mesh import grid, triangle_areas
from oitbench.modeling.placement import merge
from oitbench.modeling.props.sprays import Growth, bent_cards, frond, grass, twig
from oitbench.modeling.tubes import tubes
from oitbench.modeling.voxels import density
from oitbench.parameters import Parameter
from oitbench.scene import RGB, WHITE, Camera, Floats, Material, Mesh, Object, Scene, unit

subject = "foliage"
quick = False
near = 2.2
parameters = {
    "detail": DETAIL,
    "seed": Parameter(1, low=0, help="seed of trees and undergrowth"),
}

CAMERA = Camera(position=(0.0, 1.65, 0.0), target=(0.1, 2.35, -12.0), fov_y=math.radians(50))
SUN = Rig((-0.30, 0.50, -0.70), (3.6, 2.9, 1.7), (0.40, 0.50, 0.52), (0.14, 0.15, 0.07))
MIST, GLOW = np.array([0.52, 0.58, 0.50]), np.array([0.46, 0.36, 0.16])
CLEAR, MIST_LENGTH = 6.0, 38.0  # meters without mist, and the distance that dims by 1/e
FAR = 80.0
LOW, HIGH, CELL = (-40.0, 0.0, -76.0), (40.0, 18.0, 8.0), 0.8  # the box of the forest, meters
DAPPLES = (0.15, 1.0, 0.15)
BARK: RGB = (0.20, 0.155, 0.12)
EARTH: tuple[RGB, ...] = ((0.13, 0.085, 0.045), (0.26, 0.17, 0.085), (0.13, 0.19, 0.05))
TRANSMITTED = np.array([1.15, 1.15, 0.40])
"""Factor on the light that leaves pass rather than reflect."""
TREES, SPACING, PATH = 86, 2.4, 1.7  # number, least distances between trees and from the path
LEAVES = 148  # cards of a tree
SAPLINGS, FERNS, TUFTS = 112, 200, 560


def build(*, name: str, detail: float, seed: int) -> Scene:
    """Return the sky, the ground, trunks with boughs, and the cards of each kind."""
    streams = [np.random.default_rng([seed, index]) for index in range(4)]
    wood, crowns = _trees(streams[0], detail)
    growths = (*crowns, *_undergrowth(streams[1], detail))
    placed = [
        (growth, bent_cards(streams[2], growth, enlargement(LEAVES, copies(LEAVES, detail))))
        for growth in growths
    ]
    light = _Light(streams[3], placed)
    opaque = {"sky": _sky(), "ground": light.ground(_ground(detail)), "trees": light.wood(wood)}
    objects = [Object(key, mesh, Material(emission=WHITE)) for key, mesh in opaque.items()]
    for growth, cards in placed:
        material = Material(coverage=growth.spray.coverage, emission=growth.spray.color)
        objects.append(Object(growth.name, light.leaves(growth, cards), material))
    return Scene(name, CAMERA, tuple(objects))


def _path(z: Floats) -> Floats:
    """Return x of the middle of the path."""
    return np.asarray(0.35 - 0.9 * np.sin(z / 9.0) * np.clip(-z / 10, 0, 1))


def _places(random: np.random.Generator, count: int, gap: float, path: float) -> Floats:
    """Return random places (x, 0, z) before the camera, `gap` meters apart, beside the path."""
    z = -4.5 - 62.0 * random.random(40 * count) ** 1.5
    x = random.uniform(-1, 1, len(z)) * (2.0 - 0.85 * z)
    beside = np.abs(x - _path(z)) > path
    found = np.empty((0, 3))
    for place in np.stack([x, 0 * x, z], axis=1)[beside]:
        if len(found) == count:
            break
        if (np.linalg.norm(found - place, axis=1) > gap).all():
            found = np.concatenate([found, place[None]])
    return found


def _trees(random: np.random.Generator, detail: float) -> tuple[Mesh, tuple[Growth, ...]]:
    """Return trunks with their boughs, and the foliage of two kinds of trees."""
    feet = _places(random, TREES, SPACING, PATH)
    feet = np.concatenate([[[-2.9, 0, -6.2], [3.6, 0, -8.4]], feet])
    sides = divisions(14, detail, 5)
    trunks, boughs, widths = [], [], []
    sets: dict[int, list[Floats]] = {0: [], 1: []}
    for number, foot in enumerate(feet):
        height = random.uniform(9.5, 15.0)
        radius = 0.013 * height * random.uniform(0.8, 1.35)
        lean = np.array([*(0.05 * height * random.normal(size=2)), 0.0])[[0, 2, 1]]
        level = np.linspace(0, 1, 12)[:, None]
        curve = foot - [0, 0.1, 0] + level * [0, height, 0] + lean * level**2
        curve = curve + 0.05 * np.sin(5 * level + random.uniform(0, 6, 3)) * [1, 0, 1]
        taper = radius * (1 - 0.85 * level[:, 0]) + 0.9 * radius * np.exp(-level[:, 0] * 26)
        trunks.append((curve, taper))
        count = 15
        starts = random.uniform(0.24, 0.97, count)
        turn = random.uniform(0, 2 * math.pi, count)
        outward = np.stack([np.cos(turn), random.uniform(0.05, 0.7, count), np.sin(turn)], axis=1)
        reach = (0.8 + 3.0 * (1 - starts)) * random.uniform(0.7, 1.2, count)
        at = np.linspace(0, 1, 5)[None, :, None]
        roots = np.stack([np.interp(starts, level[:, 0], column) for column in curve.T], axis=1)
        limbs = roots[:, None] + reach[:, None, None] * outward[:, None] * at
        limbs[..., 1] -= 0.16 * reach[:, None] * at[..., 0] ** 2
        boughs.append(limbs)
        widths.append(np.outer(0.26 * radius * (1.1 - starts), [1, 0.7, 0.5, 0.3, 0.1]))
        number_of_cards = copies(LEAVES, detail)
        which = random.integers(count, size=number_of_cards)
        along = random.uniform(0.22, 1.0, number_of_cards)
        step = np.minimum((along * 4).astype(int), 3)
        part = (along * 4 - step)[:, None]
        base = limbs[which, step] * (1 - part) + limbs[which, step + 1] * part
        tip = outward[which] + 0.75 * random.normal(size=base.shape) + [0, -0.15, 0]
        sets[number % 2].append(np.concatenate([base, tip], axis=1))
    wood = [
        tubes(np.array([curve for curve, _ in trunks]), np.array([r for _, r in trunks]), sides),
        tubes(np.concatenate(boughs), np.concatenate(widths), max(3, sides // 3)),
    ]
    kinds = (
        (
            "beech",
            (0.62, 0.62),
            ((0.07, 0.19, 0.03), (0.16, 0.32, 0.05), (0.36, 0.44, 0.08)),
            190,
            (0.075, 0.13),
        ),
        (
            "birch",
            (0.58, 0.58),
            ((0.12, 0.24, 0.05), (0.26, 0.38, 0.08), (0.50, 0.50, 0.12)),
            340,
            (0.05, 0.08),
        ),
    )
    growths = []
    for key, (label, half, colors, leaves, size) in enumerate(kinds):
        rows = random.permutation(np.concatenate(sets[key]))
        uppers = [0, 0.7, 0.3] + 0.8 * random.normal(size=(len(rows), 3))
        spray = twig(random, leaves, size)
        growths.append(Growth(label, rows[:, :3], rows[:, 3:], uppers, half, colors, spray))
    return merge(wood), tuple(growths)


def _undergrowth(random: np.random.Generator, detail: float) -> Iterator[Growth]:
    """Yield saplings, ferns and grass."""
    kinds = (
        ("saplings", SAPLINGS, 24, (0.30, 0.30), 1.5, ((0.10, 0.26, 0.05), (0.30, 0.44, 0.08))),
        ("ferns", FERNS, 11, (0.19, 0.46), 1.0, ((0.06, 0.20, 0.05), (0.20, 0.40, 0.09))),
        ("grass", TUFTS, 3, (0.30, 0.26), 0.75, ((0.12, 0.24, 0.05), (0.34, 0.42, 0.12))),
    )
    for label, plants, cards, half, path, colors in kinds:
        places = _places(random, plants, 0.35, path)
        count = copies(len(places) * cards, detail)
        feet = places[random.integers(len(places), size=count)]
        turn = random.uniform(0, 2 * math.pi, count)
        level = np.stack([np.cos(turn), 0 * turn, np.sin(turn)], axis=1)
        if label == "saplings":
            up = random.random((count, 1)) ** 0.7
            feet = feet + [0, 1.9, 0] * up + 0.35 * random.normal(size=feet.shape) * [1, 0, 1]
            tips = level + [0, 0.9, 0] * up
            uppers = np.add(random.normal(size=feet.shape), (0, 0.5, 0))
            spray = twig(random, 170, (0.085, 0.13))
        elif label == "ferns":
            tips, uppers = np.add(level, (0, 1.1, 0)), [0, 0.8, 0] - level
            spray = frond(random)
        else:
            tips, uppers = [0, 1, 0] + 0.15 * level, level[:, [2, 1, 0]]
            feet = feet + 0.25 * random.normal(size=feet.shape) * [1, 0, 1]
            spray = grass(random)
        bend = 0.32 if label == "ferns" else 0.11
        yield Growth(label, feet, tips, uppers, half, colors, spray, bend)


class _Light:
    """The sun and the sky behind all cards, and the mist before everything.

    A card counts with the area that its leaves cover, so that fewer and larger cards shade as much.
    """

    def __init__(self, random: np.random.Generator, placed: list[tuple[Growth, Mesh]]) -> None:
        self._random = random
        points, weights = [], []
        for growth, cards in placed:
            corners = cards.positions.reshape(-1, 6, 3)
            mix = random.dirichlet(np.ones(6), (len(corners), 10))
            points.append((mix @ corners).reshape(-1, 3))
            covered = growth.spray.coverage.texels.mean() * triangle_areas(cards)
            weights.append(covered.reshape(len(corners), -1).sum(axis=1).repeat(10) / 10)
        spots, leafy = np.concatenate(points), np.concatenate(weights)
        leaves = density(spots, leafy, LOW, HIGH, CELL)
        self._sun = leaves.integral_toward(SUN.direction)
        self._up = leaves.integral_toward((0.05, 1, 0.02))
        fallen = spots - spots[:, 1:2] / SUN.direction[1] * SUN.direction
        self._dapples = density(fallen, leafy, LOW, (HIGH[0], 1.0, HIGH[2]), DAPPLES)

    def sun(self, points: Floats) -> Floats:
        return np.exp(-0.30 * self._sun.at(points))[:, None]

    def sky(self, points: Floats) -> Floats:
        return np.exp(-0.22 * self._up.at(points))[:, None]

    def ground(self, mesh: Mesh) -> Mesh:
        """Return the ground: litter, moss and a trodden path, with dapples of the sun."""
        points = mesh.positions
        x, z = points[:, 0], points[:, 2]
        mottled = (
            0.5 + 0.25 * np.sin(2.1 * x + 1.7 * np.sin(1.3 * z)) + 0.25 * np.sin(5.2 * z - 3 * x)
        )
        path = np.exp(-(((x - _path(z)) / 0.8) ** 2))
        color = tint(np.clip(mottled * (1 - path), 0, 1), EARTH)
        color = color + (np.array([0.34, 0.26, 0.17]) - color) * 0.75 * path[:, None]
        lit = np.exp(-1.1 * self._dapples.at(points * [1, 0, 1]))[:, None]
        return self._seen(mesh, color * diffuse(normals_of(mesh), SUN, lit, self.sky(points)))

    def wood(self, mesh: Mesh) -> Mesh:
        """Return trunks and boughs with furrows along the bark."""
        points, normals = mesh.positions, normals_of(mesh)
        furrows = 1 + 0.4 * np.sin(
            normals[:, 0] * 9 + points[:, 2] + 0.7 * np.sin(4 * points[:, 1])
        )
        lit = self.sun(points + 0.5 * SUN.direction)
        moss = np.exp(-points[:, 1:2] / 0.5) * 0.6
        color = np.asarray(BARK) * furrows[:, None] * (1 - moss) + moss * [0.10, 0.15, 0.04]
        return self._seen(mesh, color * diffuse(normals, SUN, lit, self.sky(points) + 0.15))

    def leaves(self, growth: Growth, cards: Mesh) -> Mesh:
        """Return cards that reflect the sun from behind the viewer, and glow before it."""
        normals, points = normals_of(cards), cards.positions
        facing = normals @ SUN.direction
        toward_eye = ((np.asarray(CAMERA.position) - points) * normals).sum(axis=1)
        through = (facing * toward_eye < 0)[:, None]
        sun = self.sun(points + 0.4 * SUN.direction) * (0.25 + 0.75 * np.abs(facing[:, None]))
        shades = self._random.random(len(points) // 6).repeat(6)
        light = sun * np.asarray(SUN.key) * np.where(through, TRANSMITTED, 0.7)
        sky = self.sky(points) * (0.6 + 0.4 * np.abs(normals[:, 1:2])) * np.asarray(SUN.sky)
        return self._seen(cards, tint(shades, growth.colors) * (light + 1.3 * sky))

    def _seen(self, mesh: Mesh, radiance: Floats) -> Mesh:
        offset = mesh.positions - np.asarray(CAMERA.position)
        distance = np.linalg.norm(offset, axis=1, keepdims=True)
        clear = np.exp(-np.maximum(distance - CLEAR, 0) / MIST_LENGTH)
        return with_radiance(mesh, radiance * clear + _mist(offset / distance) * (1 - clear))


def _mist(directions: Floats) -> Floats:
    """Return the radiance of the mist, which glows around the sun."""
    gap = np.arccos(np.clip(directions @ SUN.direction, -1, 1))[:, None]
    height = np.clip(directions[:, 1:2] + 0.1, 0, 1)
    return np.asarray(MIST * (0.75 + 0.4 * height) + GLOW * np.exp(-((gap / 0.55) ** 2)))


def _sky() -> Mesh:
    """Return a backdrop of mist behind all trees."""
    wall = grid((0, 20, -FAR), (100, 0, 0), (0, 40, 0), 48, 24)
    offset = wall.positions - np.asarray(CAMERA.position)
    return with_radiance(wall, _mist(unit(offset)))


def _ground(detail: float) -> Mesh:
    """Return the ground, with cells that grow with the distance."""
    plane = grid(
        (0, 0, 0), (1, 0, 0), (0, 0, -1), divisions(190, detail, 12), divisions(150, detail, 10)
    )
    far = 2.6 * (FAR / 2.6) ** ((1 - plane.positions[:, 2]) / 2)
    across = plane.positions[:, 0] * (1.5 + 1.05 * far)
    return replace(plane, positions=np.stack([across, 0 * far, -far], axis=1))
