"""Hashed alpha testing in double precision, given the threshold of every fragment."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from oitbench.scene import Floats, FragmentLists
from tests.models.commutative import layers_of


def composite(
    lists: FragmentLists, background: npt.ArrayLike, thresholds: npt.NDArray[np.float32]
) -> Floats:
    """Return the color of the nearest fragment whose opacity reaches its threshold, (n, h, w)."""
    color, opacity = layers_of(lists)
    kept = np.asarray(opacity.astype(np.float32) >= thresholds)
    nearest = np.asarray(np.where(kept, lists.z, np.inf).argmin(axis=0))[None]
    shown = color / np.maximum(opacity, 1e-20)[..., None]
    chosen = np.take_along_axis(shown, nearest[..., None], axis=0)[0]
    return np.where(np.asarray(kept.any(axis=0))[..., None], chosen, np.asarray(background))
