"""GLSL sources: lookup, includes, and compiler messages that name file and line.

A plain name is a file beside the including one, or else in the folders of the method: its own, then
its collection's `glsl/`. `KIT/FILE.glsl` is a shader of a kit (`oitbench/method/kits`), and
`oitbench/FILE.glsl` one of the engine's. Engine shaders only include engine shaders, so a method
cannot replace any of them. A file is included once, however often it is named.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path

from oitbench.errors import DeclarationError

_INCLUDE = re.compile(r'^\s*#include\s+"([^"]+)"\s*$')
# Mesa writes "0:14(7): error: …", NVIDIA "0(14) : error …", Intel and AMD "ERROR: 0:14: …".
_MESSAGES = (
    re.compile(r"^\s*\d+:(?P<line>\d+)\(\d+\):\s*(?P<text>error.*)$", re.M),
    re.compile(r"^\s*\d+\((?P<line>\d+)\)\s*:\s*(?P<text>error.*)$", re.M),
    re.compile(r"^\s*ERROR:\s*\d+:(?P<line>\d+):\s*(?P<text>.*)$", re.M),
)
_VERSION = "#version 450 core"
_PACKAGE = Path(str(files("oitbench")))
_ENGINE = _PACKAGE / "gl" / "shaders"
_KITS = _PACKAGE / "method" / "kits"


@dataclass
class Source:
    """A shader under assembly; the origin of each line is kept for error messages.

    `#line` would not do: Mesa drops its file number in most messages about expressions.

    Parameters
    ----------
    folders : sequence of Path
        Folders of the method; empty for shaders of the engine.
    extensions : tuple of str
        GLSL extensions to require.
    """

    folders: Sequence[Path] = ()
    extensions: tuple[str, ...] = ()
    lines: list[str] = field(default_factory=list)
    places: list[tuple[str, int]] = field(default_factory=list)
    _included: set[Path] = field(default_factory=set)

    def add_text(self, name: str, text: str) -> None:
        """Append generated `text`, called `name` in messages."""
        self._append(name, text, None, ())

    def add_engine_file(self, name: str) -> None:
        """Append a shader of the engine."""
        self._add(self._find(name, _ENGINE), ())

    def add_file(self, name: str) -> None:
        """Append a shader of the method, of its collection, or of a kit."""
        self._add(self._find(name, None), ())

    def _find(self, name: str, beside: Path | None) -> Path:
        """Return the file that `name` means in a file of the folder `beside`; None: in a plan."""
        kit, _, plain = name.rpartition("/")
        if beside == _ENGINE:
            candidates = [_ENGINE / name]
        elif kit == _PACKAGE.name:
            candidates = [_ENGINE / plain]
        elif kit:
            candidates = [_KITS / kit / plain]
        else:
            candidates = [folder / name for folder in (beside, *self.folders) if folder]
        for path in candidates:
            if path.is_file():
                return path
        places = [path.parent for path in dict.fromkeys(candidates)]
        where = ", ".join(map(_shown, places)) or "any folder"
        known = {path.name for place in places for path in place.glob("*.glsl")}
        near = difflib.get_close_matches(plain, known, n=1)
        hint = f"; did you mean {near[0]}?" if near else ""
        raise DeclarationError(f"there is no shader '{name}' in {where}{hint}")

    def _add(self, path: Path, open_files: tuple[Path, ...]) -> None:
        self._included.add(path)
        self._append(_shown(path), path.read_text(encoding="utf-8"), path, open_files)

    def _append(
        self, name: str, text: str, path: Path | None, open_files: tuple[Path, ...]
    ) -> None:
        for index, line in enumerate(text.splitlines(), start=1):
            include = _INCLUDE.match(line)
            if include is None:
                self.lines.append(line)
                self.places.append((name, index))
                continue
            try:
                found = self._find(include[1], path.parent if path else None)
            except DeclarationError as error:
                raise DeclarationError(f"{name}:{index}: {error}") from error
            if found == path or found in open_files:
                raise DeclarationError(f"{name}:{index}: '{include[1]}' includes itself")
            if found not in self._included:
                self._add(found, (*open_files, *([path] if path else [])))

    @property
    def text(self) -> str:
        """The whole source, starting with `#version`."""
        return "\n".join([*self._head, *self.lines, ""])

    @property
    def _head(self) -> list[str]:
        return [_VERSION, *(f"#extension {name} : require" for name in self.extensions)]

    def explain(self, log: str) -> str:
        """Return a compiler's log as one line that starts with file and line of the error."""
        for pattern in _MESSAGES:
            match = pattern.search(log)
            if match is None:
                continue
            # Drivers count lines from one, and the head precedes all files.
            index = int(match["line"]) - 1 - len(self._head)
            if 0 <= index < len(self.places):
                name, line = self.places[index]
                return f"{name}:{line}: {match['text'].strip()}"
        kept = [line for line in log.splitlines() if line.strip(" =-")]
        return " ".join([self.places[-1][0] + ":", *kept[:6]])


def _shown(path: Path) -> str:
    """Return a path as messages show it: files of the package relative to its parent."""
    if path.is_relative_to(_PACKAGE):
        return path.relative_to(_PACKAGE.parent).as_posix()
    return str(path)
