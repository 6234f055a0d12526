"""Path-traced images: rays through fixed sub-pixel positions, a box filter and no denoiser."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
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
from oitbench.path_traced.trace.sections import SECTIONS, Estimate, Section, estimate
from oitbench.path_traced.trace.sequence import Turn, seed_of
from oitbench.scene import Scene

Progress = Callable[[int, int], None]
"""Called with the number of finished samples and the number of all samples."""

_CHUNK = 1 << 18
"""Rays that are traced at once. Each needs some hundred bytes, so memory stays far below 1 GB."""
_MAPS = 16
"""Caustic maps over which an image is averaged, if it has that many samples."""


@dataclass(frozen=True)
class Tracing:
    """The settings of an image; see `render`."""

    size: tuple[int, int]
    ssaa: int
    spp: int
    seed: int

    def __post_init__(self) -> None:
        if min(self.size) < 1:
            width, height = self.size
            raise UsageError(f"size {width}x{height} is empty; both sides must be at least 1")
        if self.ssaa < 1:
            raise UsageError(f"ssaa is {self.ssaa}; it must be at least 1")
        if self.spp < 2:
            raise UsageError(f"spp is {self.spp}; the noise floor needs at least 2 samples")

    def samples(self, scene: Scene) -> int:
        """Return the number of samples for each sub-pixel."""
        return self.spp if is_random(scene) else 1

    def shared(self, scene: Scene) -> int:
        """Return how many samples share a caustic map; they form a group."""
        return -(-self.samples(scene) // _MAPS) if Effect.CAUSTICS in scene.effects else 1

    def sections(self, scene: Scene) -> int:
        """Return the number of sections of the image."""
        return min(SECTIONS, self._groups(scene))

    def groups(self, scene: Scene, number: int) -> range:
        """Return the numbers of the groups of a section."""
        count, sections = self._groups(scene), self.sections(scene)
        return range(count * number // sections, count * (number + 1) // sections)

    def _groups(self, scene: Scene) -> int:
        return -(-self.samples(scene) // self.shared(scene))


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
    tracer = Tracer(scene, Tracing(size, ssaa, spp, seed), variant)
    count = tracer.tracing.sections(scene)
    return estimate([tracer.section(number, progress) for number in range(count)])


class Tracer:
    """A scene that is ready to be traced.

    Parameters
    ----------
    scene, variant
        See `render`.
    tracing : Tracing
    """

    def __init__(self, scene: Scene, tracing: Tracing, variant: str | None = None) -> None:
        self.tracing = tracing
        self._scene = scene.resolved(tracing.size[1] * tracing.ssaa).near_origin()
        self._mitsuba = llvm.load(variant)
        width, height = (side * tracing.ssaa for side in tracing.size)
        self._view = View(self._scene.camera, width, height)
        self._content, self._make = prepare(self._scene, self._view, self._mitsuba, tracing.seed)

    def section(self, number: int, progress: Progress | None = None) -> Section:
        """Return a section of the image, which needs nothing of the others.

        Parameters
        ----------
        number : int
        progress : callable, optional
            See `render`.

        Raises
        ------
        SceneError
            If the radiance of a ray is not finite.
        """
        tracing, ssaa, seed = self.tracing, self.tracing.ssaa, self.tracing.seed
        section, shared = Section.empty(tracing.size), tracing.shared(self._scene)
        samples = tracing.samples(self._scene)
        for group in tracing.groups(self._scene, number):
            first, half = group * shared, group % 2
            integrator = self._make(first)
            total: Any = 0.0
            last = min(first + shared, samples)
            for taken, sample in enumerate(range(first, last), start=group // 2 * shared):
                turn = Turn(0, seed_of(seed, half), taken, 0, self._view.width, ssaa)
                image = self._sample(integrator, (seed, sample), turn)
                require_finite_rays(self._scene, image)
                total = total + box_downsample(image, ssaa)
                if progress is not None:
                    progress(sample + 1, samples)
            section.add(total / (last - first), half, last - first)
        return section

    def _sample(self, integrator: Integrator, key: tuple[int, int], turn: Turn) -> Image:
        """Return one sample of each sub-pixel, shape (h, w, 3).

        `key` holds the seed and the number of the sample.
        """
        view = self._view
        count = view.width * view.height
        image = np.empty((count, 3), dtype=np.float32)
        for number, first in enumerate(range(0, count, _CHUNK)):
            last = min(first + _CHUNK, count)
            turn = replace(turn, seed=seed_of(*key, number), first=first)
            rays = view.rays(first, last)
            image[first:last] = trace(self._mitsuba, integrator, self._content, rays, turn)
        return image.reshape(view.height, view.width, 3)
