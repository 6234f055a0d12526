"""The far end of a process that fits the parameters of a method."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import ExitStack

import numpy as np
from msgspec import Struct

from oitbench.errors import SceneError
from oitbench.fitting.search import free_axes, minimize
from oitbench.fitting.views import Views, seen_from
from oitbench.gl.device import Device
from oitbench.method.declaration import Method
from oitbench.places import PluginFiles
from oitbench.plugins import Collection
from oitbench.workers.messages import Step
from oitbench.workers.serve import OnStep, serve


class FitMethod(Struct, frozen=True, tag=True):
    """Asks for the best values of all decimal parameters that are not `fixed`; labels select."""

    method: str
    fixed: list[str]
    scenes: list[str]
    size: tuple[int, int]
    views: int
    degrees: float
    evaluations: int


class SceneErrors(Struct, frozen=True):
    """Mean squared errors in one scene, with the parameters at the start and with the best."""

    scene: str
    training: tuple[float, float]
    held_out: tuple[float, float]


class Fitted(Struct, frozen=True, tag=True):
    """The label of the method with the best parameters, and its errors in each scene."""

    label: str
    evaluations: int
    errors: list[SceneErrors]


def _begin(files: PluginFiles, on_step: OnStep) -> Callable[[FitMethod], Fitted]:
    collection = Collection(files.places())

    def answer(request: FitMethod) -> Fitted:
        with Device() as device, ExitStack() as stack:
            views = {}
            for label in request.scenes:
                on_step(Step(f"drawing the views of {label}"))
                views[label] = stack.enter_context(_views(device, collection, request, label))
            return fit(collection, request, views, on_step)

    return answer


def _views(device: Device, collection: Collection, request: FitMethod, label: str) -> Views:
    scenes = seen_from(collection.build_scene(label), request.views, request.degrees)
    return Views(device, scenes, collection.truth(), request.size)


def fit(
    collection: Collection, request: FitMethod, views: Mapping[str, Views], on_step: OnStep
) -> Fitted:
    """Search for the smallest mean error over all scenes, and measure it.

    Raises
    ------
    SceneError
        The method is exact in all views, for example because none shows anything transparent.
    """
    (start,) = collection.expand_methods([request.method])
    axes = free_axes(start.name, start.parameters, request.fixed)
    on_step(Step("measuring the errors at the start"))
    before = {label: (item.training(start), item.held_out(start)) for label, item in views.items()}
    if not any(training for training, _ in before.values()):
        raise SceneError(f"{start.label} is exact in all views; name scenes in which it has errors")
    count = 0

    def changed(values: Mapping[str, float]) -> Method:
        return type(start)(**{**start.values, **values})

    def error(values: Mapping[str, float]) -> float:
        nonlocal count
        count += 1
        on_step(Step(f"evaluation {count}"))
        method = changed(values)
        return float(np.mean([item.training(method) for item in views.values()]))

    best = changed(minimize(axes, start.values, error, request.evaluations))
    on_step(Step("measuring the errors of the best"))
    errors = []
    for label, item in views.items():
        training, held_out = before[label]
        errors.append(
            SceneErrors(label, (training, item.training(best)), (held_out, item.held_out(best)))
        )
    return Fitted(best.label, count, errors)


def main() -> None:
    """Serve the process that started this one."""
    serve(PluginFiles, FitMethod, _begin)
