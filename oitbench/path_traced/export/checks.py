"""Checks whether a scene can be path traced."""

from __future__ import annotations

import numpy as np

from oitbench.errors import CapabilityError
from oitbench.scene import Scene
from oitbench.scene.solids import mean_chord

_FLAT = 1e-9
"""Mean chord, as a part of the largest extent, of a mesh that encloses nothing but roundings."""


def require_traceable(scene: Scene) -> None:
    """Raise `CapabilityError` if `scene` cannot be path traced.

    Fragment lists have no geometry. The absorption in a refracting solid follows from its volume.
    Of triangles that coincide exactly, a ray hits only one, and surfaces in one plane in any order.
    """
    if scene.lists is not None:
        raise CapabilityError(
            f"scene {scene.name}: fragment lists have no geometry, so they cannot be path traced; "
            "give the scene meshes"
        )
    for item in scene.transparent:
        reach = float(np.ptp(item.mesh.used_positions, axis=0).max())
        if item.refracts and mean_chord(item.mesh) <= _FLAT * reach:
            raise CapabilityError(
                f"scene {scene.name}: {item.name} is a refracting solid without volume, so it"
                " cannot be path traced; close its mesh, or make it a thin sheet"
            )
    _require_distinct_triangles(scene)
    if scene.coincidence is not None:
        one, other = scene.coincidence.pair
        raise CapabilityError(
            f"scene {scene.name}: {one} and {other} lie in one plane, so that a ray hits them"
            " in any order; move one of them"
        )


def _require_distinct_triangles(scene: Scene) -> None:
    corners = [item.mesh.positions[item.mesh.triangles] for item in scene.objects]
    owners = np.repeat(np.arange(len(corners)), [len(part) for part in corners])
    triangles = np.concatenate(corners).astype(np.float32) + np.float32(0)
    edges = np.diff(triangles.astype(np.float64), axis=1)
    solid = np.cross(edges[:, 0], edges[:, 1]).any(axis=1)
    triangles, owners = triangles[solid], owners[solid]
    # Sort the corners of each triangle by (x, y, z): its first corner is arbitrary.
    order = np.lexsort(triangles.transpose(2, 0, 1)[::-1], axis=1)
    triangles = np.take_along_axis(triangles, order[..., None], axis=1)
    rows = np.ascontiguousarray(triangles.reshape(len(triangles), 9)).view("V36").ravel()
    _, inverse, counts = np.unique(rows, return_inverse=True, return_counts=True)
    doubled = np.flatnonzero(counts[inverse] > 1)
    if len(doubled):
        first = np.flatnonzero(inverse == inverse[doubled[0]])
        names = sorted({scene.objects[owners[index]].name for index in first})
        raise CapabilityError(
            f"scene {scene.name}: {len(doubled)} triangles coincide exactly, as in "
            f"{' and '.join(names)}, and a ray hits only one of each; move one of them"
        )
