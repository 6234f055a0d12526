"""Values on a grid of points in a box: densities that cast shadows, and distances to bodies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from oitbench.scene import Floats, Vector, unit


@dataclass(frozen=True, eq=False)
class Voxels:
    """Values at the points of a regular grid, linear in between.

    Parameters
    ----------
    low, high : Vector
        First and last point of the grid, meters.
    values : array, shape (x, y, z), float64
    """

    low: Vector
    high: Vector
    values: Floats

    @property
    def spacing(self) -> Floats:
        """Distance of neighbors along each axis, shape (3,), meters."""
        return np.asarray(np.subtract(self.high, self.low) / (np.array(self.values.shape) - 1))

    def at(self, points: Floats) -> Floats:
        """Return the values at points, shape (..., 3); outside of the box, those at its border."""
        from scipy import ndimage

        places = (points - np.asarray(self.low)) / self.spacing
        rows = places.reshape(-1, 3).T
        found = ndimage.map_coordinates(self.values, rows, order=1, mode="nearest")
        return np.asarray(found.reshape(points.shape[:-1]))

    @cached_property
    def _slopes(self) -> tuple[Voxels, ...]:
        """The derivatives along the three axes."""
        slopes = np.gradient(self.values, *self.spacing)
        return tuple(Voxels(self.low, self.high, slope) for slope in slopes)

    def gradient(self, points: Floats) -> Floats:
        """Return the direction, shape (..., 3), in which the values rise; of unit length."""
        rising = [slope.at(points) for slope in self._slopes]
        return unit(np.add(np.stack(rising, axis=-1), (0.0, 1e-12, 0.0)))

    def integral_toward(self, direction: npt.ArrayLike) -> Voxels:
        """Return the integrals of the values along rays in `direction` to the border of the box.

        Layer by layer across the axis that the rays follow most: each layer adds itself to the next
        one, moved sideways.
        """
        from scipy import ndimage

        toward = unit(np.asarray(direction, dtype=np.float64)) / self.spacing
        axis = int(np.abs(toward).argmax())
        step = toward / abs(toward[axis])
        length = float(np.linalg.norm(step * self.spacing))
        layers = np.moveaxis(self.values, axis, 0)
        order = range(len(layers))[:: -1 if step[axis] > 0 else 1]
        sideways = -np.delete(step, axis)
        sums = np.zeros_like(layers)
        passed = np.zeros_like(layers[0])
        for index in order:
            moved = ndimage.shift(passed, sideways, order=1, mode="constant")
            sums[index] = moved + 0.5 * length * layers[index]
            passed = moved + length * layers[index]
        return Voxels(self.low, self.high, np.moveaxis(sums, 0, axis))

    def smoothed(self, radius: float) -> Voxels:
        """Return the values, averaged over a Gaussian of the standard deviation `radius`."""
        from scipy import ndimage

        values = ndimage.gaussian_filter(self.values, radius / self.spacing, mode="constant")
        return Voxels(self.low, self.high, values)


def sampled(function: Callable[[Floats], Floats], low: Vector, high: Vector, cell: float) -> Voxels:
    """Return a function of points, shape (n, 3), at the points of a grid about `cell` apart."""
    counts = np.ceil(np.subtract(high, low) / cell).astype(int) + 1
    lines = [np.linspace(*ends) for ends in zip(low, high, counts, strict=True)]
    lattice = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1)
    return Voxels(low, high, function(lattice.reshape(-1, 3)).reshape(counts))


def density(
    points: Floats, weights: npt.ArrayLike, low: Vector, high: Vector, cell: float | Vector
) -> Voxels:
    """Return the sum of the weights of points, shape (n, 3), per cubic meter around each voxel.

    Voxels are about `cell` apart, along each axis if it is a vector.
    """
    counts = np.ceil(np.subtract(high, low) / np.asarray(cell)).astype(int) + 1
    spacing = np.subtract(high, low) / (counts - 1)
    edges = [
        np.linspace(first - 0.5 * gap, last + 0.5 * gap, count + 1)
        for first, last, gap, count in zip(low, high, spacing, counts, strict=True)
    ]
    amounts = np.broadcast_to(np.asarray(weights, dtype=np.float64), len(points))
    sums, _ = np.histogramdd(points, edges, weights=amounts)
    return Voxels(low, high, sums / spacing.prod())
