"""Ray-marched fog in double precision: the slices of each pixel's ray, as layers to composite.

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

Words = npt.NDArray[np.uint64]
_MASK = np.uint64(0xFFFFFFFF)


@dataclass(frozen=True, eq=False)
class Slices:
    """Layers that stand for a medium: z and coverage (n, h, w), radiance (n, h, w, 3)."""

    z: Floats
    coverage: Floats
    radiance: Floats

    def lists(self) -> FragmentLists:
        """Return the same layers as fragments that a scene gives outright."""
        single = self.radiance.astype(np.float32)
        return FragmentLists(
            self.z.astype(np.float32),
            self.coverage.astype(np.float32),
            single,
            np.zeros_like(single),
        )


def phase(cosine: npt.ArrayLike, g: float) -> Floats:
    """Return Henyey & Greenstein's p, 1/sr."""
    base = 1 + g * g - 2 * g * np.asarray(cosine, dtype=np.float64)
    return np.asarray((1 - g * g) / (4 * np.pi * base**1.5))


def pcg3d(x: Words, y: Words, z: Words) -> Words:
    """Return the first word of the hash of three (Jarzynski & Olano 2020)."""
    v = [(a * np.uint64(1664525) + np.uint64(1013904223)) & _MASK for a in (x, y, z)]
    for last in (False, True):
        for i in range(3):
            v[i] = (v[i] + v[(i + 1) % 3] * v[(i + 2) % 3]) & _MASK
        if not last:
            v = [a ^ (a >> np.uint64(16)) for a in v]
    return v[0]


def jitter(size: tuple[int, int]) -> Floats:
    """Return the part of a slice at which each pixel samples."""
    width, height = size
    x, y = np.meshgrid(np.arange(width, dtype=np.uint64), np.arange(height, dtype=np.uint64)[::-1])
    bayer = np.array([[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]])
    four = np.uint64(4)
    drawn = (pcg3d(x // four, y // four, np.zeros_like(x)) >> np.uint64(8)) / 2.0**24
    return np.asarray((bayer[y % four, x % four] / 16 + drawn) % 1)


def rays(camera: Camera, size: tuple[int, int]) -> Floats:
    """Return world directions through pixel centers, one meter of view distance long, (h, w, 3)."""
    width, height = size
    pixel = 2 * np.tan(camera.fov_y / 2) / height
    x = (np.arange(width) + 0.5 - width / 2) * pixel
    y = (height / 2 - np.arange(height) - 0.5) * pixel
    ahead = np.stack([*np.meshgrid(x, y), -np.ones((height, width))], axis=-1)
    return np.asarray(ahead @ camera.axes)


def density(medium: Medium, points: Floats) -> Floats:
    """Return the density at points (..., 3): linear between cells, the outermost repeated."""
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
    """Return the direction of travel and the irradiance at points (..., 3), without shadows."""
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


def march(
    camera: Camera,
    medium: Medium,
    size: tuple[int, int],
    steps: int,
    behind: npt.ArrayLike = np.inf,
    lights: Sequence[DirectionalLight | SpotLight] = (),
    ambient: npt.ArrayLike = 0.0,
    visibility: Callable[[Floats], npt.ArrayLike] = lambda points: 1.0,
) -> Slices:
    """Return `steps` slices between the near plane and the view distance `behind`, m.

    `ambient` is the mean radiance around; `visibility` is that of all lights at points (..., 3).
    """
    direction, eye = rays(camera, size), np.asarray(camera.position, dtype=np.float64)
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
        scattered = arriving * phase(cosine, medium.anisotropy)[..., None]
        light += scattered * np.broadcast_to(visibility(points), points.shape)
    return Slices(begins + thickness / 2, coverage, np.asarray(medium.albedo) * light)
