"""The far end of a process that renders and checks references."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from msgspec import Struct

from oitbench.effects import effects_of
from oitbench.errors import UsageError
from oitbench.executors.executor import Far, Settings
from oitbench.fingerprints.scene import scene_fingerprint
from oitbench.path_traced.references import lookup, pieces
from oitbench.path_traced.references.check import check, failure_folder
from oitbench.path_traced.references.pieces import Pieces
from oitbench.path_traced.references.rendering import plan_rendering
from oitbench.path_traced.references.storage import Rendering
from oitbench.path_traced.references.wanted import Wanted
from oitbench.path_traced.trace.render import Progress
from oitbench.places import PluginFiles
from oitbench.plugins import Collection
from oitbench.scene import Scene
from oitbench.views import MAIN
from oitbench.workers.messages import Step
from oitbench.workers.serve import OnStep, serve

_BUILDING, _TRACING = Step("building the scene"), Step("path tracing the scene")


class Job(Struct, frozen=True):
    """One reference to render or to check.

    `scene` is a canonical label, `truth` MATCHED or FULL, `ssaa` the side of the sub-pixel grid of
    the pictures to compare, `left_out` has names of effects that do not run, and `view` is the name
    of a camera.
    """

    scene: str
    size: tuple[int, int]
    ssaa: int
    truth: str
    left_out: tuple[str, ...] = ()
    view: str = MAIN

    def wanted(self, scene: Scene) -> Wanted:
        """Return the reference of `scene`, as seen from the view, that the job is about."""
        gone = effects_of(self.left_out)
        return Wanted(scene, self.scene, self.size, self.ssaa, self.truth, ~gone, self.view)


class PlanReference(Struct, frozen=True, tag=True):
    """Asks how a reference is rendered; see `plan_rendering`."""

    job: Job
    spp: int | None
    seed: int


class RenderPiece(Struct, frozen=True, tag=True):
    """Asks for a piece of a reference, as the file `name` of the folder; see `pieces`."""

    job: Job
    rendering: Rendering
    number: int
    name: str


class CheckReference(Struct, frozen=True, tag=True):
    """Asks for a check of a stored reference.

    Images of a failed check are written below `failures`. A stale reference that passes is adopted
    if `adopts`.
    """

    job: Job
    spp: int
    failures: Path
    adopts: bool


class ReferencePlanned(Struct, frozen=True, tag=True):
    """The rendering of the reference, the number of its pieces, and the scene's exposure."""

    rendering: Rendering
    pieces: int
    exposure: float


class PieceRendered(Struct, frozen=True, tag=True):
    """The wall-clock seconds of the piece."""

    seconds: float


class ReferenceChecked(Struct, frozen=True, tag=True):
    """The result of a check.

    Parameters
    ----------
    key : str
    unusable : str
        One line on references that were found and cannot be used, or "".
    fraction : float, optional
        Share of the pixels that pass. None: there is no usable reference.
    failures : Path, optional
        The folder with the images of a failed check. None: the check has passed.
    adopted : bool
    """

    key: str
    unusable: str
    fraction: float | None = None
    failures: Path | None = None
    adopted: bool = False

    @property
    def well(self) -> bool:
        """Whether the reference is current and has passed."""
        passed = self.fraction is not None and self.failures is None
        return passed and (self.adopted or not self.unusable)


Request = PlanReference | RenderPiece | CheckReference
Reply = ReferencePlanned | PieceRendered | ReferenceChecked


def far_end(plugins: PluginFiles, folder: Path) -> Far:
    """Return the process of this file, which writes pieces into `folder`."""
    return Far(__name__, Settings(plugins, folder), Reply)


def begin(settings: Settings, on_step: OnStep) -> Callable[[Request], Reply]:
    """Return the function that answers."""
    easel = _Easel(settings, on_step)

    def answer(request: Request) -> Reply:
        scene = easel.scene(request.job)
        on_step(_TRACING)
        if isinstance(request, PlanReference):
            rendering = plan_rendering(request.job.wanted(scene), request.spp, request.seed)
            return ReferencePlanned(rendering, Pieces(scene, rendering).count, scene.exposure)
        if isinstance(request, RenderPiece):
            return easel.render(request)
        return _check(scene, request, easel.folders, easel.progress)

    return answer


class _Easel:
    """The last scene and its last reference, which consecutive requests share."""

    def __init__(self, settings: Settings, on_step: OnStep) -> None:
        self._collection = Collection(settings.plugins.places())
        self.folders = self._collection.folders
        self._folder, self._on_step = settings.folder, on_step
        self._built: tuple[str, str] | None = None
        self._pieces: tuple[Rendering, Pieces] | None = None

    def progress(self, done: int, count: int) -> None:
        """Begin a step with each sample, so that long renderings are not taken for endless ones."""
        self._on_step(_TRACING)

    def scene(self, job: Job) -> Scene:
        """Return the scene of a job as seen from its view."""
        if self._built != (job.scene, job.view):
            self._built = self._pieces = None
            self._on_step(_BUILDING)
            self._scene = self._collection.build_scene(job.scene).from_view(job.view)
            self._built = job.scene, job.view
        return self._scene

    def render(self, request: RenderPiece) -> PieceRendered:
        """Render a piece of the scene that was built last, and write it.

        Raises
        ------
        UsageError
            The scene's files have changed since the reference was planned.
        """
        start = time.perf_counter()
        if scene_fingerprint(self._scene) != request.rendering.fingerprint:
            raise UsageError(f"{request.job.scene}: its files changed meanwhile; run again")
        if self._pieces is None or self._pieces[0] != request.rendering:
            self._pieces = request.rendering, Pieces(self._scene, request.rendering)
        piece = self._pieces[1].render(request.number, self.progress)
        pieces.write(self._folder / request.name, piece)
        return PieceRendered(time.perf_counter() - start)


def _check(
    scene: Scene, request: CheckReference, folders: list[Path], progress: Progress
) -> ReferenceChecked:
    wanted = request.job.wanted(scene)
    found, key = lookup.find(wanted, folders), wanted.key
    reference = found.reference
    if reference is None and request.adopts and found.stale is not None:
        reference = found.stale[1]
    if reference is None:
        if not found.message:
            raise UsageError(
                f"{key}: no such reference is stored; run without --check to render it"
            )
        return ReferenceChecked(key, found.message)
    failures = request.failures
    result = check(scene, reference, failures, request.spp, progress)
    adopted = result.passed and found.reference is None and found.stale is not None
    if adopted and found.stale is not None:
        lookup.adopt(scene, *found.stale)
    folder = None if result.passed else failure_folder(failures, reference)
    return ReferenceChecked(key, found.message, result.fraction, folder, adopted)


def main() -> None:
    """Serve the process that started this one."""
    serve(Settings, Request, begin)
