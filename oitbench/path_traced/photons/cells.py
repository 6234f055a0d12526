"""Sums of photons in the cells of a grid, on the host.

A cell is a square on a surface, and a key of 64 bits: a bit for its level, three for the direction
that the surface faces, and `BITS` for each of its coordinates, two across and one along the axis.
The wide cells of level 1 hold `WIDER`³ of those of level 0.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

BITS = 20
"""Of a key for each coordinate."""
WIDER_BITS = 2
WIDER = 1 << WIDER_BITS
"""Sides of a cell in the side of a wide one."""
SPARSE, DENSE = 6, 16
"""Mean photons in the cells around one: below the first they are all spread over the wide cell,
above the second none is. Few photons in small cells are specks, many in wide ones are blurred."""
ACROSS = (2, 1)
"""Places in a key of the two coordinates across the axis."""
MOST_PENDING = 1 << 22
"""Deposits that wait to be summed up: 40 bytes each."""

Keys = npt.NDArray[np.uint64]
Floats = npt.NDArray[np.float64]


class PhotonCells:
    """Power, and the number of photons, by the keys of cells."""

    def __init__(self) -> None:
        self._keys: list[Keys] = []
        self._sums: list[Floats] = []
        self._pending = 0

    def add(self, keys: Keys, power: npt.NDArray[np.floating[Any]]) -> None:
        """Add photons of `power`, shape (n, 3), to the cells `keys`, shape (n,), of level 0."""
        self._keys.append(keys)
        self._sums.append(np.column_stack([power, np.ones(len(keys))]))
        self._pending += len(keys)
        if self._pending > MOST_PENDING:
            self._merge()

    def _merge(self) -> None:
        keys, sums = _sum(np.concatenate(self._keys), np.concatenate(self._sums))
        self._keys, self._sums, self._pending = [keys], [sums], 0

    def finish(self) -> tuple[Keys, Floats]:
        """Return the cells of both levels with any light, ascending, and their power, (n, 3).

        Every photon counts once, in a cell or in a wide one, or by parts. Along the axis cells
        overlap by half, so that one of them has a point's neighborhood on either side.
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
    """Return the different `keys`, ascending, and the sum of the `values` of each."""
    different, inverse = np.unique(keys, return_inverse=True)
    sums = [np.bincount(inverse, weights=column, minlength=len(different)) for column in values.T]
    return different, np.stack(sums, axis=1)


def _wide(keys: Keys) -> Keys:
    """Return the keys of the wide cells that the cells lie in."""
    mask = np.uint64((1 << BITS) - 1)
    wide = (keys >> np.uint64(3 * BITS)) | np.uint64(1 << 3)
    for place in (2, 1, 0):
        field = (keys >> np.uint64(place * BITS)) & mask
        wide = (wide << np.uint64(BITS)) | (field >> np.uint64(WIDER_BITS))
    return wide


def _density(keys: Keys, counts: Floats) -> Floats:
    """Return the mean photons of the cells around each, interpolated between wide cells."""
    wide, inverse = np.unique(_wide(keys), return_inverse=True)
    means = np.bincount(inverse, weights=counts) / WIDER**2
    corners = [(_wide(keys), np.ones(len(keys)))]
    for place in ACROSS:
        field = (keys >> np.uint64(place * BITS)) & np.uint64(WIDER - 1)
        # From the middle of the wide cell, in its sides.
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
