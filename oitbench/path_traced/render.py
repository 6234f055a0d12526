"""Rendering with Mitsuba's `volpath`: box filter, no denoiser, fixed sub-pixel positions."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np

from oitbench.errors import SceneError, UsageError
from oitbench.images import Image, box_downsample
from oitbench.path_traced import llvm
from oitbench.path_traced.exporter import export
from oitbench.path_traced.view import View
from oitbench.scene import Scene

Progress = Callable[[int, int], None]
"""Called with the number of finished and of all chunks."""

_CHUNK = 1 << 17
"""Rays traced at once: some hundred bytes each, so that memory stays far below 1 GB."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """A path-traced image.

    Parameters
    ----------
    mean : array, shape (h, w, 3), float32
        Linear Rec.709 radiance, top row first.
    variance : array, shape (h, w, 3), float32
        Variance of that mean.
    halves : pair of array, shape (h, w, 3), float32
        Means of the even and the odd samples; how they differ is the noise floor.
    """

    mean: Image
    variance: Image
    halves: tuple[Image, Image]


def render(
    scene: Scene,
    size: tuple[int, int],
    ssaa: int = 2,
    spp: int = 2,
    seed: int = 1,
    progress: Progress | None = None,
    variant: str | None = None,
) -> Estimate:
    """Path-trace `scene`.

    Parameters
    ----------
    scene : Scene
    size : (int, int)
        Width and height in pixels.
    ssaa : int
        Rays go through the centers of ssaa × ssaa sub-pixels of each pixel, where GL samples too.
    spp : int
        Samples for each sub-pixel, at least two.
    seed : int
    progress : callable, optional
    variant : str, optional
        Mitsuba's variant; the fastest that works without.

    Returns
    -------
    Estimate

    Raises
    ------
    UsageError
        For a size, `ssaa` or `spp` that is too small.
    CapabilityError
        If the scene has what this version cannot trace, or Mitsuba is not installed.
    SceneError
        If the radiance of a ray is not finite.
    """
    _check(size, ssaa, spp)
    mitsuba = llvm.load(variant)
    view = View(scene.camera, size[0] * ssaa, size[1] * ssaa)
    tracer = _Tracer(mitsuba, export(scene, view, mitsuba), view)
    statistics = _Statistics(spp)
    chunks = tracer.chunks()
    for sample in range(spp):
        image = np.empty((view.width * view.height, 3), dtype=np.float32)
        for number, (first, last) in enumerate(chunks):
            image[first:last] = tracer.trace(first, last, (seed, sample, number))
            if progress is not None:
                progress(sample * len(chunks) + number + 1, spp * len(chunks))
        broken = int((~np.isfinite(image)).any(axis=-1).sum())
        if broken:
            raise SceneError(f"scene {scene.name}: {broken} path-traced rays are not finite")
        statistics.add(box_downsample(image.reshape(view.height, view.width, 3), ssaa))
    return statistics.estimate()


def _check(size: tuple[int, int], ssaa: int, spp: int) -> None:
    if min(size) < 1:
        raise UsageError(f"size {size[0]}x{size[1]} is empty; both sides must be at least 1")
    if ssaa < 1:
        raise UsageError(f"ssaa is {ssaa}; it must be at least 1")
    if spp < 2:
        raise UsageError(f"spp is {spp}; the noise floor needs at least 2 samples")


@dataclass(frozen=True)
class _Tracer:
    mitsuba: ModuleType
    scene: Any
    view: View

    def chunks(self) -> list[tuple[int, int]]:
        count = self.view.width * self.view.height
        return [(first, min(first + _CHUNK, count)) for first in range(0, count, _CHUNK)]

    def trace(self, first: int, last: int, seed: tuple[int, int, int]) -> Image:
        """Return the radiance along the rays `first` … `last` − 1, shape (n, 3)."""
        mitsuba = self.mitsuba
        # Films count as no bounce, so neither the depth nor Russian roulette limits their number.
        integrator = mitsuba.load_dict({"type": "volpath", "max_depth": -1, "rr_depth": 1 << 20})
        sampler = mitsuba.load_dict({"type": "independent"})
        state = int(np.random.SeedSequence(seed).generate_state(1)[0])
        origins, directions = self.view.rays(first, last)
        if mitsuba.variant().startswith("scalar"):
            sampler.seed(state)
            rays = self._single_rays(origins, directions)
            radiance = [integrator.sample(self.scene, sampler, ray)[0] for ray in rays]
            return np.asarray([list(color) for color in radiance], dtype=np.float32)
        sampler.seed(state, last - first)
        ray = mitsuba.Ray3f(
            mitsuba.Point3f(*origins.T.astype(np.float32)),
            mitsuba.Vector3f(*directions.T.astype(np.float32)),
        )
        color, _, _ = integrator.sample(self.scene, sampler, mitsuba.RayDifferential3f(ray))
        return np.array(color, dtype=np.float32).T

    def _single_rays(self, origins: Any, directions: Any) -> Iterator[Any]:
        mitsuba = self.mitsuba
        for origin, direction in zip(origins.tolist(), directions.tolist(), strict=True):
            yield mitsuba.RayDifferential3f(mitsuba.Ray3f(origin, direction))


class _Statistics:
    """Running mean and variance over samples, and the means of both halves (Welford 1962)."""

    def __init__(self, spp: int) -> None:
        self._spp = spp
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

    def estimate(self) -> Estimate:
        count = self._count
        first, second = (
            (total / number).astype(np.float32)
            for total, number in zip(self._sums, ((count + 1) // 2, count // 2), strict=True)
        )
        variance = self._squares / (count - 1) / count
        return Estimate(self._mean.astype(np.float32), variance.astype(np.float32), (first, second))
