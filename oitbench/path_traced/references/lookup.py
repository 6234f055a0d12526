"""Finding the reference of a scene: in the collections, in the cache, or rendered on demand.

A reference whose scene has changed is stale. It is reported and never used.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from oitbench.errors import UsageError
from oitbench.path_traced.references.fingerprint import fingerprint
from oitbench.path_traced.references.rendering import render_reference
from oitbench.path_traced.references.storage import FOLDER, Reference, read, save
from oitbench.scene import Scene


def find(
    scene: Scene,
    label: str,
    size: tuple[int, int],
    ssaa: int,
    folders: Iterable[Path],
    cache: Path | None = None,
) -> Reference | None:
    """Return the stored reference of a scene, from a collection or from the cache.

    Parameters
    ----------
    scene : Scene
    label : str
        The canonical label of the scene.
    size : (int, int)
        Width and height in pixels.
    ssaa : int
        Side of the sub-pixel grid. References of another grid do not count.
    folders : iterable of Path
        Folders of collections. The last one that has a reference takes precedence.
    cache : Path, optional
        Default: no cache.

    Returns
    -------
    Reference or None
        One that fits the scene, else a stale one with a message, else None.

    Raises
    ------
    UsageError
        If a manifest or an image is damaged.
    """
    current = fingerprint(scene)
    places = [folder / FOLDER for folder in folders][::-1]
    if cache is not None:
        places.append(_place_in_cache(cache, current, size, ssaa))
    stale: Reference | None = None
    for place in places:
        found = read(place, label, size)
        if found is None or found.info.ssaa != ssaa:
            continue
        if found.info.fingerprint == current:
            return found if stale is None else replace(found, message=stale.message)
        message = (
            f"{place / found.info.key}: the scene has changed since this reference was rendered; "
            f"run 'oitbench reference {label}'"
        )
        stale = stale or replace(found, stale=True, message=message)
    return stale


def find_or_render(
    scene: Scene, label: str, size: tuple[int, int], ssaa: int, folders: Iterable[Path]
) -> Reference:
    """Return a reference that fits a scene: from a collection, else from the cache, else rendered.

    A reference that is rendered is stored in the cache.

    Parameters
    ----------
    scene, label, size, ssaa, folders
        As in `find`.

    Returns
    -------
    Reference
        Never stale. Its message reports a stale reference that was not used, and a cache that
        cannot be written to.

    Raises
    ------
    CapabilityError
        If the scene cannot be path traced on this machine.
    SceneError
        If the radiance of a ray is not finite.
    UsageError
        If a manifest or an image is damaged.
    """
    cache = cache_folder()
    found = find(scene, label, size, ssaa, folders, cache)
    if found is not None and not found.stale:
        return found
    reference = render_reference(scene, label, size, ssaa)
    message = found.message if found is not None else ""
    try:
        if cache is None:
            raise UsageError("there is no home folder; set XDG_CACHE_HOME")
        save(_place_in_cache(cache, reference.info.fingerprint, size, ssaa), reference)
    except UsageError as error:
        message = f"{message}; not cached: {error}".removeprefix("; ")
    return replace(reference, message=message)


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


def _place_in_cache(cache: Path, digest: str, size: tuple[int, int], ssaa: int) -> Path:
    """Return a folder for one reference, so that two processes never share a manifest."""
    return cache / f"{digest[:16]}-{size[0]}x{size[1]}-{ssaa}"
