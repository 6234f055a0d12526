"""Scenes that were built in Python, as files: workers and later runs read them from there."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from oitbench.atomic import replacing
from oitbench.errors import UsageError, printable
from oitbench.importing.written import encode_scene
from oitbench.places import WRITTEN
from oitbench.results.store import SCENES, refuse_foreign
from oitbench.scene import Scene

_DIGITS = 16
_FORBIDDEN = set("[],=@/")


def keep(scenes: Sequence[str | Scene], out: Path) -> list[str]:
    """Return selectors of scenes; those that were built in Python become files in a results folder.

    A file lies in a folder that is named by its content, so it is never replaced by another one.

    Raises
    ------
    UsageError
        The folder holds something other than results, or no file can have the name of a scene.
    SceneError
        A scene holds something that no file can hold.
    StorageError
        A file cannot be written.
    """
    if any(isinstance(scene, Scene) for scene in scenes):
        refuse_foreign(out)
    return [_write(scene, out / SCENES) if isinstance(scene, Scene) else scene for scene in scenes]


@contextmanager
def temporary(scene: str | Scene) -> Iterator[str]:
    """Yield the selector of a scene; the file of one that was built in Python ends with the block.

    Raises
    ------
    UsageError, SceneError, StorageError
        As `keep` does.
    """
    if not isinstance(scene, Scene):
        yield scene
        return
    with TemporaryDirectory(prefix="oitbench-") as folder:
        yield _write(scene, Path(folder))


def _write(scene: Scene, folder: Path) -> str:
    name = scene.name
    if (
        not name.strip()
        or name != name.strip()
        or printable(name) != name
        or set(name) & _FORBIDDEN
    ):
        raise UsageError(
            f"a scene from Python cannot have the name '{name}'; leave out"
            f" {' '.join(sorted(_FORBIDDEN))} and line breaks"
        )
    content = encode_scene(scene)
    path = folder / hashlib.sha256(content).hexdigest()[:_DIGITS] / f"{name}{WRITTEN}"
    with replacing(path) as partial:
        partial.write_bytes(content)
    return str(path)
