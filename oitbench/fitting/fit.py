"""Fitting a method to scenes, in a process of its own."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from oitbench.catalog.catalog import Catalog
from oitbench.errors import DeclarationError, UsageError
from oitbench.fitting.worker import FitMethod, Fitted
from oitbench.parameters import parse
from oitbench.workers import memory
from oitbench.workers.messages import Step
from oitbench.workers.process import Process

STEP_SECONDS = 600.0
"""Seconds that the views of a scene, or one evaluation, may take."""
_LOADING = Step("loading the files")


def fit(
    method: str,
    scenes: Sequence[str],
    size: tuple[int, int] = (128, 128),
    views: int = 6,
    degrees: float = 10.0,
    evaluations: int = 120,
    collections: Iterable[Path | str] = (),
    timeout: float | None = STEP_SECONDS,
    memory_gib: float | None = None,
) -> Fitted:
    """Minimize the mean squared error of a method against exact compositing.

    All decimal parameters with two bounds that `method` does not set are fitted. Pictures are
    compared as they are displayed, and all scenes count alike.

    Parameters
    ----------
    method : str
        `NAME[param=v]`, or a method's folder.
    scenes : sequence of str
        `NAME[param=v,w]`.
    size : (int, int)
        Width and height of a view in pixels.
    views : int
        Views of each scene, two or more: half of them for training, the others held out.
    degrees : float
        Angle between neighboring views, on a circle about the target of the scene's camera.
    evaluations : int
        Largest number of sets of parameters that are rendered.
    collections : iterable of path
        Further collection folders.
    timeout : float, optional
        Seconds for the views of each scene, and for each evaluation. None: no limit.
    memory_gib : float, optional
        Memory that the process may use, in GiB. Default: 75 % of the machine's.

    Raises
    ------
    OitbenchError
        Something is unknown, out of range, or not available on this machine, the process ended,
        or there is nothing to fit.
    """
    limit = memory.limit(memory_gib, 1)
    with Catalog(collections) as catalog:
        methods, found = catalog.expand_methods([method]), catalog.expand_scenes(scenes)
        for choice in (*methods, *found):
            if choice.error:
                raise DeclarationError(choice.error)
        if len(methods) != 1:
            raise UsageError(f"'{method}' selects {len(methods)} methods; name one")
        (chosen,) = methods
        files = catalog.places.files([chosen.name])
    request = FitMethod(
        chosen.label,
        sorted(parse(method).grid),
        [choice.label for choice in found],
        size,
        views,
        degrees,
        evaluations,
    )
    with Process("oitbench.fitting.worker", files, Fitted, limit) as worker:
        fitted: Fitted = worker.ask(request, Fitted, timeout, _LOADING)
    return fitted
