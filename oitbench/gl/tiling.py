"""Tiles of the frame, in which records of fragments are allocated, and regions of tiles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from oitbench.errors import CapabilityError

Counts = npt.NDArray[np.int64]
Scissor = tuple[int, int, int, int]
"""Left, bottom, width and height in pixels."""

TILE = 64
"""Side of a tile in pixels."""
ALLOCATOR_STRIDE = 16
"""Words from one tile's allocator to the next: a cache line, so that tiles do not contend."""


@dataclass(frozen=True)
class Region:
    """A rectangle of tiles that is rendered at once: columns and rows [first, last)."""

    left: int
    bottom: int
    right: int
    top: int

    def scissor(self, size: tuple[int, int]) -> Scissor:
        """Return the region in pixels, clipped to the frame."""
        left, bottom = self.left * TILE, self.bottom * TILE
        right, top = min(self.right * TILE, size[0]), min(self.top * TILE, size[1])
        return left, bottom, right - left, top - bottom


def split(demand: Counts, limit: int) -> list[Region]:
    """Cut the frame into as few regions as needed for each to hold at most `limit` records.

    Parameters
    ----------
    demand : array, shape (rows, columns), int64
        Records that each tile needs.
    limit : int
        Records that one storage block can hold.

    Raises
    ------
    CapabilityError
        One tile alone needs more.
    """

    def cut(region: Region) -> list[Region]:
        part = demand[region.bottom : region.top, region.left : region.right]
        if part.sum() <= limit:
            return [region]
        if part.size == 1:
            raise CapabilityError(
                f"{int(part.sum())} fragments in one {TILE}×{TILE} tile exceed the driver's limit"
                f" of {limit} records per buffer; render fewer layers"
            )
        if part.shape[0] >= part.shape[1]:
            middle = (region.bottom + region.top) // 2
            halves = (
                Region(region.left, region.bottom, region.right, middle),
                Region(region.left, middle, region.right, region.top),
            )
        else:
            middle = (region.left + region.right) // 2
            halves = (
                Region(region.left, region.bottom, middle, region.top),
                Region(middle, region.bottom, region.right, region.top),
            )
        return [piece for half in halves for piece in cut(half)]

    rows, columns = demand.shape
    return cut(Region(0, 0, columns, rows))


def rectangle(marked: npt.NDArray[np.bool_], side: int, scissor: Scissor) -> Scissor | None:
    """Return the part of `scissor` around all marked blocks; None if nothing is marked.

    Parameters
    ----------
    marked : array, shape (rows, columns), bool
        Blocks of pixels, bottom row first.
    side : int
        Side of a block in pixels.
    scissor : (int, int, int, int)
    """
    rows, columns = (np.flatnonzero(marked.any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        return None
    left, bottom, width, height = scissor
    first = max(left, int(columns[0]) * side), max(bottom, int(rows[0]) * side)
    last = (
        min(left + width, (int(columns[-1]) + 1) * side),
        min(bottom + height, (int(rows[-1]) + 1) * side),
    )
    return (*first, max(0, last[0] - first[0]), max(0, last[1] - first[1]))


def sum_by_tile(counts: Counts, tiles: tuple[int, int]) -> Counts:
    """Return the sum of a per-pixel count over each tile, shape `tiles` = (rows, columns)."""
    rows, columns = tiles
    padded = np.zeros((rows * TILE, columns * TILE), dtype=np.int64)
    padded[: counts.shape[0], : counts.shape[1]] = counts
    return np.asarray(padded.reshape(rows, TILE, columns, TILE).sum(axis=(1, 3)))
