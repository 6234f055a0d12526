"""Films methods along a path of cameras, in a process of its own."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from oitbench.catalog.catalog import Catalog, Choice
from oitbench.errors import DeclarationError, OitbenchError, UsageError
from oitbench.motion import record
from oitbench.motion.record import MotionFile, Track
from oitbench.motion.worker import (
    ExactFilmed,
    FilmExact,
    FilmMethod,
    MethodFilmed,
    Reply,
    Settings,
)
from oitbench.shading import read_shading
from oitbench.views import MAIN
from oitbench.workers import memory
from oitbench.workers.messages import Step
from oitbench.workers.process import Process, WorkerError

FRAME_SECONDS = 600.0
"""Time that each frame may take by default."""
_LOADING = Step("loading the files", shared=True)


def film(
    scene: str,
    methods: Sequence[str],
    out: Path,
    *,
    frames: int | None = None,
    turns: float | None = None,
    view: str = MAIN,
    size: tuple[int, int] = (256, 256),
    ssaa: int = 2,
    shading: Sequence[str] = (),
    collections: Iterable[Path | str] = (),
    timeout: float | None = FRAME_SECONDS,
    memory_gib: float | None = None,
    on_track: Callable[[str], None] = lambda label: None,
) -> MotionFile:
    """Film methods along a path, and write what was found to a folder.

    Parameters
    ----------
    scene : str
        `NAME[param=v]`.
    methods : sequence of str
        `NAME[param=v,w]`.
    out : Path
        Folder of `motion.json`, `motion.csv` and `frames/`.
    frames, turns : optional
        See `oitbench.motion.path.cameras_of`; 2 frames or more.
    view : str
        Name of the camera with which an orbit begins.
    size : (int, int)
        Width and height in pixels.
    ssaa : int
        Side of the grid of sub-pixels.
    shading : sequence of str
        Settings of shared shading, NAME=value.
    collections : iterable of path
        Further collection folders.
    timeout : float, optional
        Seconds that each frame may take. None: no limit.
    memory_gib : float, optional
        Memory that the process may use, in GiB. Default: 75 % of the machine's.
    on_track : callable
        Called with the label of each method before it is filmed.

    Raises
    ------
    OitbenchError
        Something is unknown, out of range, or not available on this machine, or exact compositing
        fails. A method that fails only has an entry in `failed`.
    """
    limit = memory.limit(memory_gib, 1)
    with Catalog(collections) as catalog:
        (scenes, chosen) = catalog.expand_scenes([scene]), catalog.expand_methods(methods)
        if len(scenes) != 1:
            raise UsageError(f"'{scene}' selects {len(scenes)} scenes; name one")
        if scenes[0].error:
            raise DeclarationError(scenes[0].error)
        settings = Settings(
            catalog.places.files(item.name for item in chosen),
            out,
            scenes[0].label,
            view,
            size,
            ssaa,
            frames,
            turns,
            read_shading(",".join(shading)).label,
        )
    tracks: list[Track] = []
    failed = {item.label: item.error for item in chosen if item.error}
    with Process("oitbench.motion.worker", settings, Reply, limit) as worker:
        exact = worker.ask(FilmExact(), ExactFilmed, timeout, _LOADING)
        for choice in chosen:
            if not choice.error:
                on_track(choice.label)
                _film(worker, choice, timeout, tracks, failed)
    found = MotionFile(
        exact.gl, settings.scene, size, ssaa, exact.exposure, settings.shading, view, exact.path,
        exact.frames, exact.change, tracks, failed,
    )  # fmt: skip
    record.write(out, found)
    return found


def _film(
    worker: Process,
    choice: Choice,
    timeout: float | None,
    tracks: list[Track],
    failed: dict[str, str],
) -> None:
    """Add the tracks of a method, or the reason why it has none."""
    try:
        tracks += worker.ask(FilmMethod(choice.label), MethodFilmed, timeout).tracks
    except WorkerError as error:
        if error.shared:
            raise  # the other methods need the same part
        failed[choice.label] = str(error)
    except OitbenchError as error:
        failed[choice.label] = str(error)
