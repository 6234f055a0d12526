"""What truncated peeling composites: the layers that it has reached, and no others."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from oitbench.measure.oracle import composite
from oitbench.scene import Floats, FragmentLists


def peeled(lists: FragmentLists, background: npt.ArrayLike, layers: int, both_ends: bool) -> Floats:
    """Composite the first `layers` of each pixel; with `both_ends`, as many from either end.

    Parameters
    ----------
    lists : FragmentLists
        All of distinct depths at each pixel.
    background : array, broadcastable to (h, w, 3)
    layers : int
        All if zero.
    both_ends : bool
        Layers come in pairs, nearest and farthest, and odd numbers are rounded up.
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
