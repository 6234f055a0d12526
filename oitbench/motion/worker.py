"""The far end of a process that films methods."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path

from msgspec import Struct

from oitbench.errors import SceneError
from oitbench.filenames import file_name
from oitbench.gl.device import Device
from oitbench.gl.limits import check_size
from oitbench.image import files, stored
from oitbench.image.files import Image
from oitbench.image.stored import StoredImage
from oitbench.motion.film import SEED, Keep, Set, Shot, exact_changes, film
from oitbench.motion.path import cameras_of
from oitbench.motion.record import FRAMES, CameraPlace, Track
from oitbench.places import PluginFiles
from oitbench.plugins import Collection
from oitbench.results.schema import Renderer
from oitbench.scene import Camera
from oitbench.shading import read_shading
from oitbench.workers.messages import Step
from oitbench.workers.serve import OnStep, serve

_BUILDING = Step("building the scene", shared=True)


class Settings(Struct, frozen=True):
    """The files of plugins, the folder of results, and the path."""

    plugins: PluginFiles
    folder: Path
    scene: str
    view: str
    size: tuple[int, int]
    ssaa: int
    frames: int | None
    turns: float | None
    shading: str


class FilmExact(Struct, frozen=True, tag=True):
    """Asks for exact compositing along the path."""


class FilmMethod(Struct, frozen=True, tag=True):
    """Asks for a method along the path; a method with a seed is filmed twice."""

    method: str


class ExactFilmed(Struct, frozen=True, tag=True):
    """The path and exact compositing along it; see `MotionFile`."""

    gl: Renderer
    exposure: float
    path: list[CameraPlace]
    frames: list[StoredImage]
    change: list[float]


class MethodFilmed(Struct, frozen=True, tag=True):
    """One track, or two for a method with a seed."""

    tracks: list[Track]


Request = FilmExact | FilmMethod
Reply = ExactFilmed | MethodFilmed


class _Studio:
    """The scene on the device, and exact compositing along the path."""

    def __init__(self, settings: Settings, on_step: OnStep) -> None:
        self.collection = Collection(settings.plugins.places())
        self._settings, self._on_step = settings, on_step
        self._open = ExitStack()
        on_step(_BUILDING)
        scene = self.collection.build_scene(settings.scene).from_view(settings.view)
        if scene.lists is not None:
            raise SceneError(f"{scene.name}: fragment lists have no camera that could move")
        self._device = self._open.enter_context(Device())
        width, height = settings.size
        check_size(self._device, (width * settings.ssaa, height * settings.ssaa))
        self.cameras: Sequence[Camera] = cameras_of(scene, settings.frames, settings.turns)
        self.stage = self._open.enter_context(
            Set(
                self._device,
                scene,
                settings.size,
                settings.ssaa,
                read_shading(settings.shading),
                self.collection.truth(),
            )
        )
        self.shots: list[Shot] = []
        for number, camera in enumerate(self.cameras):
            on_step(Step(f"drawing exact compositing, frame {number}", shared=True))
            self.shots.append(self.stage.exact(camera))

    def exact(self) -> ExactFilmed:
        """Store exact compositing."""
        keep = self._keeping("exact")
        return ExactFilmed(
            Renderer.of(self._device),
            self.stage.scene.exposure,
            [CameraPlace.of(camera) for camera in self.cameras],
            [keep(number, shot.linear) for number, shot in enumerate(self.shots)],
            exact_changes(self.shots),
        )

    def film(self, label: str) -> list[Track]:
        """Film a method."""
        (method,) = self.collection.expand_methods([label])
        seeds = (False, True) if SEED in method.parameters else (False,)
        return [
            film(
                self.stage,
                method,
                self.cameras,
                self.shots,
                self._keeping(f"{label}{'+' if per_frame else ''}"),
                per_frame=per_frame,
            )
            for per_frame in seeds
        ]

    def _keeping(self, label: str) -> Keep:
        folder = self._settings.folder

        def keep(number: int, image: Image) -> StoredImage:
            self._on_step(Step(f"drawing {label}, frame {number + 1}"))
            channels = files.image_channels(image, half=files.fits_half(image))
            return stored.store(folder, f"{FRAMES}/{file_name(label)}-{number:04d}", channels)

        return keep


def _begin(settings: Settings, on_step: OnStep) -> Callable[[Request], Reply]:
    studio = _Studio(settings, on_step)

    def answer(request: Request) -> Reply:
        if isinstance(request, FilmExact):
            return studio.exact()
        on_step(Step(f"drawing {request.method}, frame 0"))
        return MethodFilmed(studio.film(request.method))

    return answer


def main() -> None:
    """Serve the process that started this one."""
    serve(Settings, Request, _begin)
