"""Visibility curves at one pixel, measured in a process of its own."""

from __future__ import annotations

import pickle
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path

from oitbench.catalog.catalog import Catalog
from oitbench.errors import DeclarationError, UsageError
from oitbench.measure.visibility import STEP_SECONDS, Curves
from oitbench.measure.worker import MeasurePixel, PixelMeasured
from oitbench.workers import memory
from oitbench.workers.messages import Step
from oitbench.workers.process import Process

_LOADING = Step("loading the files")


def measure(
    scene: str,
    pixel: tuple[int, int],
    methods: Sequence[str] = (),
    size: tuple[int, int] = (512, 512),
    collections: Iterable[Path | str] = (),
    timeout: float | None = STEP_SECONDS,
    memory_gib: float | None = None,
) -> Curves:
    """Measure the visibility curves of methods at one pixel of a scene.

    Parameters
    ----------
    scene : str
        `NAME[param=v]`.
    pixel : (int, int)
        Column from the left, row from the top.
    methods : sequence of str
        `NAME[param=v,w]`. Default: all methods, with their defaults.
    size : (int, int)
        Width and height of the frame in pixels.
    collections : iterable of path
        Further collection folders.
    timeout : float, optional
        Seconds for building the scene, and for each method. None: no limit.
    memory_gib : float, optional
        Memory that the process may use, in GiB. Default: 75 % of the machine's.

    Raises
    ------
    OitbenchError
        Something is unknown, out of range, or not available on this machine, the process ended,
        or nothing transparent is at the pixel.
    """
    limit = memory.limit(memory_gib, 1)
    with Catalog(collections) as catalog:
        chosen = catalog.expand_methods(methods or catalog.names("method"))
        scenes = catalog.expand_scenes([scene])
        for choice in (*scenes, *chosen):
            if choice.error:
                raise DeclarationError(choice.error)
        if len(scenes) != 1:
            raise UsageError(f"'{scene}' selects {len(scenes)} scenes; name one")
        files = catalog.places.files(item.name for item in chosen)
    with (
        tempfile.TemporaryDirectory(prefix="oitbench-") as folder,
        Process("oitbench.measure.worker", files, PixelMeasured, limit) as worker,
    ):
        file = Path(folder) / "curves.pickle"
        labels = [choice.label for choice in chosen]
        request = MeasurePixel(scenes[0].label, pixel, size, labels, file)
        worker.ask(request, PixelMeasured, timeout, _LOADING)
        curves: Curves = pickle.loads(file.read_bytes())
    return curves
