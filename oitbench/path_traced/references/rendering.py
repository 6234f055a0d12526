"""Rendering a reference: the number of samples, the progress bar and the noise floor."""

from __future__ import annotations

from oitbench.fingerprints.scene import scene_fingerprint
from oitbench.image import metrics
from oitbench.path_traced import llvm
from oitbench.path_traced.references.storage import Reference, Rendering
from oitbench.path_traced.trace.path_tracer import is_random
from oitbench.path_traced.trace.render import Estimate, Progress, render
from oitbench.path_traced.trace.samples import default_samples
from oitbench.path_traced.version import TRACER
from oitbench.scene import Scene


def noise_floor(estimate: Estimate, exposure: float) -> dict[str, float | None]:
    """Return the difference between the two halves of the samples, by metric."""
    first, second = estimate.halves
    return {
        metrics.FLIP_LDR: metrics.flip_ldr(first, second, exposure),
        metrics.RMSE: metrics.rmse(first, second),
    }


def plan_rendering(
    scene: Scene,
    label: str,
    size: tuple[int, int],
    ssaa: int,
    spp: int | None = None,
    seed: int = 1,
) -> Rendering:
    """Return how a reference of a scene is rendered by this version of the suite.

    Parameters
    ----------
    scene : Scene
    label : str
        The canonical label of the scene.
    size : (int, int)
        Width and height in pixels.
    ssaa : int
        Side of the sub-pixel grid.
    spp : int, optional
        Samples for each sub-pixel. Default: `default_samples(scene)`. Scenes that need no random
        numbers always get one.
    seed : int
    """
    return Rendering(
        scene=label,
        size=size,
        ssaa=ssaa,
        spp=(spp or default_samples(scene)) if is_random(scene) else 1,
        seed=seed,
        tracer=TRACER,
        mitsuba=str(llvm.backend().mitsuba),
        fingerprint=scene_fingerprint(scene),
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
        See `trace.render.Progress`.

    Raises
    ------
    UsageError, CapabilityError, SceneError
        As `trace.render.render` does.
    """
    estimate = _render_with_bar(scene, rendering, progress)
    floor = noise_floor(estimate, scene.exposure)
    return Reference(rendering, floor, estimate.mean, estimate.variance)


def _render_with_bar(scene: Scene, rendering: Rendering, progress: Progress) -> Estimate:
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    # In a file or a pipe, the bar would end in an empty line.
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(f"path tracing {rendering.scene}", total=None)

        def advance(done: int, count: int) -> None:
            bar.update(task, completed=done, total=count)
            progress(done, count)

        return render(
            scene,
            rendering.size,
            rendering.ssaa,
            max(2, rendering.spp),
            rendering.seed,
            advance,
        )
