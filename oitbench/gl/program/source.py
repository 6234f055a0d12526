"""GLSL sources: lookup, includes, and compiler messages that name a plugin's own file and line."""

from __future__ import annotations

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


@dataclass
class Source:
    """A shader under assembly; the place that each line comes from is kept, so errors can be told.

    `#line` would not do: Mesa forgets its file number in most messages about expressions.
    """

    folder: Path | None
    lines: list[str] = field(default_factory=list)
    places: list[tuple[str, int]] = field(default_factory=list)
    extensions: tuple[str, ...] = ()

    def add_text(self, name: str, text: str) -> None:
        """Append generated `text`, called `name` in messages."""
        self._append(name, text, ())

    def add_file(self, name: str) -> None:
        """Append a file of the method's folder, or of the engine's shared shaders."""
        self._append(*self._read(name), (name,))

    def _read(self, name: str) -> tuple[str, str]:
        if self.folder is not None and (self.folder / name).is_file():
            path = self.folder / name
            return str(path), path.read_text(encoding="utf-8")
        shared = files("oitbench.gl") / "shaders" / name
        if not shared.is_file():
            where = self.folder or "oitbench/gl/shaders"
            raise DeclarationError(f"{where}: there is no shader '{name}'")
        return f"oitbench/gl/shaders/{name}", shared.read_text(encoding="utf-8")

    def _append(self, name: str, text: str, open_files: Sequence[str]) -> None:
        for index, line in enumerate(text.splitlines(), start=1):
            include = _INCLUDE.match(line)
            if include is None:
                self.lines.append(line)
                self.places.append((name, index))
                continue
            if include[1] in open_files:
                raise DeclarationError(f"{name}:{index}: '{include[1]}' includes itself")
            self._append(*self._read(include[1]), (*open_files, include[1]))

    @property
    def text(self) -> str:
        """The whole source, from `#version` on."""
        return "\n".join([*self._head, *self.lines, ""])

    @property
    def _head(self) -> list[str]:
        return [_VERSION, *(f"#extension {name} : require" for name in self.extensions)]

    def explain(self, log: str) -> str:
        """Turn a compiler's log into one line that begins with the culprit's file and line."""
        for pattern in _MESSAGES:
            match = pattern.search(log)
            if match is None:
                continue
            # Drivers count lines from one, and the head comes before any file.
            index = int(match["line"]) - 1 - len(self._head)
            if 0 <= index < len(self.places):
                name, line = self.places[index]
                return f"{name}:{line}: {match['text'].strip()}"
        kept = [line for line in log.splitlines() if line.strip(" =-")]
        return " ".join([self.places[-1][0] + ":", *kept[:6]])
