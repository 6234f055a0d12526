"""Sums of photons in the cells of a grid, on the host.

A cell is a square on a surface. Its key of 64 bits consists of one bit for the level, three bits
for the axis and the sign that the surface faces most, and `BITS` for each coordinate: two across
the axis and one along it. A wide cell, of level 1, contains `WIDER`³ cells of level 0.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from oitbench.scene import Floats

BITS = 20
"""Bits of a key for each coordinate."""
WIDER_BITS = 2
WIDER = 1 << WIDER_BITS
"""Side of a wide cell, in sides of a cell."""
SPARSE, DENSE = 6, 16
"""Mean numbers of photons in the cells around a photon. Below the first, the photon is spread over
its wide cell; above the second, it stays in its cell. Few photons in small cells would be specks,
and many in wide cells would be blurred."""
ACROSS = (2, 1)
"""Places in a key of the two coordinates across the axis; place 0 is the lowest bits."""
MOST_PENDING = 1 << 22
"""Photons that are kept before they are summed: 40 bytes each."""

Keys = npt.NDArray[np.uint64]


class PhotonCells:
    """The power and the number of photons by cell."""

    def __init__(self) -> None:
        self._keys: list[Keys] = []
        self._sums: list[Floats] = []
        self._pending = 0

    def add(self, keys: Keys, power: npt.NDArray[np.floating[Any]]) -> None:
        """Add photons to cells of level 0.

        Parameters
        ----------
        keys : array, shape (n,), uint64
        power : array, shape (n, 3)
            W for each channel.
        """
        self._keys.append(keys)
        self._sums.append(np.column_stack([power, np.ones(len(keys))]))
        self._pending += len(keys)
        if self._pending > MOST_PENDING:
            self._merge()

    def _merge(self) -> None:
        keys, sums = _sum(np.concatenate(self._keys), np.concatenate(self._sums))
        self._keys, self._sums, self._pending = [keys], [sums], 0

    def finish(self) -> tuple[Keys, Floats]:
        """Return the power by cell.

        Every photon counts once: in its cell, in its wide cell, or divided between both. Cells
        overlap by half along the axis, so that each point is in the middle half of a cell and has
        its neighborhood on either side.

        Returns
        -------
        keys : array, shape (n,), uint64
            Cells of both levels that receive any light, ascending.
        power : array, shape (n, 3)
            W for each channel.
        """
        if not self._keys:
            return np.zeros(0, dtype=np.uint64), np.zeros((0, 3))
        self._merge()
        keys, sums = self._keys[0], self._sums[0]
        density = _density(keys, sums[:, 3])
        spread = np.clip((DENSE - density) / (DENSE - SPARSE), 0, 1)[:, None]
        power = sums[:, :3]
        keys, power = _sum(
            np.concatenate([keys, _wide(keys)]),
            np.concatenate([(1 - spread) * power, spread * power]),
        )
        lit = power.any(axis=1)
        keys, power = keys[lit], power[lit]
        return _sum(np.concatenate([keys, keys - np.uint64(1)]), np.concatenate([power, power]))


def _sum(keys: Keys, values: Floats) -> tuple[Keys, Floats]:
    """Return the distinct `keys`, ascending, and the sum of the `values` of each."""
    distinct, inverse = np.unique(keys, return_inverse=True)
    sums = [np.bincount(inverse, weights=column, minlength=len(distinct)) for column in values.T]
    return distinct, np.stack(sums, axis=1)


def _wide(keys: Keys) -> Keys:
    """Return the keys of the wide cells that contain the cells."""
    mask = np.uint64((1 << BITS) - 1)
    wide = (keys >> np.uint64(3 * BITS)) | np.uint64(1 << 3)
    for place in (2, 1, 0):
        field = (keys >> np.uint64(place * BITS)) & mask
        wide = (wide << np.uint64(BITS)) | (field >> np.uint64(WIDER_BITS))
    return wide


def _density(keys: Keys, counts: Floats) -> Floats:
    """Return the mean number of photons in the cells around each cell.

    The means over wide cells are interpolated.
    """
    wide, inverse = np.unique(_wide(keys), return_inverse=True)
    means = np.bincount(inverse, weights=counts) / WIDER**2
    corners = [(_wide(keys), np.ones(len(keys)))]
    for place in ACROSS:
        field = (keys >> np.uint64(place * BITS)) & np.uint64(WIDER - 1)
        # From the middle of the wide cell, in units of its side.
        offset = (field + 0.5) / WIDER - 0.5
        step = np.uint64(1 << (place * BITS))
        corners = [
            corner
            for key, weight in corners
            for corner in (
                (key, weight * (1 - np.abs(offset))),
                (np.where(offset < 0, key - step, key + step), weight * np.abs(offset)),
            )
        ]
    density = np.zeros(len(keys))
    for key, weight in corners:
        found = np.minimum(np.searchsorted(wide, key), len(wide) - 1)
        density += np.where(wide[found] == key, means[found], 0) * weight
    return density
