"""Strands: flat ribbons along curves, which face the camera."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from oitbench.scene import Camera, Floats, Mesh, unit


def tangents(points: Floats) -> Floats:
    """Return unit tangents of curves, shape (n, k, 3)."""
    return unit(np.gradient(points, axis=1))


def ribbons(points: Floats, width: float, radiance: npt.ArrayLike, camera: Camera) -> Mesh:
    """Return one ribbon along each curve, perpendicular to the line of sight.

    Parameters
    ----------
    points : array, shape (n, k, 3)
        Curves of k points, meters.
    width : float
        Meters.
    radiance : array, shape (n, k, 3)
        Factor on the emission at each point.
    camera : Camera
    """
    count, length = points.shape[:2]
    sight = unit(points - np.asarray(camera.position))
    along = tangents(points)
    across = unit(np.cross(along, sight) + 1e-9 * camera.axes[0]) * (0.5 * width)
    edges = np.stack([points - across, points + across], axis=2)
    corner = np.arange(length - 1) * 2
    pair = np.concatenate(
        [
            np.stack([corner, corner + 1, corner + 3], axis=1),
            np.stack([corner, corner + 3, corner + 2], axis=1),
        ],
        axis=1,
    ).reshape(-1, 3)
    triangles = pair[None] + 2 * length * np.arange(count)[:, None, None]
    shades = np.repeat(np.asarray(radiance)[:, :, None], 2, axis=2)
    normals = np.repeat(unit(np.cross(across, along))[:, :, None], 2, axis=2)
    return Mesh.from_arrays(
        edges.reshape(-1, 3),
        triangles.reshape(-1, 3),
        radiance=shades.reshape(-1, 3),
        normals=normals.reshape(-1, 3),
    )
