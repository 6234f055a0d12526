"""Truncated depth peeling, which composites only the first layers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from oitbench.measure.oracle import composite
from oitbench.scene import Floats, FragmentLists


def peeled(lists: FragmentLists, background: npt.ArrayLike, layers: int, both_ends: bool) -> Floats:
    """Return the picture of the first `layers` of each pixel, or of layers from both ends.

    Parameters
    ----------
    lists : FragmentLists
        The depths at each pixel must be distinct.
    background : array, broadcastable to (h, w, 3)
    layers : int
        Zero means all.
    both_ends : bool
        Layers are peeled in pairs, the nearest and the farthest; odd numbers are rounded up.
    """
    rank = lists.z.argsort(axis=0).argsort(axis=0)
    count = len(lists.z)
    if not layers:
        reached = rank >= 0
    elif both_ends:
        pairs = -(-layers // 2)
        reached = (rank < pairs) | (rank >= count - pairs)
    else:
        reached = rank < layers
    return composite(replace(lists, coverage=np.where(reached, lists.coverage, 0)), background)
