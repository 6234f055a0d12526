"""Plants of leaf cards: folded quadrilaterals whose coverage is the shape of a leaf.

The coverage of a texel is the average of subsamples that are 0 or 1. A new leaf is a function of x
and y that is positive inside its shape.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from oitbench.modeling.baking import tint
from oitbench.modeling.detail import copies, enlargement
from oitbench.modeling.mesh import grid
from oitbench.modeling.placement import frames, merge, random_directions, scatter
from oitbench.scene import RGB, Floats, Mesh, Texture, Vector, unit

Shape = Callable[[Floats, Floats], Floats]
"""A function of x and y in [−1, 1] that is positive inside a leaf, with the tip at y = 1."""
TEXTURE_SIDE = 128
"""Texels along a side of a mask."""
BORDER = 4
"""Empty texels along each edge of a mask."""
_SUBSAMPLES = 4
# Slope of the two halves of a leaf from its midrib upwards, and how far its tip bends down.
_FOLD, _BEND = 0.45, 0.22


def ovate(x: Floats, y: Floats) -> Floats:
    """Return the shape of an egg-shaped leaf with a pointed tip."""
    along = np.clip(0.5 + 0.5 * y, 0, 1)
    return np.asarray(1.35 * along**0.62 * (1 - along) ** 0.75 - np.abs(x))


def lance(x: Floats, y: Floats) -> Floats:
    """Return the shape of a slender leaf that is pointed at both ends."""
    return np.asarray(0.9 * np.cos(0.5 * math.pi * np.clip(y, -1, 1)) ** 1.2 - np.abs(x))


def lobed(x: Floats, y: Floats) -> Floats:
    """Return the shape of a five-lobed leaf, like that of ivy."""
    angle = np.arctan2(x, y + 0.25)
    reach = 0.72 + 0.16 * np.cos(5 * angle) + 0.17 * np.cos(angle)
    return np.asarray(np.where(y > -1, reach - np.hypot(x, y + 0.25), -1))


def blossom(x: Floats, y: Floats) -> Floats:
    """Return the shape of a flower of five round petals."""
    return np.asarray(0.74 + 0.24 * np.cos(5 * np.arctan2(x, y)) - np.hypot(x, y))


def trefoil(x: Floats, y: Floats) -> Floats:
    """Return the shape of three pointed leaves on one stalk."""
    shape = np.full_like(x, -1.0)
    for angle in (-1.0, 0.0, 1.0):
        along = math.sin(angle) * x + math.cos(angle) * (y + 0.7)
        across = math.cos(angle) * x - math.sin(angle) * (y + 0.7)
        half = 0.36 * np.sin(np.clip(along / 1.5, 0, 1) * math.pi) ** 0.8
        leaf = np.where((along > 0) & (along < 1.5), half - np.abs(across), -1.0)
        shape = np.maximum(shape, leaf)
    return shape


def leaf_mask(
    shape: Shape, side: int = TEXTURE_SIDE, edge: float = 1 / (1 - 2 * BORDER / TEXTURE_SIDE)
) -> Texture:
    """Return the coverage of a leaf: its shape, averaged from subsamples, inside an empty border.

    Parameters
    ----------
    shape : Shape
    side : int
        Width and height in texels, a power of two.
    edge : float
        The shape's coordinate at the edge of the texture, above 1. The default leaves `BORDER` of
        `TEXTURE_SIDE` texels empty.
    """
    samples = side * _SUBSAMPLES
    line = ((np.arange(samples) + 0.5) / samples * 2 - 1) * edge
    x, y = np.meshgrid(line, line[::-1])
    inside = (shape(x, y) > 0) & (np.maximum(np.abs(x), np.abs(y)) <= 1)
    blocks = inside.reshape(side, _SUBSAMPLES, side, _SUBSAMPLES)
    return Texture(blocks.mean(axis=(1, 3)).astype(np.float32))


def leaf_card() -> Mesh:
    """Return a leaf of half-size 1 in the xy plane, folded along its midrib and bent lengthwise."""
    halves = []
    for side in (-1.0, 1.0):
        half = grid((0.5 * side, 0, 0), (0.5, 0, 0), (0, 1, 0), 1, 2)
        x, y = half.positions[:, 0], half.positions[:, 1]
        bent = np.stack([x, y, _FOLD * np.abs(x) - _BEND * y**2], axis=1)
        normals = np.stack([np.full_like(x, -_FOLD * side), 2 * _BEND * y, np.ones_like(x)], axis=1)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        uvs = 0.5 + 0.5 * half.positions[:, :2]
        halves.append(Mesh.from_arrays(bent, half.triangles, normals=normals, uvs=uvs))
    return merge(halves)


def card_frames(
    centers: npt.ArrayLike,
    tips: Floats,
    uppers: Floats,
    width: npt.ArrayLike,
    length: npt.ArrayLike,
) -> Floats:
    """Return the frames of cards, for `placement.scatter`.

    Parameters
    ----------
    centers : array, shape (n, 3)
        Meters.
    tips : array, shape (n, 3)
        Directions from the stalks to the tips; need not have unit length.
    uppers : array, shape (n, 3)
        Directions of the upper sides; need not be perpendicular to `tips`.
    width, length : float or array, shape (n, 1)
        Half the width and half the length of the cards, meters.
    """
    tips = unit(tips)
    rights = unit(np.cross(tips, uppers))
    return frames(centers, np.asarray(width) * rights, np.asarray(length) * tips)


@dataclass(frozen=True)
class Plant:
    """A cloud of leaves in an ellipsoid.

    Parameters
    ----------
    name : str
    center, size : Vector
        Center and half axes of the ellipsoid, meters.
    shape : Shape
        Shape of a leaf.
    leaf : tuple of float
        Half the width and half the length of a card, meters.
    count : int
        Number of leaves at detail 1.
    colors : tuple of RGB
        Ramp of the leaves' albedo.
    hollow : float
        Radius, as a fraction of the ellipsoid's, within which there are no leaves.
    droop : float
        How strongly the tips hang down; negative for tips that point up.
    """

    name: str
    center: Vector
    size: Vector
    shape: Shape
    leaf: tuple[float, float]
    count: int
    colors: tuple[RGB, ...]
    hollow: float = 0.5
    droop: float = 0.4


@dataclass(frozen=True)
class Leaves:
    """The places of a plant's leaves.

    Parameters
    ----------
    placements : array, shape (n, 3, 4)
        Frames of the cards.
    places : array, shape (n, 3)
        Positions of the leaves if the ellipsoid were the unit ball.
    shades : array, shape (n,)
        Positions on the ramp of the plant's colors, in [0, 1].
    """

    placements: Floats
    places: Floats
    shades: Floats


def place_leaves(plant: Plant, random: np.random.Generator, detail: float) -> Leaves:
    """Place the plant's leaves: tips outwards and drooping, upper sides towards the sky.

    Fewer leaves are larger, so that the plant stays as dense.
    """
    count = copies(plant.count, detail)
    outward = random_directions(random, count)
    lumps = 1 + 0.10 * np.sin(outward @ np.array([4.1, 5.7, 3.2]) + 0.5)
    depth = plant.hollow + (1 - plant.hollow) * random.random(count) ** 0.6
    places = depth[:, None] * outward
    centers = np.asarray(plant.center) + np.asarray(plant.size) * places * lumps[:, None]
    tips = outward - plant.droop * np.array([0.0, 1.0, 0.0]) + 0.5 * random.normal(size=(count, 3))
    uppers = 0.6 * outward + np.array([0.0, 0.7, 0.15]) + 0.4 * random.normal(size=(count, 3))
    scale = random.uniform(0.75, 1.2, (count, 1)) * enlargement(plant.count, count)
    width, length = plant.leaf
    placements = card_frames(centers, tips, uppers, scale * width, scale * length)
    return Leaves(placements, places, random.random(count) ** 1.3)


def colored_cards(card: Mesh, leaves: Leaves, plant: Plant) -> Mesh:
    """Return a copy of `card` for each leaf, with its color as the factor on a white albedo."""
    cards = scatter(card, leaves.placements)
    colors = tint(leaves.shades, plant.colors).repeat(len(card.positions), axis=0)
    return replace(cards, albedo=colors.astype(np.float32))
