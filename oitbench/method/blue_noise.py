"""Blue-noise masks: thresholds on a torus of pixels whose neighbors differ as much as possible.

Where a mask is compared with a constant, the pixels below it are spread evenly: the error of the
picture has high frequencies, which eyes and filters average out.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import numpy.typing as npt

from oitbench.method.storage import Target

SIDE = 64
"""Texels on each side of the mask that shaders read."""
_SEED = 1
_DEVIATION = 1.5
"""Of the Gaussian, in texels; Ulichney's choice."""
_FIRST = 0.1
"""Part of the texels that the first pattern holds."""
_FULL = 2.0**32
"""Energy of a point at its own place. Whole numbers have the same sums on every machine."""


@cache
def void_and_cluster(side: int, seed: int) -> npt.NDArray[np.int64]:
    """Return the ranks of a mask, shape (side, side): each of 0 to side² − 1 once.

    Points are put on a torus one after another, each into the largest void of those before it: the
    free place with the least energy, which is the sum of Gaussians around all points. The first
    tenth starts at random, and a point moves from the tightest cluster to the largest void as long
    as it finds less energy there; its ranks follow from removing the tightest cluster again and
    again. Filling up beyond one half takes the largest voids too, since the Gaussians of points and
    of free places have a constant sum.

    Source: Ulichney 1993, "The void-and-cluster method for dither array generation", SPIE 1913.

    Parameters
    ----------
    side : int
        At least 4.
    seed : int
        Of the first pattern.
    """
    count = side * side
    places = np.random.default_rng(seed).permutation(count)[: max(1, int(_FIRST * count))]
    pattern = _Pattern(side)
    for place in places:
        pattern.put(int(place))
    _spread(pattern)
    ranks = np.empty(count, np.int64)
    first = pattern.copy()
    for rank in reversed(range(len(places))):
        cluster = first.tightest_cluster()
        first.remove(cluster)
        ranks[cluster] = rank
    for rank in range(len(places), count):
        void = pattern.largest_void()
        pattern.put(void)
        ranks[void] = rank
    mask = ranks.reshape(side, side)
    mask.flags.writeable = False
    return mask


class _Pattern:
    """Points on a torus, and the sum of the Gaussians around them at each place."""

    def __init__(self, side: int) -> None:
        self._side = side
        self._points = np.zeros(side * side, np.bool_)
        self._energy = np.zeros((side, side), np.int64)
        away = np.minimum(np.arange(side), side - np.arange(side)) / _DEVIATION
        kernel = np.rint(_FULL * np.exp(-(away[:, None] ** 2 + away**2) / 2)).astype(np.int64)
        # Four copies, of which a window is the kernel around any place.
        self._kernels = np.tile(kernel, (2, 2))

    def copy(self) -> _Pattern:
        """Return a pattern of its own with the same points."""
        other = _Pattern(self._side)
        other._points, other._energy = self._points.copy(), self._energy.copy()
        return other

    def _around(self, place: int) -> npt.NDArray[np.int64]:
        row, column = (self._side - part for part in divmod(place, self._side))
        return self._kernels[row : row + self._side, column : column + self._side]

    def energy(self, place: int) -> int:
        """Return the sum of the Gaussians at a place."""
        return int(self._energy.reshape(-1)[place])

    def put(self, place: int) -> None:
        """Add a point."""
        self._points[place] = True
        self._energy += self._around(place)

    def remove(self, place: int) -> None:
        """Take a point away."""
        self._points[place] = False
        self._energy -= self._around(place)

    def tightest_cluster(self) -> int:
        """Return the point with the most energy, the first of several."""
        return int(np.where(self._points, self._energy.reshape(-1), -1).argmax())

    def largest_void(self) -> int:
        """Return the free place with the least energy, the first of several."""
        most = np.iinfo(np.int64).max
        return int(np.where(self._points, most, self._energy.reshape(-1)).argmin())


def _spread(pattern: _Pattern) -> None:
    """Move points from the tightest cluster to the largest void as long as that lowers energy."""
    while True:
        cluster = pattern.tightest_cluster()
        pattern.remove(cluster)
        void = pattern.largest_void()
        if pattern.energy(void) >= pattern.energy(cluster):
            pattern.put(cluster)
            return
        pattern.put(void)


def thresholds() -> npt.NDArray[np.float32]:
    """Return the mask that shaders read, (SIDE, SIDE): the middles of SIDE² parts of [0, 1]."""
    ranks = void_and_cluster(SIDE, _SEED)
    return ((ranks + 0.5) / ranks.size).astype(np.float32)


class _Mask(Target):
    """A texture that does not grow with the frame."""

    def size(self, frame: tuple[int, int]) -> tuple[int, int]:
        """Return (width, height)."""
        return SIDE, SIDE


MASK = _Mask("r32f", single=True)
"""The engine's texture of `thresholds`, which all frames share."""
