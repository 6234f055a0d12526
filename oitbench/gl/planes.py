"""Common planes of coincident surfaces, from which shaders take one depth for all of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from oitbench.scene import Array, Camera, Floats, Scene
from oitbench.scene.coincidence import Coincidence, find_coincidence, origin_of_planes

PLANE_FORMAT, PLANE_NAME = "3f4", "in_plane"


def with_separate_corners(scene: Scene) -> tuple[Scene, Coincidence | None]:
    """Return `scene` with three vertices for each triangle of coincident objects.

    Vertices can then hold the plane of their triangle.

    Parameters
    ----------
    scene : Scene
        Seen from the origin.
    """
    found = find_coincidence(scene.objects, origin_of_planes(scene.camera))
    if found is None:
        return scene, None
    objects = tuple(
        replace(item, mesh=item.mesh.with_separate_corners()) if item.name in found.planes else item
        for item in scene.objects
    )
    return replace(scene, objects=objects), found


def nearness_of_vertices(scene: Scene, found: Coincidence) -> Array:
    """Return rows (A, B, C) of all vertices, opaque objects first, shape (n, 3).

    The point of a plane at which the camera looks along the slopes (x, y) has the inverse view
    distance A·x + B·y + C; if the camera is orthographic, the point at (x, y) of the picture has
    that view distance. Rows are 0 for triangles that coincide with nothing.
    """
    parts: list[Floats] = []
    for item in (*scene.opaque, *scene.transparent):
        duals = found.planes.get(item.name)
        count = len(item.mesh.positions)
        parts.append(
            np.zeros((count, 3)) if duals is None else np.repeat(_rows(scene.camera, duals), 3, 0)
        )
    return np.concatenate(parts).astype(np.float32)


def _rows(camera: Camera, duals: Floats) -> Floats:
    """Return (A, B, C) of planes by their dual points, shape (n, 3)."""
    nearness = duals @ (camera.axes.T * (1.0, 1.0, -1.0))
    if not camera.orthographic:
        return np.asarray(nearness)
    # q·(x right + y up − z back) = 1 + q·origin, and the origin lies behind the camera.
    found = np.zeros_like(nearness)
    steep = nearness[:, 2] != 0  # No plane that is seen edge on.
    shift = 1 + duals @ origin_of_planes(camera)
    found[steep, :2] = -nearness[steep, :2] / nearness[steep, 2:]
    found[steep, 2] = shift[steep] / nearness[steep, 2]
    return found
