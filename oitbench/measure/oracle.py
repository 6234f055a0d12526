"""The exact answer in double precision, which tests compare methods with."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from oitbench.scene import Floats, FragmentLists


def transmittances(lists: FragmentLists) -> Floats:
    """Return τ = 1 − α + α t of every fragment, shape (n, h, w, 3)."""
    coverage = lists.coverage.astype(np.float64)[..., None]
    return np.asarray(1 - coverage * (1 - lists.transmission.astype(np.float64)))


def composite(lists: FragmentLists, background: npt.ArrayLike) -> Floats:
    """Composite fragment lists by the over operator with RGB transmittance.

    C = Σ_i α_i L_i Π_{j nearer than i} τ_j + C0 Π_j τ_j

    Fragments of equal distance are taken in ascending order of α·L, then τ, channel by channel, as
    the suite's exact method does.

    Parameters
    ----------
    lists : FragmentLists
    background : array, broadcastable to (h, w, 3)
        Radiance C0 behind everything.

    Returns
    -------
    array, shape (h, w, 3), float64, linear
    """
    factor = transmittances(lists)
    color = lists.coverage.astype(np.float64)[..., None] * lists.radiance.astype(np.float64)
    keys = [lists.z, *np.moveaxis(color, -1, 0), *np.moveaxis(factor, -1, 0)]
    order = np.lexsort(keys[::-1], axis=0)[..., None]
    color = np.take_along_axis(color, order, axis=0)
    factor = np.take_along_axis(factor, order, axis=0)
    passed = np.cumprod(factor, axis=0)
    visible = np.concatenate([np.ones_like(passed[:1]), passed[:-1]])
    return np.asarray((color * visible).sum(axis=0) + np.asarray(background) * passed[-1])
