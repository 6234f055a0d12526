"""Blending that commutes, in double precision: sums, means and weighted means of all layers.

Layers are arrays of shape (n, h, w): `color` (..., 3) is alpha L, `opacity` is alpha (1 - mean t).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from oitbench.scene import Floats, FragmentLists


def layers_of(lists: FragmentLists) -> tuple[Floats, Floats]:
    """Return color and opacity of every fragment."""
    alpha = lists.coverage.astype(np.float64)
    color = alpha[..., None] * lists.radiance.astype(np.float64)
    opacity = alpha * (1 - lists.transmission.astype(np.float64).mean(axis=-1))
    return color, opacity


def weighted_sum(lists: FragmentLists, background: npt.ArrayLike, clamp: bool = False) -> Floats:
    """Return sum alpha L + C0 (1 - sum o); Meshkin 2007."""
    color, opacity = layers_of(lists)
    left = 1 - opacity.sum(axis=0)[..., None]
    kept = np.maximum(left, 0) if clamp else left
    return np.asarray(color.sum(axis=0) + np.asarray(background) * kept)


def weighted_average(lists: FragmentLists, background: npt.ArrayLike) -> Floats:
    """Return n layers of mean color and mean opacity; Bavoil & Myers 2008."""
    color, opacity = layers_of(lists)
    total = opacity.sum(axis=0)
    number = np.maximum((opacity > 0).sum(axis=0), 1)
    passed = (1 - total / number) ** number
    factor = np.divide(1 - passed, total, out=np.ones_like(total), where=total > 1e-4)
    mean = color.sum(axis=0) * factor[..., None]
    return np.asarray(mean + np.asarray(background) * passed[..., None])


def weight(equation: int, z: Floats, near: float = 0.1) -> Floats:
    """Return McGuire & Bavoil 2013, eq. 7 to 10, without their factor o; z in meters."""
    if equation == 10:
        return np.maximum(1e-2, 3e3 * (near / z) ** 3)
    bare = {
        7: 10 / (1e-5 + (z / 5) ** 2 + (z / 200) ** 6),
        8: 10 / (1e-5 + (z / 10) ** 3 + (z / 200) ** 6),
        9: 0.03 / (1e-5 + (z / 200) ** 4),
    }[equation]
    return np.clip(bare, 1e-2, 3e3)


def fitted_weight(z: Floats, b: float, p: float, c: float, q: float) -> Floats:
    """Return the form of eq. 7 and 8 with other ranges, m, and powers, without the factor o."""
    return np.clip(10 / (1e-5 + (z / b) ** p + (z / c) ** q), 1e-2, 3e3)


def weighted_blended(lists: FragmentLists, background: npt.ArrayLike, equation: int) -> Floats:
    """Return the picture of one of McGuire & Bavoil's weights."""
    return blended(lists, background, weight(equation, lists.z.astype(np.float64)))


def blended(lists: FragmentLists, background: npt.ArrayLike, bare: Floats) -> Floats:
    """Return the weighted mean color over the background seen through all layers.

    `bare` is the weight of each layer without the factor o.
    """
    color, opacity = layers_of(lists)
    w = opacity * bare
    mean = (w[..., None] * color).sum(axis=0)
    mean /= np.maximum((w * opacity).sum(axis=0), 1e-5)[..., None]
    passed = (1 - opacity).prod(axis=0)[..., None]
    return np.asarray(mean * (1 - passed) + np.asarray(background) * passed)
