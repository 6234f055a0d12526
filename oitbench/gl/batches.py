"""Triangles that are drawn together, and the orders in which they can be drawn."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import moderngl
import numpy as np
import numpy.typing as npt

from oitbench.method.passes import Order
from oitbench.scene import Floats, Object

Units = npt.NDArray[np.int64]
"""(first triangle, count) of each unit, shape (n, 2)."""


@dataclass(frozen=True, eq=False)
class Batch:
    """Triangles that are drawn together.

    Parameters
    ----------
    triangles : array, shape (m, 3), uint32
        Indices into the vertices of the geometry.
    units : array, shape (n, 2), int64
        First triangle and number of triangles of each object.
    places : array, shape (m, ...), float64
        Centroid of each triangle, or another place that `distances` understands.
    unit_places : array, shape (n, ...), float64
        Center of the bounding box of each object.
    distances : callable
        Returns the view distances of places in meters. They depend on the camera, so that each
        sort computes them again.
    """

    triangles: npt.NDArray[np.uint32]
    units: Units
    places: Floats
    unit_places: Floats
    distances: Callable[[Floats], Floats]

    def __len__(self) -> int:
        return len(self.triangles)

    def arrange(
        self, order: Order, permutation: int | None = None
    ) -> tuple[npt.NDArray[np.uint32], Units]:
        """Return the triangles in `order`, and the units in that order.

        Parameters
        ----------
        order : Order
        permutation : int, optional
            Seed by which units, and triangles within them, are shuffled before any sort.
        """
        count = len(self.triangles)
        rank = np.arange(count)
        units = np.arange(len(self.units))
        if permutation is not None:
            generator = np.random.default_rng(permutation)
            rank, units = generator.permutation(count), generator.permutation(units)
        if order is Order.TRIANGLES:
            # A permutation changes nothing.
            chosen = _farthest_first(self.distances(self.places))
            return self.triangles[chosen], np.stack([np.arange(count), np.ones(count, int)], axis=1)
        if order is Order.OBJECTS:
            units = _farthest_first(self.distances(self.unit_places))
        if order is Order.SUBMISSION and permutation is not None and len(units) == 1:
            return self.triangles[rank], self.units
        runs = [np.arange(first, first + size) for first, size in self.units[units]]
        if permutation is not None:
            runs = [run[np.argsort(rank[run])] for run in runs]
        chosen = np.concatenate(runs) if runs else np.zeros(0, dtype=np.int64)
        sizes = self.units[units, 1]
        return self.triangles[chosen], np.stack([np.cumsum(sizes) - sizes, sizes], axis=1)


def _farthest_first(distances: Floats) -> npt.NDArray[np.int64]:
    """Return the order from the farthest to the nearest; equal ones stay in order."""
    return np.lexsort((np.arange(len(distances)), -distances))


@dataclass(frozen=True)
class IndexOrder:
    """One draw order on the device.

    Parameters
    ----------
    indices : moderngl.Buffer
    units : array, shape (n, 2), int64
        First triangle and number of triangles of each unit of interleaved passes.
    triangles : int
    """

    indices: moderngl.Buffer
    units: Units
    triangles: int

    @classmethod
    def upload(
        cls,
        context: moderngl.Context,
        triangles: npt.NDArray[np.uint32],
        units: Units,
        buffer: moderngl.Buffer | None = None,
    ) -> IndexOrder:
        """Write `triangles` to `buffer`, or to a new buffer.

        A new buffer has room for at least one triangle, so that an empty batch can be bound.
        """
        target = buffer or context.buffer(reserve=triangles.nbytes + 12)
        if len(triangles):
            target.write(triangles.tobytes())
        return cls(target, units, len(triangles))


def batch_of(objects: Sequence[Object], distances: Callable[[Floats], Floats], base: int) -> Batch:
    """Return the triangles of `objects`, whose vertices start at index `base`."""
    triangles, units, places, unit_places = [], [], [], []
    first = 0
    for item in objects:
        mesh = item.mesh
        triangles.append(mesh.triangles.astype(np.uint32) + np.uint32(base))
        base += len(mesh.positions)
        units.append((first, len(mesh.triangles)))
        first += len(mesh.triangles)
        corners = mesh.positions[mesh.triangles]
        places.append(corners.mean(axis=1))
        points = mesh.used_positions
        unit_places.append((points.min(axis=0) + points.max(axis=0)) / 2)
    return Batch(
        np.concatenate(triangles) if triangles else np.zeros((0, 3), np.uint32),
        np.array(units, dtype=np.int64).reshape(-1, 2),
        np.concatenate(places) if places else np.zeros((0, 3)),
        np.array(unit_places, dtype=np.float64).reshape(-1, 3),
        distances,
    )


def part_of(batch: Batch, chosen: Sequence[int]) -> Batch:
    """Return the objects of `batch` with these numbers."""
    units = [batch.units[number] for number in chosen]
    runs = [np.arange(first, first + count) for first, count in units]
    kept = np.concatenate(runs) if runs else np.zeros(0, dtype=np.int64)
    sizes = np.array([count for _, count in units], dtype=np.int64)
    return Batch(
        batch.triangles[kept],
        np.stack([np.cumsum(sizes) - sizes, sizes], axis=1),
        batch.places[kept],
        batch.unit_places[np.asarray(chosen, dtype=np.int64)],
        batch.distances,
    )
