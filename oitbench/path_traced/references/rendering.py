"""Rendering a reference: the number of samples, the progress bar and the noise floor."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import TypeVar

from oitbench.effects import Effect, effects_of, names
from oitbench.fingerprints.scene import scene_fingerprint
from oitbench.image import metrics, ties
from oitbench.image.files import Image
from oitbench.path_traced import llvm
from oitbench.path_traced.matched.render import is_random as matched_is_random
from oitbench.path_traced.matched.render import matched
from oitbench.path_traced.references.storage import Reference, Rendering
from oitbench.path_traced.references.wanted import Wanted
from oitbench.path_traced.trace.path_tracer import is_random
from oitbench.path_traced.trace.render import Estimate, Progress, render
from oitbench.path_traced.trace.samples import default_samples
from oitbench.path_traced.version import TRACER
from oitbench.scene import Scene
from oitbench.truths import MATCHED
from oitbench.views import seen

_Result = TypeVar("_Result")

MATCHED_RAYS = {
    Effect.VOLUME: 8,
    Effect.AMBIENT_OCCLUSION: 16,
    Effect.DIFFUSION: 16,
    Effect.CAUSTICS: 4,
}
"""Rays for each pixel in each part of a matched reference, by the random effects that run: enough
for noise floors of FLIP of 0.005 with fog, and 0.01 with the others."""


def matched_spp(effects: Effect, grid: int) -> int:
    """Return how many samples each sub-pixel of a part of a matched reference gets by default.

    Parameters
    ----------
    effects : Effect
        Effects that run.
    grid : int
        Side of the sub-pixel grid.
    """
    rays = max((count for effect, count in MATCHED_RAYS.items() if effect in effects), default=1)
    return math.ceil(rays / grid**2)


def noise_floor(parts: tuple[Image, ...], exposure: float) -> dict[str, float | None]:
    """Return the error that the noise of a reference causes, by metric.

    Parameters
    ----------
    parts : tuple of array, shape (h, w, 3)
        Independent means of equally many samples.
    exposure : float
        Of the scene.
    """

    def ldr(image: Image, truth: Image) -> float:
        return metrics.flip_ldr(truth, image, exposure) or 0.0

    def hdr(image: Image, truth: Image) -> float:
        return metrics.flip_hdr(truth, image, exposure) or 0.0

    def rmse(image: Image, truth: Image) -> float:
        return metrics.rmse(truth, image) or 0.0

    measures = {metrics.FLIP_LDR: ldr, metrics.FLIP_HDR: hdr, metrics.RMSE: rmse}
    return {name: ties.noise_floor(parts, metric) for name, metric in measures.items()}


def plan_rendering(wanted: Wanted, spp: int | None = None, seed: int = 1) -> Rendering:
    """Return how a reference is rendered by this version of the suite.

    Parameters
    ----------
    wanted : Wanted
    spp : int, optional
        Samples for each sub-pixel, of each part. Default: `matched_spp` or `default_samples`.
        Pictures that need no random numbers always get one.
    seed : int
    """
    scene, effects, grid = wanted.scene, wanted.effects, wanted.grid
    is_matched = wanted.truth == MATCHED
    random = matched_is_random(scene, effects) if is_matched else is_random(scene)
    default = matched_spp(effects, grid) if is_matched else default_samples(scene)
    return Rendering(
        scene=wanted.label,
        truth="matched" if is_matched else "full",
        effects=names(effects),
        left_out=wanted.left_out,
        size=wanted.size,
        ssaa=grid,
        spp=(spp or default) if random else 1,
        parts=ties.PARTS if is_matched and random else 1,
        seed=seed,
        tracer=TRACER,
        mitsuba=str(llvm.backend().mitsuba),
        fingerprint=scene_fingerprint(scene),
        view=wanted.view,
        jitter=wanted.jittered,
    )


def render_reference(
    scene: Scene, rendering: Rendering, progress: Progress = lambda done, count: None
) -> Reference:
    """Render a reference, with a progress bar on standard error.

    Parameters
    ----------
    scene : Scene
    rendering : Rendering
    progress : callable
        See `trace.render.Progress`; of a matched reference, it counts parts.

    Raises
    ------
    UsageError, CapabilityError, SceneError
        As `trace.render.render` does.
    """
    start = time.perf_counter()
    label = f"tracing {seen(rendering.scene, rendering.view)} ({rendering.truth})"
    if rendering.truth == MATCHED:
        parts = _with_bar(label, lambda show: _render_parts(scene, rendering, show), progress)
        floor = noise_floor(parts, scene.exposure)
        return Reference(rendering, floor, time.perf_counter() - start, parts)
    estimate = _with_bar(label, lambda show: _render_full(scene, rendering, show), progress)
    floor = noise_floor(estimate.halves, scene.exposure)
    seconds = time.perf_counter() - start
    return Reference(rendering, floor, seconds, (estimate.mean,), estimate.variance)


def render_part(scene: Scene, rendering: Rendering, number: int) -> Image:
    """Return a part of a matched reference, the same in every call."""
    return matched(
        scene,
        rendering.size,
        rendering.ssaa,
        effects_of(rendering.effects),
        samples=rendering.spp,
        part=rendering.seed * ties.PARTS + number,
        jitter=rendering.jitter,
    )


def _render_parts(scene: Scene, rendering: Rendering, progress: Progress) -> tuple[Image, ...]:
    parts = []
    for number in range(rendering.parts):
        parts.append(render_part(scene, rendering, number))
        progress(number + 1, rendering.parts)
    return tuple(parts)


def _render_full(scene: Scene, rendering: Rendering, progress: Progress) -> Estimate:
    spp = max(2, rendering.spp)
    return render(scene, rendering.size, rendering.ssaa, spp, rendering.seed, progress)


def _with_bar(label: str, work: Callable[[Progress], _Result], progress: Progress) -> _Result:
    """Return what `work` returns, and show its progress on standard error."""
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    # In a file or a pipe, the bar would end in an empty line.
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(label, total=None)

        def advance(done: int, count: int) -> None:
            bar.update(task, completed=done, total=count)
            progress(done, count)

        return work(advance)
