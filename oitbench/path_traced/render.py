"""Path tracing with a box filter, no denoiser, and rays through fixed sub-pixel positions."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from oitbench.effects import Effect
from oitbench.errors import CapabilityError, SceneError, UsageError
from oitbench.images import Image, box_downsample
from oitbench.path_traced import llvm
from oitbench.path_traced.exporter import export, export_with_textures, layout
from oitbench.path_traced.integrators import Integrator, make_straight, make_volpath, trace
from oitbench.path_traced.photons import CausticMap
from oitbench.path_traced.surfaces import Surfaces
from oitbench.path_traced.view import View
from oitbench.path_traced.walk import Walk, is_random, is_straight
from oitbench.scene import Scene

Progress = Callable[[int, int], None]
"""Called with the number of finished and of all chunks."""

_CHUNK = 1 << 17
"""Rays traced at once: some hundred bytes each, so that memory stays far below 1 GB."""


_PHOTONS = 1 << 21
"""Photons of a caustic map."""


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
    volpath: bool = False,
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
        Samples for each sub-pixel, at least two. The straight integrator takes a single one: it
        draws no random number, so all would be equal.
    seed : int
    progress : callable, optional
    variant : str, optional
        Mitsuba's variant; the fastest that works without.
    volpath : bool
        Use Mitsuba's own integrator, to check the straight one against.

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
    exported, make = _prepare(scene, view, mitsuba, volpath)
    chunks = _chunks(view)
    passes = spp if volpath or is_random(scene) else 1
    statistics = _Statistics()
    for sample in range(passes):
        integrator = make(sample)
        image = np.empty((view.width * view.height, 3), dtype=np.float32)
        for number, (first, last) in enumerate(chunks):
            state = int(np.random.SeedSequence((seed, sample, number)).generate_state(1)[0])
            image[first:last] = trace(mitsuba, integrator, exported, view.rays(first, last), state)
            if progress is not None:
                progress(sample * len(chunks) + number + 1, passes * len(chunks))
        broken = int((~np.isfinite(image)).any(axis=-1).sum())
        if broken:
            raise SceneError(f"scene {scene.name}: {broken} path-traced rays are not finite")
        statistics.add(box_downsample(image.reshape(view.height, view.width, 3), ssaa))
    return statistics.estimate()


def _prepare(
    scene: Scene, view: View, mitsuba: Any, volpath: bool
) -> tuple[Any, Callable[[int], Integrator]]:
    """Return the Mitsuba scene, and what makes an integrator for each sample."""
    if volpath or is_straight(scene):
        integrator = make_volpath(mitsuba) if volpath else make_straight(mitsuba)
        return export(scene, view, mitsuba), lambda sample: integrator
    if mitsuba.variant().startswith("scalar"):
        raise CapabilityError(
            f"scene {scene.name}: lights, media and solids are path traced with LLVM only; "
            f"{llvm.MEND}"
        )
    drjit = importlib.import_module("drjit")
    exported, textures = export_with_textures(scene, view, mitsuba)
    surfaces = Surfaces.build(mitsuba, drjit, view, exported, layout(scene), textures)
    caustics = None
    if Effect.CAUSTICS in scene.effects:
        caustics = CausticMap.build(mitsuba, drjit, exported, scene, _PHOTONS, 1)
    walk = Walk(mitsuba, scene, surfaces, caustics)
    return exported, lambda sample: walk


def _chunks(view: View) -> list[tuple[int, int]]:
    count = view.width * view.height
    return [(first, min(first + _CHUNK, count)) for first in range(0, count, _CHUNK)]


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

    def estimate(self) -> Estimate:
        count = self._count
        mean = self._mean.astype(np.float32)
        if count == 1:
            return Estimate(mean, np.zeros_like(mean), (mean, mean), 1)
        first, second = (
            (total / number).astype(np.float32)
            for total, number in zip(self._sums, ((count + 1) // 2, count // 2), strict=True)
        )
        variance = self._squares / (count - 1) / count
        return Estimate(mean, variance.astype(np.float32), (first, second), count)
