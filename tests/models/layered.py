"""Depth-layered weighted blending in double precision."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from oitbench.scene import Floats, FragmentLists
from tests.models.commutative import layers_of


def depth_layered(lists: FragmentLists, background: npt.ArrayLike, slabs: int) -> Floats:
    """Return `slabs` weighted averages of layers, each over the next one, over the background."""
    color, opacity = layers_of(lists)
    absorbance = -np.log(np.maximum(1 - opacity, 2.0**-24))
    place = places(lists, slabs)
    total, seen = np.zeros(color.shape[1:]), np.ones(color.shape[1:-1])[..., None]
    for k in range(slabs):
        share = np.maximum(1 - abs(place - k), 0)
        part = -np.expm1(-share * absorbance)
        fraction = np.divide(part, opacity, out=share.copy(), where=opacity > 1e-4)
        light, sum_ = (color * fraction[..., None]).sum(axis=0), part.sum(axis=0)
        covered = -np.expm1(-(share * absorbance).sum(axis=0))
        factor = np.divide(covered, sum_, out=np.ones_like(sum_), where=sum_ > 1e-4)
        total += seen * light * factor[..., None]
        seen = seen * (1 - covered[..., None])
    return np.asarray(total + seen * np.asarray(background))


def places(lists: FragmentLists, slabs: int) -> Floats:
    """Return the place of each fragment among the middles of slabs 0 to `slabs` - 1."""
    z, dark = lists.z.astype(np.float64), layers_of(lists)[1] > 0
    nearest = np.where(dark, z, np.inf).min(axis=0)
    farthest = np.where(dark, z, -np.inf).max(axis=0)
    deep = farthest > nearest
    ratio = np.where(deep, farthest, 2) / np.where(deep, nearest, 1)
    t = np.where(deep, np.log(z / np.where(deep, nearest, 1)) / np.log(ratio), 0)
    return np.asarray(np.clip(slabs * t - 0.5, 0, slabs - 1))
