"""Simple lighting baked into per-vertex radiance, so that both renderers draw the same numbers.

Everything here returns linear Rec.709 factors for `Mesh.radiance`, which multiplies the emission
of the material. Directions named `toward_key` point from the surface to the light.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from oitbench.scene import RGB, Mesh

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Rig:
    """One key light under a hemisphere of fill light.

    Parameters
    ----------
    toward_key : RGB
        Direction to the key light; need not be a unit vector.
    key : RGB
        Radiance that a white Lambertian surface shows when it faces the key light.
    sky, ground : RGB
        The same for fill light from above and from below; normals between see a blend of both.
    """

    toward_key: RGB
    key: RGB
    sky: RGB
    ground: RGB

    @property
    def direction(self) -> Floats:
        """The unit vector to the key light."""
        direction = np.asarray(self.toward_key, dtype=np.float64)
        return np.asarray(direction / np.linalg.norm(direction))


def with_radiance(mesh: Mesh, radiance: npt.ArrayLike) -> Mesh:
    """Return `mesh` with a factor of shape (3,) or (n, 3) on its emission at each vertex."""
    values = np.broadcast_to(np.asarray(radiance, dtype=np.float32), mesh.positions.shape)
    return replace(mesh, radiance=np.ascontiguousarray(values))


def normals_of(mesh: Mesh) -> Floats:
    """Return the mesh's vertex normals, shape (n, 3); it must have them."""
    if mesh.normals is None:
        raise ValueError("baked shading needs a mesh with normals")
    return mesh.normals.astype(np.float64)


def diffuse(
    normals: npt.ArrayLike,
    rig: Rig,
    lit: npt.ArrayLike = 1.0,
    openness: npt.ArrayLike = 1.0,
) -> Floats:
    """Return what a white Lambertian surface shows, shape (n, 3).

    Parameters
    ----------
    normals : array, shape (n, 3)
        Unit normals.
    rig : Rig
        The lights.
    lit : array, broadcastable to (n, 3)
        Fraction of the key light that arrives, per channel behind colored glass.
    openness : array, broadcastable to (n, 3)
        Fraction of the fill light that arrives: ambient occlusion.
    """
    directions = np.asarray(normals, dtype=np.float64)
    facing = np.maximum(directions @ rig.direction, 0.0)[:, None]
    upward = 0.5 + 0.5 * directions[:, 1:2]
    fill = upward * np.asarray(rig.sky) + (1 - upward) * np.asarray(rig.ground)
    return np.asarray(facing * np.asarray(rig.key) * lit + fill * openness)


def cone(direction: npt.ArrayLike, spread: float, count: int) -> Floats:
    """Return `count` unit directions, shape (count, 3), evenly within `spread` radians of one.

    They form a Fibonacci spiral, so an area light is sampled without random numbers.
    """
    axis = np.asarray(direction, dtype=np.float64)
    axis = axis / np.linalg.norm(axis)
    side = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    side /= np.linalg.norm(side)
    index = np.arange(count) + 0.5
    height = 1 - (1 - np.cos(spread)) * index / count
    angle = index * np.pi * (3 - np.sqrt(5))
    radius = np.sqrt(1 - height**2)
    plane = np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * np.cross(axis, side)
    return np.asarray(height[:, None] * axis + radius[:, None] * plane)


def sphere_chord(
    points: npt.ArrayLike, direction: npt.ArrayLike, center: RGB, radius: float
) -> Floats:
    """Return how many metres of a ball lie on the rays from `points`, shape (n, 3) → (n,).

    `direction` is one unit vector. Points inside the ball see the rest of it.
    """
    toward = np.asarray(direction, dtype=np.float64)
    offset = np.asarray(center) - np.asarray(points, dtype=np.float64)
    closest = offset @ toward
    half = np.sqrt(np.maximum(radius**2 - (offset**2).sum(axis=-1) + closest**2, 0.0))
    return np.asarray(np.maximum(closest + half, 0) - np.maximum(closest - half, 0))


def tint(weights: npt.ArrayLike, colors: Sequence[RGB]) -> Floats:
    """Return colors along a ramp: weight 0 is the first of `colors`, 1 the last; shape (n, 3)."""
    at = np.asarray(weights, dtype=np.float64) * (len(colors) - 1)
    stops = np.asarray(colors, dtype=np.float64)
    return np.stack([np.interp(at, np.arange(len(colors)), channel) for channel in stops.T], axis=1)
