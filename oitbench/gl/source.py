"""GLSL sources: lookup, includes, and compiler messages that name the plugin's own file and line."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path

from oitbench.errors import DeclarationError

_INCLUDE = re.compile(r'^\s*#include\s+"([^"]+)"\s*$')
# Mesa writes "3:14(7): error: …", NVIDIA "3(14) : error …", Intel and AMD "ERROR: 3:14: …".
_MESSAGES = (
    re.compile(r"^\s*(?P<file>\d+):(?P<line>\d+)\(\d+\):\s*(?P<text>error.*)$", re.M),
    re.compile(r"^\s*(?P<file>\d+)\((?P<line>\d+)\)\s*:\s*(?P<text>error.*)$", re.M),
    re.compile(r"^\s*ERROR:\s*(?P<file>\d+):(?P<line>\d+):\s*(?P<text>.*)$", re.M),
)


@dataclass
class Source:
    """A shader under assembly; each file keeps its number for `#line`, so errors can be placed."""

    folder: Path | None
    lines: list[str] = field(default_factory=list)
    names: list[str] = field(default_factory=list)

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
        shared = files("oitbench") / "glsl" / name
        if not shared.is_file():
            where = self.folder or "oitbench/glsl"
            raise DeclarationError(f"{where}: there is no shader '{name}'")
        return f"oitbench/glsl/{name}", shared.read_text(encoding="utf-8")

    def _append(self, name: str, text: str, open_files: Sequence[str]) -> None:
        number = len(self.names)
        self.names.append(name)
        self.lines.append(f"#line 1 {number}")
        for index, line in enumerate(text.splitlines(), start=1):
            include = _INCLUDE.match(line)
            if include is None:
                self.lines.append(line)
                continue
            if include[1] in open_files:
                raise DeclarationError(f"{name}:{index}: '{include[1]}' includes itself")
            self._append(*self._read(include[1]), (*open_files, include[1]))
            self.lines.append(f"#line {index + 1} {number}")

    @property
    def text(self) -> str:
        """The whole source, from `#version` on."""
        return "\n".join(["#version 450 core", *self.lines, ""])

    def explain(self, log: str) -> str:
        """Turn a compiler's log into one line that begins with the culprit's file and line."""
        for pattern in _MESSAGES:
            match = pattern.search(log)
            if match is not None and int(match["file"]) < len(self.names):
                return f"{self.names[int(match['file'])]}:{match['line']}: {match['text'].strip()}"
        kept = [line for line in log.splitlines() if line.strip(" =-")]
        return " ".join([self.names[-1] + ":", *kept[:6]])
