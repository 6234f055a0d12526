"""Lighting baked into radiance at vertices, so that both renderers draw the same numbers.

The functions return linear Rec.709 factors for `Mesh.radiance`, which multiply the emission of the
material.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from oitbench.scene import RGB, Floats, Mesh, Vector, axes_along


@dataclass(frozen=True)
class Rig:
    """A key light with hemispherical fill light.

    Parameters
    ----------
    toward_key : Vector
        Direction from the surface to the key light; need not have unit length.
    key : RGB
        Radiance of a white Lambertian surface that faces the key light.
    sky, ground : RGB
        Radiance of a white Lambertian surface under the fill light, if it faces straight up and
        straight down; blended in between.
    """

    toward_key: Vector
    key: RGB
    sky: RGB
    ground: RGB

    @property
    def direction(self) -> Floats:
        """Unit vector to the key light."""
        direction = np.asarray(self.toward_key, dtype=np.float64)
        return np.asarray(direction / np.linalg.norm(direction))


def with_radiance(mesh: Mesh, radiance: npt.ArrayLike) -> Mesh:
    """Return `mesh` with `radiance`, shape (3,) or (n, 3), as the factor on its emission."""
    values = np.broadcast_to(np.asarray(radiance, dtype=np.float32), mesh.positions.shape)
    return replace(mesh, radiance=np.ascontiguousarray(values))


def normals_of(mesh: Mesh) -> Floats:
    """Return the mesh's vertex normals, shape (n, 3); raise `ValueError` if it has none."""
    if mesh.normals is None:
        raise ValueError("baked shading needs a mesh with normals")
    return mesh.normals.astype(np.float64)


def diffuse(
    normals: npt.ArrayLike,
    rig: Rig,
    lit: npt.ArrayLike = 1.0,
    openness: npt.ArrayLike = 1.0,
) -> Floats:
    """Return the radiance of a white Lambertian surface.

    Parameters
    ----------
    normals : array, shape (n, 3)
        Unit normals.
    rig : Rig
        The lights.
    lit : array, broadcastable to (n, 3)
        Fraction of the key light that arrives, per channel.
    openness : array, broadcastable to (n, 3)
        Fraction of the fill light that arrives: ambient occlusion.

    Returns
    -------
    array, shape (n, 3), float64
    """
    directions = np.asarray(normals, dtype=np.float64)
    facing = np.maximum(directions @ rig.direction, 0.0)[:, None]
    upward = 0.5 + 0.5 * directions[:, 1:2]
    fill = upward * np.asarray(rig.sky) + (1 - upward) * np.asarray(rig.ground)
    return np.asarray(facing * np.asarray(rig.key) * lit + fill * openness)


def cone(direction: npt.ArrayLike, spread: float, count: int) -> Floats:
    """Return unit directions, shape (count, 3), evenly spaced within `spread` radians of one.

    They form a Fibonacci spiral, so that an area light is sampled without random numbers.
    """
    right, up, axis = axes_along(direction)
    index = np.arange(count) + 0.5
    height = 1 - (1 - np.cos(spread)) * index / count
    angle = index * np.pi * (3 - np.sqrt(5))
    radius = np.sqrt(1 - height**2)
    plane = np.cos(angle)[:, None] * right + np.sin(angle)[:, None] * up
    return np.asarray(height[:, None] * axis - radius[:, None] * plane)


def sphere_chord(
    points: npt.ArrayLike, direction: npt.ArrayLike, center: Vector, radius: float
) -> Floats:
    """Return the length inside a ball of the ray from each point.

    Parameters
    ----------
    points : array, shape (n, 3)
        Origins of the rays, meters.
    direction : array, shape (3,)
        Unit vector of all rays.
    center : Vector
    radius : float
        Meters.

    Returns
    -------
    array, shape (n,), float64
        Meters. From a point inside the ball, the length of the way out.
    """
    toward = np.asarray(direction, dtype=np.float64)
    offset = np.asarray(center) - np.asarray(points, dtype=np.float64)
    closest = offset @ toward
    half = np.sqrt(np.maximum(radius**2 - (offset**2).sum(axis=-1) + closest**2, 0.0))
    return np.asarray(np.maximum(closest + half, 0) - np.maximum(closest - half, 0))


def tint(weights: npt.ArrayLike, colors: Sequence[RGB]) -> Floats:
    """Return colors along a ramp, shape (n, 3): weight 0 is the first of `colors`, 1 the last."""
    at = np.asarray(weights, dtype=np.float64) * (len(colors) - 1)
    stops = np.asarray(colors, dtype=np.float64)
    return np.stack([np.interp(at, np.arange(len(colors)), channel) for channel in stops.T], axis=1)
