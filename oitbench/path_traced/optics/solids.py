"""Which refracting solids a line runs inside of, where they touch, overlap or contain each other.

Where solids overlap, the one of highest priority fills the space (Schmidt & Budge 2002, "Simple
nested dielectrics in ray traced images"). A face of another solid is no interface there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from oitbench.path_traced.optics.materials import absorption
from oitbench.scene import BLACK, Floats, Mesh, Object, Scene

DEPTH = 4
"""Most solids that a point may lie in at once; of more, those of the lowest ranks are forgotten."""
_AWAY = np.array([0.5377, 0.3178, 0.7809])
"""A direction that is parallel to no face that a modeler would make."""

Nest = tuple[Any, ...]
"""Ranks of the solids that a line runs inside of, UInt32 in falling order, then zeros. The first
one fills the space. It has no elements if no solid refracts."""


@dataclass(frozen=True)
class Meeting:
    """What a line meets at a face of a solid.

    Parameters
    ----------
    before, behind : Nest
        On the side that the line comes from, and on the other one.
    hidden : Bool
        Whether a solid of higher rank fills the space on both sides.
    inner : Bool
        Whether the line comes from inside of a solid.
    index : Float
        Refractive index behind the face's back, relative to that before its front.
    """

    before: Nest
    behind: Nest
    hidden: Any
    inner: Any
    index: Any


@dataclass(frozen=True, eq=False)
class Solids:
    """The refracting solids of a scene by rank; rank 0 is the space outside of all of them.

    Parameters
    ----------
    mitsuba, drjit : module
    indices : Float
        Refractive index of each rank.
    absorptions : Float
        Absorption coefficient of each rank, three channels, m⁻¹.
    around : tuple of int
        The `Nest` of the point from which lines start: the camera or a light.
    """

    mitsuba: Any
    drjit: Any
    indices: Any
    absorptions: Any
    around: tuple[int, ...]

    @classmethod
    def build(
        cls, mitsuba: Any, drjit: Any, scene: Scene, start: Floats
    ) -> tuple[Solids, dict[str, int]]:
        """Rank the refracting solids of `scene`; return also the rank of each by its name.

        The rank rises with the priority. Of equal priorities, the first solid has the highest rank.
        Lines start from the point `start`.
        """
        found = [item for item in scene.transparent if item.refracts]
        # Sorting keeps the order of equal priorities.
        chosen = sorted(found, key=lambda item: -item.priority)[::-1]
        ranks = {item.name: rank for rank, item in enumerate(chosen, 1)}
        values = np.asarray([BLACK, *(absorption(item) for item in chosen)], dtype=np.float32)
        indices = np.asarray([1.0, *(item.material.index for item in chosen)], dtype=np.float32)
        around = [rank for rank, item in enumerate(chosen, 1) if _contains(item.mesh, start)][::-1]
        depth = min(DEPTH, len(chosen)) if around or _overlap(chosen) else min(1, len(chosen))
        nest = tuple((around + [0] * depth)[:depth])
        tables = mitsuba.Float(indices), mitsuba.Float(values.ravel())
        return cls(mitsuba, drjit, *tables, nest), ranks

    def start(self) -> Nest:
        """Return the nest of the point from which lines start."""
        return tuple(self.mitsuba.UInt32(rank) for rank in self.around)

    def meet(self, nest: Nest, rank: Any, outside: Any, active: Any) -> Meeting:
        """Return what a line in `nest` meets at a face of the solid of `rank`.

        The side of the face that is hit, `outside`, decides whether the line is inside of the
        solid. A line that has lost an earlier face is thus corrected.
        """
        drjit = self.drjit
        front = _without(drjit, nest, rank)
        back = _with(drjit, front, rank)
        before = tuple(
            drjit.select(active, drjit.select(outside, a, b), c)
            for a, b, c in zip(front, back, nest, strict=True)
        )
        behind = tuple(
            drjit.select(active, drjit.select(outside, b, a), c)
            for a, b, c in zip(front, back, nest, strict=True)
        )
        index = self._index(back, active) / self._index(front, active)
        return Meeting(before, behind, active & (front[0] == back[0]), before[0] > 0, index)

    def passing(self, nest: Nest, length: Any, active: Any) -> Any:
        """Return what the solid that fills the space lets pass over `length` meters, Color3f."""
        if not nest:
            return self.mitsuba.Color3f(1)
        sigma = self.drjit.gather(self.mitsuba.Color3f, self.absorptions, nest[0], active)
        return self.drjit.exp(-sigma * self.drjit.select(active, length, 0))

    def index_around(self) -> float:
        """Return the refractive index around the point from which lines start."""
        return float(self.indices.numpy()[self.around[0]]) if self.around else 1.0

    def _index(self, nest: Nest, active: Any) -> Any:
        return self.drjit.gather(self.mitsuba.Float, self.indices, nest[0], active)


def _without(drjit: Any, nest: Nest, rank: Any) -> Nest:
    found, slots = drjit.mask_t(rank)(False), []
    for slot, following in zip(nest, (*nest[1:], type(rank)(0)), strict=True):
        found = found | (slot == rank)
        slots.append(drjit.select(found, following, slot))
    return tuple(slots)


def _with(drjit: Any, nest: Nest, rank: Any) -> Nest:
    slots = []
    for slot in nest:
        slots.append(drjit.maximum(slot, rank))
        rank = drjit.minimum(slot, rank)
    return tuple(slots)


def _overlap(items: Sequence[Object]) -> bool:
    """Return whether the bounding boxes of any two objects touch."""
    boxes = [(item.mesh.used_positions.min(0), item.mesh.used_positions.max(0)) for item in items]
    low, high = (np.array(corners).reshape(-1, 3) for corners in zip(*boxes, strict=True))
    touching = (low[:, None] <= high).all(-1) & (low <= high[:, None]).all(-1)
    return bool(touching.sum() > len(items))


def _contains(mesh: Mesh, point: Floats) -> bool:
    """Return whether `point` is inside of a closed mesh: a ray leaves it once more."""
    a, b, c = (mesh.positions[mesh.triangles] - point).swapaxes(0, 1)
    volumes = [np.cross(p, q) @ _AWAY for p, q in ((a, b), (b, c), (c, a))]
    total = np.einsum("ij,ij->i", np.cross(b - a, c - a), a)
    # The ray crosses a triangle if it passes all edges on one side, and ahead of the point.
    out = np.logical_and.reduce([volume >= 0 for volume in volumes]) & (total > 0)
    into = np.logical_and.reduce([volume <= 0 for volume in volumes]) & (total < 0)
    return int(out.sum()) > int(into.sum())
