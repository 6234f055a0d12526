"""Where a beam's photons start: the parts of its light plane that hold something to hit.

A beam sees the scene by a parallel or a central projection onto a plane. Of a grid on that plane,
the cells that a target's triangles may touch are kept, and every cell gets the same number of
photons: no photon is counted twice, few miss, and all targets together are covered.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from oitbench.scene import PENUMBRA, DirectionalLight, SpotLight

Floats = npt.NDArray[np.float64]

CELLS = 256
"""Most cells on the longer side of the grid."""
PHOTONS_PER_CELL = 64
"""Few photons get a coarser grid, rather than fewer than these, which a cell spreads evenly."""
NEAREST = 1e-3
"""Metres before a spot light; a triangle that comes nearer may cover all of its cone."""
ADDENDS = (3242174889, 2447445413)
"""2³² / p and 2³² / p², p³ = p + 1: the sequence R₂ of Roberts 2018, "The Unreasonable
Effectiveness of Quasirandom Sequences"."""


@dataclass(frozen=True, eq=False)
class Aim:
    """Photons of one beam.

    Parameters
    ----------
    light : DirectionalLight or SpotLight
    axes : array, shape (3, 3)
        Unit right, up and forward vectors of the light as rows.
    origin : array, shape (3,)
        Metres: the spot light, or a point on a plane before the whole scene.
    low : array, shape (2,)
        Corner of the grid. Coordinates are metres for a parallel projection, and tangents for a
        central one.
    side : float
        Side of a cell.
    cells : array, shape (k, 2), uint32
        Column and row of the cells that are kept.
    photons : int
        For each cell.
    distance : float
        Mean metres of the targets before the light; 1 for a parallel projection.
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
    def at(
        cls,
        light: DirectionalLight | SpotLight,
        triangles: Floats,
        count: int,
        bounds: tuple[Floats, Floats],
    ) -> Aim | None:
        """Return about `count` photons toward `triangles`, shape (n, 3, 3).

        `bounds` are the corners of the scene's box, outside of which a directional light starts.
        None if all triangles are beside the cone of a spot light.
        """
        if isinstance(light, DirectionalLight):
            axes = _axes(light.direction)
            origin = _outside(axes, bounds)
            local = (triangles - origin) @ axes.T
            low, high = local[..., :2].min(axis=1), local[..., :2].max(axis=1)
            distance = 1.0
        else:
            origin = np.asarray(light.position, dtype=np.float64)
            axes = _axes(light.target - origin)
            local = (triangles - origin) @ axes.T
            low, high = _central(local, math.tan(light.angle / 2))
            distance = float(np.linalg.norm(local, axis=-1).mean())
        if not len(low):
            return None
        start, side, cells = _cover(low, high, min(CELLS, _side(count)))
        return cls(light, axes, origin, start, side, cells, -(-count // len(cells)), distance)

    @property
    def count(self) -> int:
        """Number of all photons."""
        return len(self.cells) * self.photons

    @property
    def area(self) -> float:
        """Cross-section of the beam at the targets, m²."""
        return len(self.cells) * (self.side * self.distance) ** 2

    def emit(self, mitsuba: Any, drjit: Any, number: Any, seed: int) -> tuple[Any, Any]:
        """Return the rays and powers, W per channel, of the photons `number`, UInt32."""
        photons = drjit.opaque(mitsuba.UInt32, self.photons)
        cell = number // photons
        order = number - cell * photons
        shifts = mitsuba.sample_tea_32(cell, drjit.opaque(mitsuba.UInt32, seed))
        places = drjit.gather(mitsuba.Point2u, mitsuba.UInt32(self.cells.ravel()), cell)
        x, y = (
            # The upper 24 of 32 bits are what a float32 holds.
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
        # A part dA of the plane at distance 1 is seen under the solid angle cos³ dA.
        return ray, power * drjit.clip(faded, 0, 1) * cosine * cosine * cosine


def _axes(direction: npt.ArrayLike) -> Floats:
    forward = np.asarray(direction, dtype=np.float64)
    forward = forward / np.linalg.norm(forward)
    right = np.cross(np.eye(3)[np.abs(forward).argmin()], forward)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(forward, right), forward])


def _outside(axes: Floats, bounds: tuple[Floats, Floats]) -> Floats:
    """Return a point on the plane that all of the box lies behind, one diagonal away from it."""
    low, high = bounds
    middle, reach = (low + high) / 2, float(np.linalg.norm(high - low))
    return np.asarray(middle - 1.5 * reach * axes[2])


def _side(count: int) -> int:
    return max(1, math.isqrt(count // PHOTONS_PER_CELL))


def _central(local: Floats, widest: float) -> tuple[Floats, Floats]:
    """Return the triangles' rectangles in a central projection, cut off at tangents ± `widest`."""
    local = local[local[..., 2].max(axis=1) > 0]
    depth = local[..., 2]
    near = depth.min(axis=1, keepdims=True) < NEAREST
    flat = local[..., :2] / np.maximum(depth, NEAREST)[..., None]
    low = np.where(near, -widest, flat.min(axis=1))
    high = np.where(near, widest, flat.max(axis=1))
    lit = np.asarray((low < widest).all(axis=1) & (high > -widest).all(axis=1))
    return np.maximum(low[lit], -widest), np.minimum(high[lit], widest)


def _cover(low: Floats, high: Floats, most: int) -> tuple[Floats, float, npt.NDArray[np.uint32]]:
    """Return a grid's corner and cell size, and those of its cells that a rectangle touches."""
    start = low.min(axis=0)
    side = float((high.max(axis=0) - start).max()) / most
    # Clipped, as the far edge may be rounded into the next cell.
    first = np.clip(((low - start) / side).astype(np.int64), 0, most - 1)
    last = np.clip(((high - start) / side).astype(np.int64), 0, most - 1) + 1
    # Two-dimensional differences of the number of rectangles over a cell.
    steps = np.zeros((most + 1, most + 1), dtype=np.int64)
    np.add.at(steps, (first[:, 0], first[:, 1]), 1)
    np.add.at(steps, (last[:, 0], last[:, 1]), 1)
    np.add.at(steps, (first[:, 0], last[:, 1]), -1)
    np.add.at(steps, (last[:, 0], first[:, 1]), -1)
    covered = steps.cumsum(axis=0).cumsum(axis=1) > 0
    return start, side, np.argwhere(covered).astype(np.uint32)
