"""The far end of a process that renders and checks references."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from msgspec import Struct

from oitbench.effects import effects_of
from oitbench.errors import UsageError
from oitbench.path_traced.references import lookup, storage
from oitbench.path_traced.references.check import check, failure_folder
from oitbench.path_traced.references.rendering import plan_rendering, render_reference
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


class RenderReference(Struct, frozen=True, tag=True):
    """Asks for a reference, which is stored in `folder`; see `plan_rendering`."""

    job: Job
    spp: int | None
    seed: int
    folder: Path


class CheckReference(Struct, frozen=True, tag=True):
    """Asks for a check of a stored reference.

    Images of a failed check are written below `failures`. A stale reference that passes is adopted
    if `adopts`.
    """

    job: Job
    spp: int
    failures: Path
    adopts: bool


class ReferenceRendered(Struct, frozen=True, tag=True):
    """The rendering of the reference, its noise floor by metric, and its wall-clock seconds."""

    rendering: Rendering
    noise_floor: dict[str, float | None]
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


Request = RenderReference | CheckReference
Reply = ReferenceRendered | ReferenceChecked


def _begin(files: PluginFiles, on_step: OnStep) -> Callable[[Request], Reply]:
    collection = Collection(files.places())

    def progress(done: int, count: int) -> None:
        # Each sample is a step, so that long renderings are not taken for endless ones.
        on_step(_TRACING)

    def answer(request: Request) -> Reply:
        on_step(_BUILDING)
        scene = collection.build_scene(request.job.scene).from_view(request.job.view)
        on_step(_TRACING)
        if isinstance(request, RenderReference):
            return _render(scene, request, progress)
        return _check(scene, request, collection.folders, progress)

    return answer


def _render(scene: Scene, request: RenderReference, progress: Progress) -> ReferenceRendered:
    rendering = plan_rendering(request.job.wanted(scene), request.spp, request.seed)
    reference = render_reference(scene, rendering, progress)
    storage.save(request.folder, reference)
    return ReferenceRendered(rendering, reference.noise_floor, reference.seconds)


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
    serve(PluginFiles, Request, _begin)
