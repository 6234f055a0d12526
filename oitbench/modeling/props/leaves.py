"""Plants of leaf cards: bent quads whose outlines are masks.

A mask is 0 or 1 but for the averaging of its subsamples, and so is a leaf's coverage.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from oitbench.modeling.baking import Floats
from oitbench.modeling.mesh import frames, grid, merge
from oitbench.scene import RGB, Mesh, Texture

TEXTURE_SIDE, BORDER = 128, 4
"""Texels along a side of a mask, and how many of them at its edge stay empty."""
_SUBSAMPLES = 4
# How far the halves of a leaf fold up along its midrib, and how much its tip bends down.
_FOLD, _BEND = 0.45, 0.22


def ovate(x: Floats, y: Floats) -> Floats:
    """Return > 0 inside an egg-shaped leaf with a pointed tip; x and y run over [−1, 1]."""
    along = np.clip(0.5 + 0.5 * y, 0, 1)
    return np.asarray(1.35 * along**0.62 * (1 - along) ** 0.75 - np.abs(x))


def lance(x: Floats, y: Floats) -> Floats:
    """Return > 0 inside a slender leaf, pointed at both ends."""
    return np.asarray(0.9 * np.cos(0.5 * math.pi * np.clip(y, -1, 1)) ** 1.2 - np.abs(x))


def lobed(x: Floats, y: Floats) -> Floats:
    """Return > 0 inside a five-lobed leaf like that of ivy, with its stalk at the bottom."""
    angle = np.arctan2(x, y + 0.25)
    reach = 0.72 + 0.16 * np.cos(5 * angle) + 0.17 * np.cos(angle)
    return np.asarray(np.where(y > -1, reach - np.hypot(x, y + 0.25), -1))


def blossom(x: Floats, y: Floats) -> Floats:
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


def mask_of(plant: Plant) -> Texture:
    """Return the leaf's outline, averaged from subsamples, inside an empty border."""
    side = TEXTURE_SIDE * _SUBSAMPLES
    line = ((np.arange(side) + 0.5) / side * 2 - 1) / (1 - 2 * BORDER / TEXTURE_SIDE)
    x, y = np.meshgrid(line, line[::-1])
    inside = (plant.mask(x, y) > 0) & (np.maximum(np.abs(x), np.abs(y)) <= 1)
    blocks = inside.reshape(TEXTURE_SIDE, _SUBSAMPLES, TEXTURE_SIDE, _SUBSAMPLES)
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
        halves.append(replace(half, positions=bent, normals=normals, uvs=uvs))
    return merge(halves)


@dataclass(frozen=True)
class Leaves:
    """Where a plant's leaves are: frames of cards, and places in the unit ball, shape (n, 3).

    `shades` are places on the ramp of the plant's colors, in [0, 1].
    """

    placements: Floats
    places: Floats
    shades: Floats


def place_leaves(plant: Plant, random: np.random.Generator, detail: float) -> Leaves:
    """Place the plant's leaves: tips outwards and drooping, upper sides towards the sky."""
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
    placements = frames(centers, scale * width * rights, scale * length * tips)
    return Leaves(placements, places, random.random(count) ** 1.3)
