"""The code and the plugins of a machine, so that no worker computes with others than its client."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Iterator, Mapping
from pathlib import Path

from oitbench.fingerprints.code import PACKAGES, package_version
from oitbench.places import PluginFiles, own_folder

Inventory = dict[str, str]
"""Versions and digests by what they are of; files of the suite by their paths below it."""
_PACKAGE = Path(__file__).resolve().parents[1]
_CODE = (".py", ".glsl")
_FOLDERS = ("methods", "scenes", "glsl")
_REFERENCES = "reference/manifest.json"
_MISSING = "none"


def relocated(plugins: PluginFiles, home: Path) -> PluginFiles:
    """Return plugins of another machine as they lie on this one.

    Parameters
    ----------
    plugins : PluginFiles
    home : Path
        Folder of the suite's own collection there. Other files have the same paths everywhere.
    """

    def here(path: Path) -> Path:
        return own_folder() / path.relative_to(home) if path.is_relative_to(home) else path

    return PluginFiles(
        [here(path) for path in plugins.collections],
        [here(path) for path in plugins.scenes],
        {name: here(path) for name, path in plugins.methods.items()},
    )


def take(plugins: PluginFiles, home: Path) -> Inventory:
    """Return the inventory of this machine for plugins of a client whose `home` is known."""
    found = {name: package_version(name) or _MISSING for name in PACKAGES}
    found["Python"] = ".".join(platform.python_version_tuple()[:2])
    files = {f"oitbench/{path.relative_to(_PACKAGE)}": path for path in _code(_PACKAGE)}
    here = relocated(plugins, home)
    for there, folder in zip(plugins.collections, here.collections, strict=True):
        files |= {
            str(path.relative_to(folder) if there == home else path): path
            for path in _plugins(folder)
        }
    for path in (*here.scenes, *(p for m in here.methods.values() for p in m.parent.rglob("*"))):
        if path.is_file() and "__pycache__" not in path.parts:
            files.setdefault(str(path), path)
    own = str(own_folder())
    digests = {name: _digest(path) for name, path in files.items() if not name.startswith(own)}
    return found | digests


def difference(wanted: Mapping[str, str], found: Mapping[str, str]) -> str:
    """Return the first difference of a worker's inventory as a line, or ""."""
    for name in sorted({*wanted, *found}, key=lambda name: (name not in PACKAGES, name)):
        here, there = wanted.get(name, _MISSING), found.get(name, _MISSING)
        if here == there:
            continue
        if name in (*PACKAGES, "Python"):
            return f"it has {name} {there}, this machine {here}; install the same version"
        if there == _MISSING:
            return f"it lacks {name}; put this machine's files at the same paths"
        return f"its {name} differs from this machine's; bring both to the same state"
    return ""


def _code(folder: Path) -> Iterator[Path]:
    inside = folder / "collection"
    for path in folder.rglob("*"):
        if path.suffix in _CODE and not path.is_relative_to(inside):
            yield path


def _plugins(folder: Path) -> Iterator[Path]:
    for kind in _FOLDERS:
        for path in (folder / kind).rglob("*"):
            if path.is_file() and "__pycache__" not in path.parts:
                yield path
    if (folder / _REFERENCES).is_file():
        yield folder / _REFERENCES


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
