"""The far end of a process that draws, scores and times the rows of one engine."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from msgspec import Struct

from oitbench.engines.adapter import Algorithm, Drawing, Engine
from oitbench.engines.content import unlit
from oitbench.engines.known import load
from oitbench.engines.own import OwnFrame
from oitbench.engines.record import FOLDER, Place, Scores
from oitbench.filenames import file_name
from oitbench.gl.device import Device
from oitbench.image import files, metrics, stored
from oitbench.image.stored import StoredImage
from oitbench.places import PluginFiles
from oitbench.plugins import Collection
from oitbench.scene import Scene
from oitbench.workers.messages import Step
from oitbench.workers.serve import OnStep, serve

_MILLISECONDS = 1e3


class Settings(Struct, frozen=True):
    """The files of plugins, the results folder and an engine; none stands for the suite itself."""

    plugins: PluginFiles
    folder: Path
    engine: str = ""


class Describe(Struct, frozen=True, tag=True):
    """Asks for what an engine can do, which its adapter knows even if it is not installed."""


class DrawRow(Struct, frozen=True, tag=True):
    """Asks for the picture of an algorithm, scored against pictures of the results folder.

    `algorithm` is a method's label if the engine is the suite itself.
    """

    place: Place
    algorithm: str
    against: dict[str, StoredImage]


class TimeRow(Struct, frozen=True, tag=True):
    """Asks for the time of one frame of an algorithm, without sub-pixels."""

    place: Place
    algorithm: str


class Described(Struct, frozen=True, tag=True):
    """The algorithms of an engine by name."""

    algorithms: dict[str, Algorithm]


class RowDrawn(Struct, frozen=True, tag=True):
    """The picture, its scores by what it was compared with, and facts of the engine."""

    image: StoredImage
    scores: Scores
    renderer: str
    version: str


class RowTimed(Struct, frozen=True, tag=True):
    """Milliseconds of the wall clock from the first call until the frame is complete."""

    ms: float


Request = Describe | DrawRow | TimeRow
Reply = Described | RowDrawn | RowTimed
_Open = Callable[[Scene, str, tuple[int, int]], Drawing]


class _Own:
    """The suite itself, asked like an engine."""

    version = ""

    def __init__(self, collection: Collection) -> None:
        self._collection, self._device = collection, Device()
        self.renderer = self._device.renderer

    def open(self, scene: Scene, method: str, size: tuple[int, int]) -> Drawing:
        return OwnFrame(self._device, self._collection, scene, method, size)


class _Foreign:
    """An engine, which receives scenes as it can draw them."""

    def __init__(self, engine: Engine) -> None:
        self._engine, self.version = engine, engine.version

    @property
    def renderer(self) -> str:
        return self._engine.renderer

    def open(self, scene: Scene, algorithm: str, size: tuple[int, int]) -> Drawing:
        content = unlit(scene, size[1], self._engine.brightest)
        return self._engine.open(content, algorithm, size)


class _Easel:
    """The scene of a place, and the drawings that are timed there."""

    def __init__(self, settings: Settings, on_step: OnStep) -> None:
        self._collection = Collection(settings.plugins.places())
        self._folder, self._on_step = settings.folder, on_step
        on_step(Step("starting the engine"))
        self._engine = (
            _Foreign(load(settings.engine)()) if settings.engine else _Own(self._collection)
        )
        self._place: Place | None = None
        self._timed: dict[str, Drawing] = {}

    def draw(self, request: DrawRow) -> RowDrawn:
        """Draw, store and score one picture."""
        place, scene = request.place, self._scene(request.place)
        self._on_step(Step(f"drawing {request.algorithm}"))
        fine = (place.size[0] * place.ssaa, place.size[1] * place.ssaa)
        drawing = self._engine.open(scene, request.algorithm, fine)
        try:
            drawing.draw()
            image = files.box_downsample(drawing.image(), place.ssaa)
        finally:
            drawing.release()
        stem = f"{FOLDER}/{file_name(f'{place.scene} {request.algorithm}')}"
        kept = stored.store(self._folder, stem, files.image_channels(image))
        scores: Scores = {}
        for name, other in request.against.items():
            self._on_step(Step(f"scoring {request.algorithm}"))
            truth = files.read_exr(stored.verify(self._folder, other))
            scores[name] = metrics.compare(truth, image, scene.exposure).values
        return RowDrawn(kept, scores, self._engine.renderer, self._engine.version)

    def time(self, request: TimeRow) -> RowTimed:
        """Time one frame; the drawing stays open for the next one."""
        scene = self._scene(request.place)
        if request.algorithm not in self._timed:
            opened = self._engine.open(scene, request.algorithm, request.place.size)
            self._timed[request.algorithm] = opened
            opened.draw()
        start = time.perf_counter()
        self._timed[request.algorithm].draw()
        return RowTimed(_MILLISECONDS * (time.perf_counter() - start))

    def _scene(self, place: Place) -> Scene:
        if place != self._place:
            for drawing in self._timed.values():
                drawing.release()
            self._timed.clear()
            self._on_step(Step("building the scene", shared=True))
            self._built = self._collection.build_scene(place.scene).from_view(place.view)
            self._place = place
        return self._built


def _begin(settings: Settings, on_step: OnStep) -> Callable[[Request], Reply]:
    easel: _Easel | None = None

    def answer(request: Request) -> Reply:
        nonlocal easel
        if isinstance(request, Describe):
            return Described(dict(load(settings.engine).algorithms))
        easel = easel or _Easel(settings, on_step)
        return easel.draw(request) if isinstance(request, DrawRow) else easel.time(request)

    return answer


def main() -> None:
    """Serve the process that started this one."""
    serve(Settings, Request, _begin)
