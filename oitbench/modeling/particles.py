"""Clouds of soft particles: where they are, how they face camera and light, how dense they are."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from oitbench.modeling.mesh import Floats, frames, quad, scatter
from oitbench.scene import RGB, Camera, Mesh, Texture

TEXTURE_SIDE = 128  # texels
BORDER = 3  # empty texels round the puff, so that no filter cuts it off


def puff(alpha: float) -> Texture:
    """Return a soft, wispy disc of coverage that is `alpha` at most and 0 at its border."""
    line = (np.arange(TEXTURE_SIDE) + 0.5) / TEXTURE_SIDE * 2 - 1
    x, y = np.meshgrid(line, line)
    distance = np.hypot(x, y) / (1 - 2 * BORDER / TEXTURE_SIDE)
    disc = np.maximum(1 - distance**2, 0) ** 1.5
    wisp = 0.5 + 0.5 * np.sin(5.0 * x + 2.3 * np.sin(4.1 * y + 0.7) + 0.4)
    wisp = 0.5 * wisp + 0.25 + 0.25 * np.sin(6.3 * y - 2.9 * np.sin(5.2 * x + 2.0))
    return Texture((alpha * disc * (0.65 + 0.35 * wisp)).astype(np.float32))


def shared_coverage(alpha: float, nominal: int, count: int) -> float:
    """Return the coverage at which `count` particles are as thick as `nominal` ones of `alpha`.

    Layers multiply their 1 − α, so it is ln(1 − α), the optical depth, that is shared out.
    """
    return float(1 - (1 - alpha) ** (nominal / count))


def fill(
    random: np.random.Generator,
    count: int,
    centers: npt.ArrayLike,
    radii: npt.ArrayLike,
    stretch: RGB = (1.0, 1.0, 1.0),
) -> Floats:
    """Return random points in a union of balls, shape (count, 3), in random order.

    Parameters
    ----------
    random : Generator
    count : int
        Points to place.
    centers : array, shape (k, 3)
        Metres. A ball gets points by its volume, so balls are dense where they overlap.
    radii : array, shape (k,)
        Metres.
    stretch : RGB
        Factors that make an ellipsoid of each ball, along x, y and z.
    """
    sizes = np.asarray(radii, dtype=np.float64)
    lobe = random.choice(len(sizes), count, p=sizes**3 / (sizes**3).sum())
    reach = sizes[lobe] * random.random(count) ** (1 / 3)
    offsets = reach[:, None] * random_directions(random, count) * np.asarray(stretch)
    return np.asarray(np.asarray(centers, dtype=np.float64)[lobe] + offsets)


def random_directions(random: np.random.Generator, count: int) -> Floats:
    """Return unit vectors, shape (count, 3), evenly over the sphere."""
    directions = random.normal(size=(count, 3))
    return np.asarray(directions / np.linalg.norm(directions, axis=1, keepdims=True))


def sprites(
    random: np.random.Generator,
    centers: npt.ArrayLike,
    radii: npt.ArrayLike,
    camera: Camera,
    toward_light: RGB,
) -> Mesh:
    """Return squares, randomly turned in their planes, that face both `camera` and a light.

    They are perpendicular to the vector halfway between the two directions, so that neither sees
    them edge on: squares that face the camera alone would throw hardly a shadow from above.

    Parameters
    ----------
    random : Generator
    centers : array, shape (k, 3)
        World positions, metres.
    radii : array, shape (k,), or float
        Half the edge of each square, metres.
    camera : Camera
    toward_light : RGB
        Direction to the light; need not be a unit vector.

    References
    ----------
    Ikits et al. 2004, "Volume rendering techniques" (GPU Gems 39): half-angle slicing.
    """
    middles = np.asarray(centers, dtype=np.float64)
    size = np.broadcast_to(np.asarray(radii, dtype=np.float64), len(middles))[:, None]
    turn = random.uniform(0, 2 * math.pi, len(middles))[:, None]
    right, up = _facing(camera, toward_light)
    rights = size * (np.cos(turn) * right + np.sin(turn) * up)
    ups = size * (np.cos(turn) * up - np.sin(turn) * right)
    return scatter(quad((0, 0, 0), (1, 0, 0), (0, 1, 0)), frames(middles, rights, ups))


def _facing(camera: Camera, toward_light: RGB) -> Sequence[Floats]:
    """Return two perpendicular unit vectors in the plane that both camera and light see well."""
    light = np.asarray(toward_light, dtype=np.float64)
    light /= np.linalg.norm(light)
    right, _, back = camera.axes
    # Both sides of a square are alike, so a light behind it counts as one before it.
    half = back + light if back @ light >= 0 else back - light
    up = np.cross(half, right)
    up /= np.linalg.norm(up)
    across = np.cross(up, half)
    return across / np.linalg.norm(across), up
