"""Rendering a reference: the number of samples, and the progress bar."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import TypeVar

from oitbench.effects import Effect, names
from oitbench.fingerprints.scene import scene_fingerprint
from oitbench.image import ties
from oitbench.path_traced import llvm
from oitbench.path_traced.matched.render import is_random as matched_is_random
from oitbench.path_traced.references.pieces import Piece, Pieces, assemble
from oitbench.path_traced.references.storage import Reference, Rendering
from oitbench.path_traced.references.wanted import Wanted
from oitbench.path_traced.trace.path_tracer import is_random
from oitbench.path_traced.trace.render import Progress
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
        See `Pieces.render`.

    Raises
    ------
    UsageError, CapabilityError, SceneError
        As `trace.render.render` does.
    """
    start, pieces = time.perf_counter(), Pieces(scene, rendering)
    label = f"tracing {seen(rendering.scene, rendering.view)} ({rendering.truth})"

    def work(show: Progress) -> list[Piece]:
        return [pieces.render(number, show) for number in range(pieces.count)]

    found = _with_bar(label, work, progress)
    return assemble(rendering, found, scene.exposure, time.perf_counter() - start)


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
