"""Path-traced images: rays through fixed sub-pixel positions, a box filter and no denoiser."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from types import ModuleType
from typing import Any

import numpy as np

from oitbench.effects import Effect
from oitbench.errors import UsageError
from oitbench.image.files import Image, box_downsample
from oitbench.path_traced import llvm
from oitbench.path_traced.export.view import View
from oitbench.path_traced.trace.integrators import (
    Integrator,
    prepare,
    require_finite_rays,
    trace,
)
from oitbench.path_traced.trace.path_tracer import is_random
from oitbench.path_traced.trace.sequence import Turn, seed_of
from oitbench.scene import Scene

Progress = Callable[[int, int], None]
"""Called with the number of finished samples and the number of all samples."""

_CHUNK = 1 << 18
"""Rays that are traced at once. Each needs some hundred bytes, so memory stays far below 1 GB."""
_MAPS = 16
"""Caustic maps over which an image is averaged, if it has that many samples."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """A path-traced image.

    Parameters
    ----------
    mean : array, shape (h, w, 3), float32
        Linear Rec.709 radiance, top row first.
    variance : array, shape (h, w, 3), float32
        Variance of that mean, or more: samples of one half are spread evenly (see `sequence`), so
        that their mean varies less than that of independent ones.
    halves : pair of array, shape (h, w, 3), float32
        Means of the even and of the odd samples; with caustics, of the samples of the even and of
        the odd caustic maps. They are independent.
    spp : int
        Samples that were taken for each sub-pixel.
    """

    mean: Image
    variance: Image
    halves: tuple[Image, Image]
    spp: int


def render(
    scene: Scene,
    size: tuple[int, int],
    ssaa: int = 2,
    spp: int = 2,
    seed: int = 1,
    progress: Progress | None = None,
    variant: str | None = None,
) -> Estimate:
    """Path-trace a scene.

    Parameters
    ----------
    scene : Scene
    size : (int, int)
        Width and height in pixels.
    ssaa : int
        Side of the sub-pixel grid. Rays pass through the centers of ssaa × ssaa sub-pixels of each
        pixel, where OpenGL samples, too.
    spp : int
        Samples for each sub-pixel, at least 2. Scenes that need no random numbers get a single
        sample, because all samples would be equal.
    seed : int
    progress : callable, optional
        See `Progress`.
    variant : str, optional
        Mitsuba's variant. Default: the fastest that works.

    Returns
    -------
    Estimate

    Raises
    ------
    UsageError
        If a side, `ssaa` or `spp` is too small.
    CapabilityError
        If the scene cannot be path traced, or Mitsuba is not installed.
    SceneError
        If the radiance of a ray is not finite.
    """
    _check(size, ssaa, spp)
    scene = scene.resolved(size[1] * ssaa).near_origin()
    mitsuba = llvm.load(variant)
    view = View(scene.camera, size[0] * ssaa, size[1] * ssaa)
    content, make = prepare(scene, view, mitsuba, seed)
    samples = spp if is_random(scene) else 1
    shared = -(-samples // _MAPS) if Effect.CAUSTICS in scene.effects else 1
    statistics, taken = _Statistics(), [0, 0]
    for group, first in enumerate(range(0, samples, shared)):
        integrator, half = make(first), group % 2
        total: Any = 0.0
        last = min(first + shared, samples)
        for sample in range(first, last):
            turn = Turn(0, seed_of(seed, half), taken[half], 0, view.width, ssaa)
            image = _sample(mitsuba, integrator, content, view, (seed, sample), turn)
            taken[half] += 1
            require_finite_rays(scene, image)
            total = total + box_downsample(image, ssaa)
            if progress is not None:
                progress(sample + 1, samples)
        statistics.add(total / (last - first))
    return statistics.estimate(samples)


def _sample(
    mitsuba: ModuleType,
    integrator: Integrator,
    content: Any,
    view: View,
    key: tuple[int, int],
    turn: Turn,
) -> Image:
    """Return one sample of each sub-pixel, shape (h, w, 3).

    `key` holds the seed and the number of the sample.
    """
    count = view.width * view.height
    image = np.empty((count, 3), dtype=np.float32)
    for number, first in enumerate(range(0, count, _CHUNK)):
        last = min(first + _CHUNK, count)
        turn = replace(turn, seed=seed_of(*key, number), first=first)
        rays = view.rays(first, last)
        image[first:last] = trace(mitsuba, integrator, content, rays, turn)
    return image.reshape(view.height, view.width, 3)


def _check(size: tuple[int, int], ssaa: int, spp: int) -> None:
    if min(size) < 1:
        raise UsageError(f"size {size[0]}x{size[1]} is empty; both sides must be at least 1")
    if ssaa < 1:
        raise UsageError(f"ssaa is {ssaa}; it must be at least 1")
    if spp < 2:
        raise UsageError(f"spp is {spp}; the noise floor needs at least 2 samples")


class _Statistics:
    """Running mean and variance over samples, and the means of both halves (Welford 1962)."""

    def __init__(self) -> None:
        self._count = 0
        self._mean: Any = 0.0
        self._squares: Any = 0.0
        self._sums: list[Any] = [0.0, 0.0]

    def add(self, sample: Image) -> None:
        value = sample.astype(np.float64)
        self._sums[self._count % 2] = self._sums[self._count % 2] + value
        self._count += 1
        offset = value - self._mean
        self._mean = self._mean + offset / self._count
        self._squares = self._squares + offset * (value - self._mean)

    def estimate(self, spp: int) -> Estimate:
        count = self._count
        mean = self._mean.astype(np.float32)
        if count == 1:
            return Estimate(mean, np.zeros_like(mean), (mean, mean), spp)
        first, second = (
            (total / number).astype(np.float32)
            for total, number in zip(self._sums, ((count + 1) // 2, count // 2), strict=True)
        )
        variance = self._squares / (count - 1) / count
        return Estimate(mean, variance.astype(np.float32), (first, second), spp)
