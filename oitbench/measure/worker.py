"""The far end of a process that measures visibility curves."""

from __future__ import annotations

import os
import pickle
from collections.abc import Callable
from pathlib import Path

from msgspec import Struct

from oitbench.gl.device import Device
from oitbench.measure import visibility
from oitbench.places import Places
from oitbench.plugins import Collection
from oitbench.workers.messages import Step
from oitbench.workers.serve import OnStep, serve

_BUILDING = Step("building the scene")


class Settings(Struct, frozen=True):
    """All collections, files that are scenes, and the file of each method that is used, by name."""

    collections: list[bytes]
    scenes: list[bytes]
    methods: dict[str, bytes]


class MeasurePixel(Struct, frozen=True, tag=True):
    """Asks for the curves of methods at one pixel, in `file`, pickled; labels select all."""

    scene: str
    pixel: tuple[int, int]
    size: tuple[int, int]
    methods: list[str]
    file: bytes


class PixelMeasured(Struct, frozen=True, tag=True):
    """The file is written."""


def collection_of(settings: Settings) -> Collection:
    """Return the plugins that the settings name."""
    places = Places(map(_path, settings.collections), (), map(_path, settings.scenes))
    for name, path in settings.methods.items():
        places.methods.add(name, _path(path))
    return Collection(places)


def _begin(settings: Settings, on_step: OnStep) -> Callable[[MeasurePixel], PixelMeasured]:
    collection = collection_of(settings)

    def answer(request: MeasurePixel) -> PixelMeasured:
        on_step(_BUILDING)
        scene = collection.build_scene(request.scene)
        methods = collection.expand_methods(request.methods)

        def announce(label: str) -> None:
            on_step(Step(f"measuring {label}"))

        with Device() as device:
            curves = visibility.measure(
                device, scene, request.pixel, request.size, methods, announce
            )
        with _path(request.file).open("wb") as file:
            pickle.dump(curves, file)
        return PixelMeasured()

    return answer


def _path(encoded: bytes) -> Path:
    return Path(os.fsdecode(encoded))


def main() -> None:
    """Serve the process that started this one."""
    serve(Settings, MeasurePixel, _begin)
