"""Adaptive transparency in double precision, node by node (Salvi et al. 2011)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from oitbench.scene import Floats

SINGLE = 2e-6
"""Relative rounding of a product of tens of factors in single precision."""


@dataclass
class Curve:
    """The visibility curve of one pixel and channel: at most `capacity` steps.

    Parameters
    ----------
    capacity : int
    removal : str
        "under", "over" or "best".
    packed : bool
        Whether nodes are kept with 16 bits of mantissa in depth and 8 bits of transmittance.

    Attributes
    ----------
    close : bool
        Whether the costs of two removals were so close that single precision may swap them.
    """

    capacity: int
    removal: str = "under"
    packed: bool = False
    depths: list[float] = field(default_factory=list)
    throughs: list[float] = field(default_factory=list)
    total: float = 1.0
    close: bool = False

    def insert(self, depth: float, factor: float) -> None:
        """Multiply the curve by a step; remove a node if there are too many."""
        depth = self.kept_depth(depth)
        place = sum(other < depth for other in self.depths)
        before = self.throughs[place - 1] if place else 1.0
        self.depths.insert(place, depth)
        self.throughs.insert(place, before)
        self.throughs[place:] = [through * factor for through in self.throughs[place:]]
        if len(self.depths) > self.capacity:
            self._remove()
        if self.packed:
            self.throughs = [np.floor(through * 255 + 0.5) / 255 for through in self.throughs]
        self.total = self.throughs[-1]

    def _remove(self) -> None:
        """Remove the node that changes the area least; of equal ones the nearest."""
        before = np.array([1.0, *self.throughs[:-1]])
        drops = before - self.throughs
        gaps = np.diff(self.depths)
        # (cost, rounding error of the cost, index of the depth and of the transmittance to remove)
        costs: list[tuple[float, float, int, int]] = []
        for j in range(len(drops)):
            if self.removal != "over" and j > 0:
                gap = gaps[j - 1]
                costs.append((drops[j] * gap, SINGLE * before[j] * gap, j, j - 1))
            if self.removal != "under" and j < len(gaps):
                costs.append((drops[j] * gaps[j], SINGLE * before[j] * gaps[j], j, j))
        cost, error, depth_gone, through_gone = min(costs)
        near = [item for item in costs if item[0] - cost < item[1] + error]
        self.close = self.close or len(near) > 1
        del self.depths[depth_gone], self.throughs[through_gone]

    def visibility(self, depth: float) -> float:
        """Return the transmittance of all layers nearer than `depth`."""
        place = sum(other < self.kept_depth(depth) for other in self.depths)
        return self.throughs[place - 1] if place else 1.0

    def kept_depth(self, depth: float) -> float:
        """Return `depth` as a node stores it."""
        if not self.packed:
            return depth
        bits = np.float32(depth).view(np.uint32) & np.uint32(0xFFFFFF80)
        return float(bits.view(np.float32))


def composite(
    depths: Floats,
    colors: Floats,
    factors: Floats,
    background: npt.ArrayLike,
    nodes: int,
    removal: str = "under",
    packed: bool = False,
) -> tuple[Floats, npt.NDArray[np.bool_]]:
    """Return the picture of lists in submission order, and the pixels that are `Curve.close`.

    Parameters
    ----------
    depths : array, shape (n, h, w)
        Linear or window depth.
    colors : array, shape (n, h, w, 3)
        alpha L.
    factors : array, shape (n, h, w, c)
        Transmittance of each layer: one channel, or three channels with separate curves.
    """
    channels = factors.shape[-1]
    result = np.empty((*depths.shape[1:], 3))
    close = np.zeros(depths.shape[1:], dtype=bool)
    for row, column in np.ndindex(*depths.shape[1:]):
        here = depths[:, row, column]
        for channel in range(channels):
            covered = slice(None) if channels == 1 else slice(channel, channel + 1)
            curve = Curve(nodes, removal, packed)
            for depth, factor in zip(here, factors[:, row, column, channel], strict=True):
                if factor < 1:
                    curve.insert(float(depth), float(factor))
            seen = np.array([curve.visibility(float(depth)) for depth in here])
            color = (colors[:, row, column, covered] * seen[:, None]).sum(axis=0)
            result[row, column, covered] = color + curve.total * np.asarray(background)[covered]
            close[row, column] |= curve.close
    return result, close
