"""Checks whether a scene can be path traced."""

from __future__ import annotations

import numpy as np

from oitbench.errors import CapabilityError
from oitbench.scene import Scene


def require_traceable(scene: Scene) -> None:
    """Raise `CapabilityError` if `scene` cannot be path traced.

    Fragment lists have no geometry. Of triangles that coincide exactly, a ray hits only one.
    """
    if scene.lists is not None:
        raise CapabilityError(
            f"scene {scene.name}: fragment lists have no geometry, so they cannot be path traced; "
            "give the scene meshes"
        )
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
