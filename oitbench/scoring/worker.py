"""The far end of a process that scores stored images."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

import numpy as np
from msgspec import Struct

from oitbench.errors import DeclarationError, UsageError
from oitbench.image import files, metrics, stored
from oitbench.image.files import Image
from oitbench.image.stored import StoredImage
from oitbench.results.custom import CustomMetric
from oitbench.scoring.metric import Metric, load_metric
from oitbench.workers.messages import Step
from oitbench.workers.serve import OnStep, serve

_LOADING = Step("loading the file")
_KEPT = 4
"""Images that stay in memory: truths are shared by the methods of a scene."""


class Settings(Struct, frozen=True):
    """There are none."""


class LoadMetric(Struct, frozen=True, tag=True):
    """Asks for the facts of the metric in a file."""

    path: Path


class Measure(Struct, frozen=True, tag=True):
    """Asks for a user's metric of two images; `digest` is that of the file that was loaded."""

    path: Path
    digest: str
    reference: Path
    test: Path
    exposure: float


class MeasureBuiltIn(Struct, frozen=True, tag=True):
    """Asks for the suite's metrics, and for their maps as a file `stem` below `folder`."""

    reference: Path
    test: Path
    exposure: float
    folder: Path
    stem: str


class MetricLoaded(Struct, frozen=True, tag=True):
    """The name of a metric, and what a record holds of it."""

    name: str
    facts: CustomMetric


class Measured(Struct, frozen=True, tag=True):
    """A value, null if it is not finite or if the metric failed; `fault` says why it failed."""

    value: float | None = None
    fault: str = ""


class BuiltInMeasured(Struct, frozen=True, tag=True):
    """The suite's metrics, and their maps; there are none if a pixel is not finite."""

    values: dict[str, float | None]
    maps: StoredImage | None


Request = LoadMetric | Measure | MeasureBuiltIn
Reply = MetricLoaded | Measured | BuiltInMeasured


def _begin(settings: Settings, on_step: OnStep) -> Callable[[Request], Reply]:
    loaded: dict[Path, Metric] = {}
    read = lru_cache(_KEPT)(files.read_exr)

    def find(path: Path) -> Metric:
        if path not in loaded:
            on_step(_LOADING)
            loaded[path] = load_metric(path)
        return loaded[path]

    def answer(request: Request) -> Reply:
        if isinstance(request, LoadMetric):
            metric = find(request.path)
            return MetricLoaded(metric.name, metric.facts)
        pair = read(request.reference), read(request.test)
        if isinstance(request, MeasureBuiltIn):
            return _measure_built_in(request, *pair)
        metric = find(request.path)
        if metric.facts.digest != request.digest:
            raise UsageError(f"{request.path} changed while it was used; score again")
        on_step(Step(f"measuring {metric.name}"))
        return _measure(metric, *pair, request.exposure)

    return answer


def _measure(metric: Metric, reference: Image, test: Image, exposure: float) -> Measured:
    if reference.shape != test.shape or not all(np.isfinite(i).all() for i in (reference, test)):
        return Measured()
    try:
        # A metric that writes to its images must not change those of the next one.
        return Measured(metric.value(reference.copy(), test.copy(), exposure))
    except DeclarationError as error:
        return Measured(fault=str(error))


def _measure_built_in(request: MeasureBuiltIn, reference: Image, test: Image) -> BuiltInMeasured:
    found = metrics.compare(reference, test, request.exposure)
    if not found.maps:
        return BuiltInMeasured(found.values, None)
    channels = files.flip_channels(found.maps[metrics.FLIP_LDR], found.maps[metrics.FLIP_HDR])
    return BuiltInMeasured(found.values, stored.store(request.folder, request.stem, channels))


def main() -> None:
    """Serve the process that started this one."""
    serve(Settings, Request, _begin)
