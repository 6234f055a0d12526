"""The caustic map: irradiance from beams through refracting solids, by photon mapping.

A path that is refracted cannot hit a directional light or the point of a spot light by chance.
Photons are therefore traced from the light (Jensen 1996, "Global illumination using photon maps").
They are summed in the square cells of a grid and not found as nearest neighbors, so that a lookup
is a few searches in a sorted list.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from oitbench.path_traced.export.shapes import solids
from oitbench.path_traced.photons.cells import BITS, WIDER, PhotonCells
from oitbench.path_traced.photons.emission import Emission
from oitbench.path_traced.photons.paths import DEPTH, Interiors, PhotonPaths
from oitbench.scene import Scene

CELL_PHOTONS = 128
"""Photons in a cell where the light is not concentrated. The side of a cell is √(128 A/n) for n
photons of beams of cross-section A. Smaller cells are noisier; larger ones blur more."""
THICKNESS = 4
"""Half the thickness of a cell along its axis, in sides. Tilted surfaces are thus not cut off."""
LEAST_FACING = 0.4
"""Least component of the normal along an axis for which a photon is stored. A lookup uses the axis
of the largest component, at least 0.58. On a curved surface it also needs photons of its
neighborhood, whose component along this axis may be smaller."""
CHUNK = 1 << 19
"""Photons that are traced at once. Each needs some hundred bytes."""


@dataclass(frozen=True, eq=False)
class CausticMap:
    """Irradiance through refracting solids, in a grid of square cells on all surfaces.

    A cell is identified by the axis that its surface faces most, the sign, two coordinates across
    this axis and one along it. A lookup interpolates between four cells. Light is thus spread over
    about two sides of a cell, or `WIDER` times that where photons are sparse. Smaller surfaces, and
    the edges of surfaces, are too dark. Both sides of a surface are lit. A medium outside of the
    solids does not dim the photons.

    Parameters
    ----------
    mitsuba, drjit : module
        With an LLVM or CUDA variant set.
    origin : Point3f
        Origin of the grid, meters.
    side : Float
        Side of a cell in meters; that of a wide cell is `WIDER` times as large.
    keys : UInt64
        Cells that receive any light, ascending.
    light : Float
        Irradiance of these cells, three channels each, W·m⁻².
    """

    mitsuba: Any
    drjit: Any
    origin: Any
    side: Any
    keys: Any
    light: Any

    @classmethod
    def build(
        cls, mitsuba: Any, drjit: Any, content: Any, scene: Scene, count: int, seed: int
    ) -> CausticMap | None:
        """Trace about `count` photons from the beams of `scene` through its refracting solids.

        Parameters
        ----------
        mitsuba, drjit : module
            With an LLVM or CUDA variant set.
        content : mitsuba.Scene
            The exported scene. Its refracting solids are the shape `export.shapes.SOLIDS`. All
            other surfaces receive photons, and transmit by `eval_null_transmission` of their BSDF.
        scene : Scene
            The scene that was exported, where solids overlap instead of touching.
        count : int
            Number of photons of all beams together.
        seed : int

        Returns
        -------
        CausticMap or None
            None if there is no beam, no refracting solid, or none that a beam can hit.
        """
        items = solids(scene)
        if not items or not scene.beams:
            return None
        triangles = np.concatenate(
            [item.mesh.positions[item.mesh.triangles] for item in items]
        ).astype(np.float64)
        box = content.bbox()
        bounds = (np.array(box.min, np.float64).ravel(), np.array(box.max, np.float64).ravel())
        share = -(-count // len(scene.beams))
        found = [Emission.toward(light, triangles, share, bounds) for light in scene.beams]
        emissions = [emission for emission in found if emission is not None]
        if not emissions:
            return None
        total = sum(emission.count for emission in emissions)
        side = math.sqrt(CELL_PHOTONS * sum(emission.area for emission in emissions) / total)
        # With opaque values, the kernel is the same for every scene and is compiled only once.
        middle = mitsuba.Point3f(*triangles.mean(axis=(0, 1)).tolist())
        drjit.make_opaque(middle)
        frame = middle, drjit.opaque(mitsuba.Float, side)
        grid = cls(mitsuba, drjit, *frame, mitsuba.UInt64(), mitsuba.Float())
        cells = PhotonCells()
        for number, emission in enumerate(emissions):
            seeds = np.random.SeedSequence((seed, number)).generate_state(1 + 2 * DEPTH).tolist()
            interiors = Interiors.build(mitsuba, drjit, content, scene, emission.origin)
            paths = PhotonPaths(mitsuba, drjit, content, interiors, seeds[1:])
            for first in range(0, emission.count, CHUNK):
                index = drjit.arange(mitsuba.UInt32, min(CHUNK, emission.count - first))
                index += drjit.opaque(mitsuba.UInt32, first)
                for hit in paths.follow(*emission.emit(mitsuba, drjit, index, seeds[0]), index):
                    grid._deposit(cells, *hit)
        keys, power = cells.finish()
        wide = keys >> np.uint64(3 * BITS + 3)
        light = power / np.where(wide, side * WIDER, side)[:, None] ** 2
        light = mitsuba.Float(light.astype(np.float32).ravel())
        return replace(grid, keys=mitsuba.UInt64(keys), light=light)

    def irradiance(self, si: Any, active: Any) -> Any:
        """Return the irradiance at the interaction `si`, Color3f in W·m⁻²; 0 if not `active`."""
        color = self.mitsuba.Color3f
        # Lookups are slow. Most rays that cross particles need none.
        return self.drjit.if_stmt(
            (si.p, si.n, active), active, self._irradiance, lambda p, n, active: color(0)
        )

    def _irradiance(self, p: Any, n: Any, active: Any) -> Any:
        drjit, mitsuba = self.drjit, self.mitsuba
        x, y, z = (drjit.abs(value) for value in n)
        total = mitsuba.Color3f(0)
        along_x, along_y = (x >= y) & (x >= z), y >= z
        axis = drjit.select(along_x, 0, drjit.select(along_y, 1, mitsuba.UInt32(2)))
        places = [self._place(p, n, number) for number in range(3)]
        u, v, w, facing = (
            drjit.select(along_x, a, drjit.select(along_y, b, c))
            for a, b, c in zip(*places, strict=True)
        )
        for level in range(2):
            left, low = u - 0.5, v - 0.5
            column, row, layer = drjit.floor(left), drjit.floor(low), drjit.floor(w - 0.5)
            for right, across in ((0, 1 - (left - column)), (1, left - column)):
                for up, along in ((0, 1 - (low - row)), (1, low - row)):
                    cell = column + right, row + up, layer
                    key, inside = self._key(level, axis, facing, cell)
                    light = self._light(key, inside & active) * (across * along)
                    total += drjit.select(inside & active, light, 0)
            u, v, w = u / WIDER, v / WIDER, w / WIDER
        return total

    def _light(self, key: Any, active: Any) -> Any:
        drjit, mitsuba = self.drjit, self.mitsuba
        count = len(self.keys)
        if not count:
            return mitsuba.Color3f(0)
        found = drjit.binary_search(
            0,
            count - 1,
            lambda index: drjit.gather(mitsuba.UInt64, self.keys, index, active) < key,
        )
        active = active & (drjit.gather(mitsuba.UInt64, self.keys, found, active) == key)
        return drjit.gather(mitsuba.Color3f, self.light, found, active)

    def _place(self, p: Any, n: Any, axis: int) -> tuple[Any, Any, Any, Any]:
        """Return coordinates across and along `axis`, in cells, and the normal's component."""
        offset = (p - self.origin) / self.side
        across = offset[(axis + 1) % 3], offset[(axis + 2) % 3]
        return *across, offset[axis] / THICKNESS, n[axis]

    def _key(self, level: int, axis: Any, facing: Any, cell: Sequence[Any]) -> tuple[Any, Any]:
        """Return the key of the cell at three integer coordinates, and whether it has one."""
        drjit, mitsuba = self.drjit, self.mitsuba
        middle = (1 << (BITS - 1)) // WIDER**level
        head = (level << 3) + 2 * axis + drjit.select(facing < 0, mitsuba.UInt32(1), 0)
        key, inside = mitsuba.UInt64(head), mitsuba.Bool(True)
        for value in cell:
            inside &= drjit.abs(value) < middle // 2
            number = mitsuba.UInt32(drjit.select(inside, value, 0) + middle)
            key = (key << BITS) | mitsuba.UInt64(number)
        return key, inside

    def _deposit(self, cells: PhotonCells, p: Any, n: Any, power: Any, active: Any) -> None:
        """Add the photons that arrive at `p` to `cells`, for each axis that the surface faces."""
        drjit, mitsuba = self.drjit, self.mitsuba
        hit = drjit.compress(active)
        if not len(hit):
            return
        p, n, power = (drjit.gather(type(value), value, hit) for value in (p, n, power))
        deposits = []
        for axis in range(3):
            *cell, facing = self._place(p, n, axis)
            number = mitsuba.UInt32(axis)
            key, inside = self._key(0, number, facing, [drjit.floor(value) for value in cell])
            # The surface within a cell is larger than the cell's cross-section if it is tilted.
            facing = drjit.abs(facing)
            deposits.append((key, power * facing, inside & (facing > LEAST_FACING)))
        drjit.eval(deposits)
        for key, value, counts in deposits:
            chosen = counts.numpy()
            cells.add(key.numpy()[chosen], value.numpy().T[chosen])
