"""The far end of a process that measures visibility curves, and statistics of scenes."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from pathlib import Path

from msgspec import Struct

from oitbench.effects import names
from oitbench.gl.device import Device
from oitbench.gl.limits import check_size
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.measure import scene_statistics, visibility
from oitbench.measure.scene_statistics import views_of
from oitbench.places import PluginFiles
from oitbench.plugins import Collection
from oitbench.results.statistics import SceneStatistics
from oitbench.scene import Scene
from oitbench.workers.messages import Step
from oitbench.workers.serve import OnStep, serve

_BUILDING = Step("building the scene")


class MeasurePixel(Struct, frozen=True, tag=True):
    """Asks for the curves of methods at one pixel, in `file`, pickled; labels select all."""

    scene: str
    pixel: tuple[int, int]
    size: tuple[int, int]
    methods: list[str]
    file: Path


class PixelMeasured(Struct, frozen=True, tag=True):
    """The file is written."""


class MeasureScene(Struct, frozen=True, tag=True):
    """Asks for the statistics of all views of a scene at one size."""

    scene: str
    size: tuple[int, int]


class SceneMeasured(Struct, frozen=True, tag=True):
    """The requested effects, and the statistics of each view by its name."""

    effects: list[str]
    views: dict[str, SceneStatistics]


Request = MeasurePixel | MeasureScene
Reply = PixelMeasured | SceneMeasured


def _begin(files: PluginFiles, on_step: OnStep) -> Callable[[Request], Reply]:
    collection = Collection(files.places())

    def answer(request: Request) -> Reply:
        on_step(_BUILDING)
        scene = collection.build_scene(request.scene)
        if isinstance(request, MeasureScene):
            return _measure_scene(scene, request.size, on_step)
        methods = collection.expand_methods(request.methods)

        def announce(label: str) -> None:
            on_step(Step(f"measuring {label}"))

        with Device() as device:
            curves = visibility.measure(
                device, scene, request.pixel, request.size, methods, announce
            )
        with request.file.open("wb") as file:
            pickle.dump(curves, file)
        return PixelMeasured()

    return answer


def _measure_scene(scene: Scene, size: tuple[int, int], on_step: OnStep) -> SceneMeasured:
    views: dict[str, SceneStatistics] = {}
    with Device() as device:
        check_size(device, size)
        for name, seen in views_of(scene).items():
            on_step(Step(f"counting fragments in view {name}"))
            with UploadedScene(device, seen, rows=size[1]) as uploaded:
                views[name] = scene_statistics.measure(uploaded, size, seen.effects)
    return SceneMeasured([effect.lower() for effect in names(scene.effects)], views)


def main() -> None:
    """Serve the process that started this one."""
    serve(PluginFiles, Request, _begin)
