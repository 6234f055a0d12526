"""Clouds of soft particles: their places, their orientation and their material."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from oitbench.modeling.placement import random_directions
from oitbench.scene import Floats, Material, Sprites, Texture, Vector

TEXTURE_SIDE = 128
"""Texels along a side of a particle's coverage."""
BORDER = 3
"""Empty texels around the disc, so that no filter cuts it off."""


def smoke(alpha: float, albedo: float, nominal: int, count: int) -> Material:
    """Return the material of `count` particles that scatter light equally to all sides.

    Parameters
    ----------
    alpha : float
        Coverage at the middle of a particle if there are `nominal` particles.
    albedo : float
        Fraction of the covered light that is scattered, in [0, 1].
    nominal, count : int
        As in `shared_coverage`.
    """
    return Material(
        coverage=puff(shared_coverage(alpha, nominal, count)),
        albedo=(albedo, albedo, albedo),
        isotropic=True,
    )


def puff(alpha: float) -> Texture:
    """Return a soft, wispy disc of coverage that is at most `alpha`, and 0 at its border."""
    line = (np.arange(TEXTURE_SIDE) + 0.5) / TEXTURE_SIDE * 2 - 1
    x, y = np.meshgrid(line, line)
    distance = np.hypot(x, y) / (1 - 2 * BORDER / TEXTURE_SIDE)
    disc = np.maximum(1 - distance**2, 0) ** 1.5
    wisp = 0.5 + 0.5 * np.sin(5.0 * x + 2.3 * np.sin(4.1 * y + 0.7) + 0.4)
    wisp = 0.5 * wisp + 0.25 + 0.25 * np.sin(6.3 * y - 2.9 * np.sin(5.2 * x + 2.0))
    return Texture((alpha * disc * (0.65 + 0.35 * wisp)).astype(np.float32))


def shared_coverage(alpha: float, nominal: int, count: int) -> float:
    """Return the coverage at which `count` particles are as thick as `nominal` ones of `alpha`.

    The factors 1 − α of layers multiply, so that the optical depth ln(1 − α) is shared out.
    """
    return float(1 - (1 - alpha) ** (nominal / count))


def fill(
    random: np.random.Generator,
    count: int,
    centers: npt.ArrayLike,
    radii: npt.ArrayLike,
    stretch: Vector = (1.0, 1.0, 1.0),
) -> Floats:
    """Return random points in several balls, in random order.

    Parameters
    ----------
    random : Generator
    count : int
        Number of points.
    centers : array, shape (k, 3)
        Centers of the balls, meters. Each ball gets points in proportion to its volume, so that the
        points are denser where balls overlap.
    radii : array, shape (k,)
        Meters.
    stretch : Vector
        Factors along x, y and z that make each ball an ellipsoid.

    Returns
    -------
    array, shape (count, 3), float64
    """
    sizes = np.asarray(radii, dtype=np.float64)
    lobe = random.choice(len(sizes), count, p=sizes**3 / (sizes**3).sum())
    reach = sizes[lobe] * random.random(count) ** (1 / 3)
    offsets = reach[:, None] * random_directions(random, count) * np.asarray(stretch)
    return np.asarray(np.asarray(centers, dtype=np.float64)[lobe] + offsets)


def sprites(
    random: np.random.Generator,
    centers: npt.ArrayLike,
    radii: npt.ArrayLike,
    toward_light: Vector | None = None,
) -> Sprites:
    """Return squares that face the camera and a light, randomly turned in their planes.

    Parameters
    ----------
    random : Generator
    centers, radii, toward_light
        As in `Sprites`.
    """
    turns = random.uniform(0, 2 * math.pi, len(np.asarray(centers)))
    return Sprites(centers, radii, turns, toward_light)
