"""Finding the reference of a scene: in the collections, in the cache, or rendered on demand.

A reference of another scene or of another path tracer is stale. Stale and damaged references are
reported and never used.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import msgspec

from oitbench.effects import names
from oitbench.errors import UsageError
from oitbench.fingerprints.scene import scene_fingerprint
from oitbench.path_traced.references import storage
from oitbench.path_traced.references.rendering import plan_rendering, render_reference
from oitbench.path_traced.references.storage import (
    FOLDER,
    MANIFEST,
    Reference,
    Rendering,
    read,
    save,
    stored_precision,
)
from oitbench.path_traced.references.wanted import Wanted
from oitbench.path_traced.trace.render import Progress
from oitbench.path_traced.version import TRACER
from oitbench.scene import Scene
from oitbench.views import selection


@dataclass(frozen=True)
class Found:
    """The result of a search.

    Parameters
    ----------
    reference : Reference, optional
        One that fits the scene.
    message : str
        One line on references that were found and cannot be used; empty if there is nothing to
        report.
    stale : (Path, Reference), optional
        If none fits, the stale one that takes precedence, and its folder.
    """

    reference: Reference | None
    message: str = ""
    stale: tuple[Path, Reference] | None = None


def find(wanted: Wanted, folders: Iterable[Path]) -> Found:
    """Return the stored reference of a scene from a collection.

    Parameters
    ----------
    wanted : Wanted
        References of another sub-pixel grid do not count.
    folders : iterable of Path
        Folders of collections. The last one that has a reference takes precedence.
    """
    current = scene_fingerprint(wanted.scene)
    messages: list[str] = []
    stale: tuple[Path, Reference] | None = None
    for folder in [folder / FOLDER for folder in folders][::-1]:
        try:
            found = read(folder, wanted.key)
        except UsageError as error:
            messages.append(str(error))
            continue
        if found is None or found.rendering.ssaa != wanted.grid:
            continue
        changed = _changed(found.rendering, current, names(wanted.effects))
        if not changed:
            return Found(found, "; ".join(messages))
        stale = stale or (folder, found)
        messages.append(
            f"{folder / wanted.key}: {changed} has changed since this reference was rendered; run"
            f" 'oitbench reference {selection(wanted.label, wanted.view)}'"
        )
    return Found(None, "; ".join(messages), stale)


def _changed(rendering: Rendering, fingerprint: str, effects: list[str]) -> str:
    if rendering.fingerprint != fingerprint:
        return "the scene"
    if rendering.effects != effects:
        return "the set of effects"
    return "" if rendering.tracer == TRACER else "the path tracer"


def adopt(scene: Scene, folder: Path, stale: Reference) -> None:
    """Declare that a stale reference shows this scene as this path tracer renders it.

    Parameters
    ----------
    scene : Scene
    folder : Path
        The folder of the reference.
    stale : Reference
        It must have passed `check.check` with this scene.
    """
    known = stale.rendering
    current = msgspec.structs.replace(known, tracer=TRACER, fingerprint=scene_fingerprint(scene))
    storage.adopt(folder, known.key, current)


def truth_fingerprint(wanted: Wanted, folders: Iterable[Path]) -> str:
    """Return a digest of the rendering of the reference that `find_or_render` returns."""
    found = find(wanted, folders).reference
    return (found.rendering if found else plan_rendering(wanted)).digest


def find_finished(wanted: Wanted, folders: Iterable[Path]) -> Reference | None:
    """Return the reference that `find_or_render` would not have to render, or None.

    Raises
    ------
    CapabilityError
        If the scene cannot be path traced on this machine.
    """
    found = find(wanted, folders).reference
    if found is not None:
        return found
    cache = cache_folder()
    place = cache / plan_rendering(wanted).digest if cache is not None else None
    return _read_cached(place, wanted.key)


def find_or_render(
    wanted: Wanted, folders: Iterable[Path], progress: Progress = lambda done, count: None
) -> tuple[Reference, str]:
    """Return a reference that fits a scene: from a collection, else from the cache, else rendered.

    A reference that is rendered is stored in the cache, and what is returned is what is stored.

    Parameters
    ----------
    wanted, folders
        As in `find`.
    progress : callable
        As in `render_reference`.

    Returns
    -------
    reference : Reference
    message : str
        One line on references that were not used, and on a cache that cannot be written to; empty
        if there is nothing to report.

    Raises
    ------
    CapabilityError
        If the scene cannot be path traced on this machine.
    SceneError
        If the radiance of a ray is not finite.
    """
    found = find(wanted, folders)
    if found.reference is not None:
        return found.reference, found.message
    messages = [found.message] if found.message else []
    rendering = plan_rendering(wanted)
    cache = cache_folder()
    place = cache / rendering.digest if cache is not None else None
    reference = _read_cached(place, wanted.key)
    if reference is None:
        fresh = render_reference(wanted.scene, rendering, progress)
        try:
            if place is None:
                raise UsageError("there is no home folder; set XDG_CACHE_HOME")
            save(place, fresh)
        except UsageError as error:
            messages.append(f"not cached: {error}")
        reference = _read_cached(place, wanted.key) or stored_precision(fresh)
    return reference, "; ".join(messages)


def _read_cached(place: Path | None, key: str) -> Reference | None:
    """Return a reference of the cache, or None; a damaged one is removed."""
    if place is None:
        return None
    try:
        return read(place, key)
    except UsageError:
        with suppress(OSError):
            (place / MANIFEST).unlink()
        return None


def cache_folder() -> Path | None:
    """Return the user's cache of references, below `XDG_CACHE_HOME` or `~/.cache`.

    None if neither exists: the user has no home folder, as in some containers.
    """
    base = os.environ.get("XDG_CACHE_HOME")
    try:
        folder = Path(base) if base else Path.home() / ".cache"
    except RuntimeError:
        return None
    return folder / "oitbench" / "references"
