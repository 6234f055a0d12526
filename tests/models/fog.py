"""Ray-marched fog in double precision: the slices of each view ray are layers to composite.

Pictures are (h, w), top row first.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from oitbench.scene import (
    PENUMBRA,
    Camera,
    DirectionalLight,
    Floats,
    FragmentLists,
    Medium,
    SpotLight,
)
from tests.models.hashing import fraction, pcg3d
from tests.models.view import origins, rays


@dataclass(frozen=True, eq=False)
class Slices:
    """Slices of a medium: z and coverage, shape (n, h, w), and radiance, shape (n, h, w, 3)."""

    z: Floats
    coverage: Floats
    radiance: Floats

    def lists(self) -> FragmentLists:
        """Return the slices as fragment lists."""
        single = self.radiance.astype(np.float32)
        return FragmentLists(
            self.z.astype(np.float32),
            self.coverage.astype(np.float32),
            single,
            np.zeros_like(single),
        )


def phase(cosine: npt.ArrayLike, g: float) -> Floats:
    """Return the phase function of Henyey & Greenstein, 1/sr."""
    base = 1 + g * g - 2 * g * np.asarray(cosine, dtype=np.float64)
    return np.asarray((1 - g * g) / (4 * np.pi * base**1.5))


def jitter(size: tuple[int, int]) -> Floats:
    """Return the position in a slice that each pixel samples, in [0, 1)."""
    width, height = size
    x, y = np.meshgrid(np.arange(width, dtype=np.uint32), np.arange(height, dtype=np.uint32)[::-1])
    bayer = np.array([[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]])
    block, _, _ = pcg3d(x // 4, y // 4, 0)
    return np.asarray((bayer[y % 4, x % 4] / 16 + fraction(block).astype(np.float64)) % 1)


def density(medium: Medium, points: Floats) -> Floats:
    """Return the density at points (..., 3), linear between cells and constant at the border."""
    if medium.density is None:
        return np.ones(points.shape[:-1])
    low, high = np.asarray(medium.low), np.asarray(medium.high)
    cells = medium.density.astype(np.float64)
    count = np.array(cells.shape[::-1])
    place = np.clip((points - low) / (high - low) * count - 0.5, 0, count - 1)
    first = np.minimum(np.floor(place).astype(int), np.maximum(count - 2, 0))
    part = place - first
    total = np.zeros(points.shape[:-1])
    for corner in np.ndindex(2, 2, 2):
        at = np.minimum(first + corner, count - 1)
        weight = np.where(corner, part, 1 - part).prod(axis=-1)
        total += weight * cells[at[..., 2], at[..., 1], at[..., 0]]
    return total


def beam(light: DirectionalLight | SpotLight, points: Floats) -> tuple[Floats, Floats]:
    """Return the direction of the light and its irradiance at points (..., 3), without shadows."""
    if isinstance(light, DirectionalLight):
        travel = np.asarray(light.direction) / np.linalg.norm(light.direction)
        return np.broadcast_to(travel, points.shape), np.broadcast_to(
            light.irradiance, points.shape
        )
    away = points - np.asarray(light.position)
    distance = np.linalg.norm(away, axis=-1, keepdims=True)
    travel = away / distance
    axis = np.subtract(light.target, light.position)
    angle = np.arccos(np.clip(travel @ (axis / np.linalg.norm(axis)), -1, 1))[..., None]
    half = light.angle / 2
    falloff = np.clip((half - angle) / (PENUMBRA * half), 0, 1)
    return travel, np.asarray(light.intensity) * falloff / distance**2


def passing(
    medium: Medium, light: DirectionalLight | SpotLight, points: Floats, steps: int
) -> Floats:
    """Return the part of a light that passes the medium to points (..., 3), shape (..., 1)."""
    if isinstance(light, DirectionalLight):
        toward = -np.asarray(light.direction) / np.linalg.norm(light.direction)
        toward, lamp = np.broadcast_to(toward, points.shape), np.full(points.shape[:-1], np.inf)
    else:
        lamp = np.linalg.norm(np.asarray(light.position) - points, axis=-1)
        toward = (np.asarray(light.position) - points) / lamp[..., None]
    with np.errstate(divide="ignore"):
        ends = [(np.asarray(corner) - points) / toward for corner in (medium.low, medium.high)]
    enters = np.maximum(np.minimum(*ends).max(axis=-1), 0)
    leaves = np.minimum(np.maximum(*ends).min(axis=-1), lamp)
    length = np.maximum(leaves - enters, 0)
    mean = np.zeros(length.shape)
    for k in range(steps):
        at = (enters + (k + 0.5) / steps * length)[..., None]
        mean += density(medium, points + at * toward) / steps
    return np.asarray(np.exp(-medium.extinction * mean * length))[..., None]


def march(
    camera: Camera,
    medium: Medium,
    size: tuple[int, int],
    steps: int,
    behind: npt.ArrayLike = np.inf,
    lights: Sequence[DirectionalLight | SpotLight] = (),
    ambient: npt.ArrayLike = 0.0,
    visibility: Callable[[Floats], npt.ArrayLike] = lambda points: 1.0,
    light_steps: int = 8,
) -> Slices:
    """Return slices between the near plane and a view distance.

    Parameters
    ----------
    camera : Camera
    medium : Medium
    size : (int, int)
    steps : int
        Number of slices.
    behind : array, shape (h, w)
        View distance of the opaque surface, meters.
    lights : sequence of light
    ambient : array, shape (3,)
        Radiance from all sides.
    visibility : callable
        Visibility of all lights at points (..., 3).
    light_steps : int
        Steps in which a varying density dims the lights.
    """
    direction, eye = rays(camera, size), origins(camera, size)
    with np.errstate(divide="ignore"):
        ends = [(np.asarray(corner) - eye) / direction for corner in (medium.low, medium.high)]
    enters = np.maximum(np.minimum(*ends).max(axis=-1), camera.near)
    leaves = np.minimum(np.maximum(*ends).min(axis=-1), behind)
    thickness = np.maximum(leaves - enters, 0) / steps
    begins = enters + np.arange(steps)[:, None, None] * thickness
    points = eye + (begins + jitter(size) * thickness)[..., None] * direction
    length = np.linalg.norm(direction, axis=-1)
    coverage = 1 - np.exp(-medium.extinction * density(medium, points) * length * thickness)
    light = np.broadcast_to(np.asarray(ambient, dtype=np.float64), points.shape).copy()
    toward_eye = -direction / length[..., None]
    for source in lights:
        travel, arriving = beam(source, points)
        cosine = (travel * toward_eye).sum(axis=-1)
        arriving = arriving * passing(medium, source, points, light_steps)
        scattered = arriving * phase(cosine, medium.anisotropy)[..., None]
        light += scattered * np.broadcast_to(visibility(points), points.shape)
    return Slices(begins + thickness / 2, coverage, np.asarray(medium.albedo) * light)
