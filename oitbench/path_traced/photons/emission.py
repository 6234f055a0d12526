"""The photons that a beam emits toward its targets, the refracting solids.

The scene is projected onto a plane in front of the light: in parallel for a directional light,
centrally for a spot light. The cells of a grid on this plane that a target's triangles may touch
are kept, and each of them gets the same number of photons. All targets are thus covered, few
photons miss them, and none is counted twice.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from oitbench.scene import PENUMBRA, DirectionalLight, Floats, SpotLight, axes_along

CELLS = 256
"""Largest number of cells on the longer side of the grid."""
PHOTONS_PER_CELL = 64
"""Least number of photons for each cell, which are spread evenly over it. With few photons, the
grid is coarser instead."""
NEAREST = 1e-3
"""Meters in front of a spot light. A triangle that is closer may cover the whole cone."""
ADDENDS = (3242174889, 2447445413)
"""2³² / p and 2³² / p² with p³ = p + 1: the sequence R₂ of Roberts 2018, "The Unreasonable
Effectiveness of Quasirandom Sequences"."""


@dataclass(frozen=True, eq=False)
class Emission:
    """The photons of one beam.

    Parameters
    ----------
    light : DirectionalLight or SpotLight
    axes : array, shape (3, 3)
        Unit right, up and forward vectors of the light as rows.
    origin : array, shape (3,)
        Meters. The position of a spot light, or a point on a plane in front of the whole scene.
    low : array, shape (2,)
        Corner of the grid: in meters for a parallel projection, as tangents for a central one.
    side : float
        Side of a cell, in the same unit.
    cells : array, shape (k, 2), uint32
        Column and row of the cells that are kept.
    photons : int
        Number of photons for each cell.
    distance : float
        Mean distance of the targets from a spot light in meters; 1 for a parallel projection.
    """

    light: DirectionalLight | SpotLight
    axes: Floats
    origin: Floats
    low: Floats
    side: float
    cells: npt.NDArray[np.uint32]
    photons: int
    distance: float

    @classmethod
    def toward(
        cls,
        light: DirectionalLight | SpotLight,
        triangles: Floats,
        count: int,
        bounds: tuple[Floats, Floats],
    ) -> Emission | None:
        """Aim about `count` photons at triangles.

        Parameters
        ----------
        light : DirectionalLight or SpotLight
        triangles : array, shape (n, 3, 3)
            Corners in meters.
        count : int
        bounds : (array, array)
            Lowest and highest corner of the scene's bounding box. The photons of a directional
            light start outside of it.

        Returns
        -------
        Emission or None
            None if all triangles are outside of the cone of a spot light.
        """
        if isinstance(light, DirectionalLight):
            axes = axes_along(light.direction)
            origin = _outside(axes, bounds)
            local = (triangles - origin) @ axes.T
            low, high = local[..., :2].min(axis=1), local[..., :2].max(axis=1)
            distance = 1.0
        else:
            origin = np.asarray(light.position, dtype=np.float64)
            axes = axes_along(light.target - origin)
            local = (triangles - origin) @ axes.T
            low, high = _central(local, math.tan(light.angle / 2))
            distance = float(np.linalg.norm(local, axis=-1).mean())
        if not len(low):
            return None
        start, side, cells = _cover(low, high, min(CELLS, _side(count)))
        return cls(light, axes, origin, start, side, cells, -(-count // len(cells)), distance)

    @property
    def count(self) -> int:
        """Total number of photons."""
        return len(self.cells) * self.photons

    @property
    def area(self) -> float:
        """Cross-section of the beam at the targets, m²."""
        return len(self.cells) * (self.side * self.distance) ** 2

    def emit(self, mitsuba: Any, drjit: Any, number: Any, seed: int) -> tuple[Any, Any]:
        """Return the rays and the powers of photons.

        Parameters
        ----------
        mitsuba, drjit : module
            With a variant that is not scalar.
        number : UInt32
            Numbers of the photons, below `count`.
        seed : int

        Returns
        -------
        rays : Ray3f
        power : Color3f
            W for each channel.
        """
        photons = drjit.opaque(mitsuba.UInt32, self.photons)
        cell = number // photons
        order = number - cell * photons
        shifts = mitsuba.sample_tea_32(cell, drjit.opaque(mitsuba.UInt32, seed))
        places = drjit.gather(mitsuba.Point2u, mitsuba.UInt32(self.cells.ravel()), cell)
        x, y = (
            # A float32 holds 24 bits: the upper ones of 32.
            drjit.opaque(mitsuba.Float, low)
            + (place + ((order * addend + shift) >> 8) * (2.0**-24))
            * drjit.opaque(mitsuba.Float, self.side)
            for low, place, addend, shift in zip(
                self.low.tolist(), places, ADDENDS, shifts, strict=True
            )
        )
        origin = mitsuba.Point3f(*self.origin.tolist())
        right, up, forward = (mitsuba.Vector3f(*axis) for axis in self.axes.tolist())
        light, area = self.light, self.side**2 / self.photons
        flux = light.irradiance if isinstance(light, DirectionalLight) else light.intensity
        power = mitsuba.Color3f(*flux) * area
        drjit.make_opaque(origin, right, up, forward, power)
        if isinstance(light, DirectionalLight):
            return mitsuba.Ray3f(origin + right * x + up * y, forward), power
        cosine = drjit.rsqrt(1 + x * x + y * y)
        half = drjit.opaque(mitsuba.Float, light.angle / 2)
        faded = (half - drjit.acos(drjit.minimum(cosine, 1))) / (PENUMBRA * half)
        ray = mitsuba.Ray3f(origin, (right * x + up * y + forward) * cosine)
        # An area dA of the plane at distance 1 subtends the solid angle cos³ dA.
        return ray, power * drjit.clip(faded, 0, 1) * cosine * cosine * cosine


def _outside(axes: Floats, bounds: tuple[Floats, Floats]) -> Floats:
    """Return a point 1.5 diagonals of the box in front of its center, toward the light."""
    low, high = bounds
    middle, reach = (low + high) / 2, float(np.linalg.norm(high - low))
    return np.asarray(middle - 1.5 * reach * axes[2])


def _side(count: int) -> int:
    return max(1, math.isqrt(count // PHOTONS_PER_CELL))


def _central(local: Floats, widest: float) -> tuple[Floats, Floats]:
    """Return the bounds of triangles in a central projection, clipped to tangents of ± `widest`."""
    local = local[local[..., 2].max(axis=1) > 0]
    depth = local[..., 2]
    near = depth.min(axis=1, keepdims=True) < NEAREST
    flat = local[..., :2] / np.maximum(depth, NEAREST)[..., None]
    low = np.where(near, -widest, flat.min(axis=1))
    high = np.where(near, widest, flat.max(axis=1))
    lit = np.asarray((low < widest).all(axis=1) & (high > -widest).all(axis=1))
    return np.maximum(low[lit], -widest), np.minimum(high[lit], widest)


def _cover(low: Floats, high: Floats, most: int) -> tuple[Floats, float, npt.NDArray[np.uint32]]:
    """Return the corner and the cell size of a grid, and the cells that rectangles touch."""
    start = low.min(axis=0)
    side = float((high.max(axis=0) - start).max()) / most
    # Clipped, because the far edge may be rounded into the next cell.
    first = np.clip(((low - start) / side).astype(np.int64), 0, most - 1)
    last = np.clip(((high - start) / side).astype(np.int64), 0, most - 1) + 1
    # The two-dimensional differences of the number of rectangles that cover a cell.
    steps = np.zeros((most + 1, most + 1), dtype=np.int64)
    np.add.at(steps, (first[:, 0], first[:, 1]), 1)
    np.add.at(steps, (last[:, 0], last[:, 1]), 1)
    np.add.at(steps, (first[:, 0], last[:, 1]), -1)
    np.add.at(steps, (last[:, 0], first[:, 1]), -1)
    covered = steps.cumsum(axis=0).cumsum(axis=1) > 0
    return start, side, np.argwhere(covered).astype(np.uint32)
