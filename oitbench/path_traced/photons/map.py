"""Caustics by photon mapping: what beams deliver through refracting solids.

A path cannot find a direction or a point of light through glass by chance, so photons are shot from
the light instead (Jensen 1996, "Global illumination using photon maps"). They are gathered in the
square cells of a grid rather than by nearest neighbors: a lookup is four searches in a sorted list.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from oitbench.errors import CapabilityError
from oitbench.path_traced.photons.aim import Aim
from oitbench.path_traced.photons.cells import BITS, WIDER, PhotonCells
from oitbench.path_traced.photons.paths import DEPTH, PhotonPaths
from oitbench.scene import Mesh, Object, Scene

CELL_PHOTONS = 128
"""Photons in a cell where the light is not concentrated: its side is √(128 A/n) for n photons of
beams of cross-section A. Fewer are noisier, more are blurred."""
THICKNESS = 4
"""Half the thickness of a cell along its axis, in sides: none of a tilted surface is cut off."""
LEAST_FACING = 0.4
"""A photon is stored for each axis that its surface's normal has this much of: a curved surface is
looked up along the longest one, at least 0.58, and needs its neighborhood there."""
CHUNK = 1 << 19
"""Photons that are traced at once: some hundred bytes each."""
CLEAREST = 1e-6
"""Least transmission that has a finite absorption."""


def mean_chord(mesh: Mesh) -> float:
    """Return the mean length 4V/S of the chords through a closed mesh, in metres (Cauchy)."""
    corners = mesh.positions[mesh.triangles].astype(np.float64)
    corners = corners - corners.mean(axis=(0, 1))
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    surface = np.linalg.norm(cross, axis=1).sum() / 2
    volume = abs(float((corners[:, 0] * cross).sum())) / 6
    return 4 * volume / float(surface)


def absorption(item: Object) -> tuple[float, float, float]:
    """Return σ = −2 ln(T)/l, m⁻¹ per channel: a mean chord l loses what its two surfaces absorb."""
    length = mean_chord(item.mesh)
    red, green, blue = (
        -2 * math.log(max(part, CLEAREST)) / length for part in item.material.transmission
    )
    return red, green, blue


def solids(scene: Scene) -> dict[str, Object]:
    """Return the refracting objects by the ids that their Mitsuba shapes must have."""
    found = [item for item in scene.transparent if item.material.refracts]
    return {f"solid_{number}": item for number, item in enumerate(found)}


@dataclass(frozen=True, eq=False)
class CausticMap:
    """Irradiance through refracting solids, in a grid of square cells on all surfaces.

    A cell is known by the axis that its surface faces most, the sign, two coordinates across and
    one along it. The light in four cells is interpolated, so it is spread over about two sides, or
    `WIDER` times that where photons are sparse; surfaces smaller than that, and their edges, come
    out too dark. Both sides of a surface are lit. A medium in the air takes no light away.

    Parameters
    ----------
    mitsuba, drjit : module
        With an LLVM or CUDA variant set.
    origin : Point3f
        Metres.
    side : Float
        Of a cell, in metres; wide cells have `WIDER` times it.
    keys : UInt64
        Of the cells with any light, ascending.
    light : Float
        Their irradiance, three channels each, W·m⁻².
    """

    mitsuba: Any
    drjit: Any
    origin: Any
    side: Any
    keys: Any
    light: Any

    @classmethod
    def build(
        cls, mitsuba: Any, drjit: Any, mitsuba_scene: Any, scene: Scene, count: int, seed: int
    ) -> CausticMap | None:
        """Trace about `count` photons from the beams of `scene` through its refracting solids.

        Parameters
        ----------
        mitsuba, drjit : module
            With a variant set.
        mitsuba_scene : mitsuba.Scene
            Of the same scene; its shapes have the ids that `solids` gives. All other surfaces
            receive, and let through what `eval_null_transmission` of their BSDF says.
        scene : Scene
        count, seed : int

        Returns
        -------
        CausticMap or None
            None if there is no beam, no refracting solid, or none that a beam can meet.

        Raises
        ------
        CapabilityError
            In a scalar variant of Mitsuba.
        """
        items = solids(scene)
        if not items or not scene.beams:
            return None
        if mitsuba.variant().startswith("scalar"):
            raise CapabilityError(
                f"scene {scene.name}: caustics are not traced by {mitsuba.variant()}; "
                "install an LLVM library that drjit works with"
            )
        triangles = np.concatenate([_triangles(item.mesh) for item in items.values()])
        box = mitsuba_scene.bbox()
        bounds = (np.array(box.min, np.float64).ravel(), np.array(box.max, np.float64).ravel())
        share = -(-count // len(scene.beams))
        found = [Aim.at(light, triangles, share, bounds) for light in scene.beams]
        aims = [aim for aim in found if aim is not None]
        if not aims:
            return None
        total = sum(aim.count for aim in aims)
        side = math.sqrt(CELL_PHOTONS * sum(aim.area for aim in aims) / total)
        # Opaque values leave the kernel the same for every scene, so that it is compiled once.
        middle = mitsuba.Point3f(*triangles.mean(axis=(0, 1)).tolist())
        drjit.make_opaque(middle)
        frame = middle, drjit.opaque(mitsuba.Float, side)
        grid = cls(mitsuba, drjit, *frame, mitsuba.UInt64(), mitsuba.Float())
        media = _media(mitsuba, drjit, mitsuba_scene, items)
        cells = PhotonCells()
        for number, aim in enumerate(aims):
            seeds = np.random.SeedSequence((seed, number)).generate_state(1 + 2 * DEPTH).tolist()
            paths = PhotonPaths(mitsuba, drjit, mitsuba_scene, media, seeds[1:])
            for first in range(0, aim.count, CHUNK):
                index = drjit.arange(mitsuba.UInt32, min(CHUNK, aim.count - first))
                index += drjit.opaque(mitsuba.UInt32, first)
                for hit in paths.follow(*aim.emit(mitsuba, drjit, index, seeds[0]), index):
                    grid._deposit(cells, *hit)
        keys, power = cells.finish()
        wide = keys >> np.uint64(3 * BITS + 3)
        light = power / np.where(wide, side * WIDER, side)[:, None] ** 2
        light = mitsuba.Float(light.astype(np.float32).ravel())
        return replace(grid, keys=mitsuba.UInt64(keys), light=light)

    def irradiance(self, si: Any, active: Any = True) -> Any:
        """Return the irradiance at the interaction `si`, Color3f in W·m⁻²."""
        drjit, mitsuba = self.drjit, self.mitsuba
        x, y, z = (drjit.abs(value) for value in si.n)
        total = mitsuba.Color3f(0)
        along_x, along_y = (x >= y) & (x >= z), y >= z
        axis = drjit.select(along_x, 0, drjit.select(along_y, 1, mitsuba.UInt32(2)))
        places = [self._place(si.p, si.n, number) for number in range(3)]
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
        """Return coordinates across and along `axis`, in cells, and the normal along it."""
        offset = (p - self.origin) / self.side
        across = offset[(axis + 1) % 3], offset[(axis + 2) % 3]
        return *across, offset[axis] / THICKNESS, n[axis]

    def _key(self, level: int, axis: Any, facing: Any, cell: Sequence[Any]) -> tuple[Any, Any]:
        """Return the key of the cell of three whole coordinates, and whether it has any."""
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
        """Add the photons of `power` that arrive at `p` to `cells`, for each axis that it faces."""
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
            # A cell's surface is larger than its cross-section where it is tilted.
            facing = drjit.abs(facing)
            deposits.append((key, power * facing, inside & (facing > LEAST_FACING)))
        drjit.eval(deposits)
        for key, value, counts in deposits:
            chosen = counts.numpy()
            cells.add(key.numpy()[chosen], value.numpy().T[chosen])


def _triangles(mesh: Mesh) -> npt.NDArray[np.float64]:
    return mesh.positions[mesh.triangles].astype(np.float64)


def _media(
    mitsuba: Any, drjit: Any, mitsuba_scene: Any, items: dict[str, Object]
) -> list[tuple[Any, Any, Any]]:
    """Return each refracting solid's shape, absorption, and what enters of light that passes."""
    shapes = {shape.id(): shape for shape in mitsuba_scene.shapes()}
    missing = sorted(set(items) - set(shapes))
    if missing:
        raise ValueError(f"the Mitsuba scene has no shape {', '.join(missing)}")
    color = mitsuba.Color3f
    media = [
        (mitsuba.ShapePtr(shapes[name]), color(*absorption(item)), 1 - color(*item.material.albedo))
        for name, item in items.items()
    ]
    drjit.make_opaque(media)
    return media
