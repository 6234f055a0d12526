"""Branches of the preprocessor in GLSL: those that exist in files, and those that sources reach.

A branch is the part of a file after `#if`, `#ifdef`, `#ifndef`, `#elif` or `#else`, named by file
and line. It is reached if its condition holds in a source that is compiled.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from unittest.mock import patch

from oitbench.gl.program.source import Source

Place = tuple[str, int]
"""File, relative to the repository, and line from one."""
_DIRECTIVE = re.compile(r"^\s*#\s*(if|ifdef|ifndef|elif|else|endif|define)\b\s*(.*?)\s*(?://.*)?$")
_OPENING = ("if", "ifdef", "ifndef", "elif", "else")


@contextmanager
def recorded() -> Iterator[dict[str, tuple[Place, ...]]]:
    """Yield the places of the lines of all sources that are assembled inside, by their text."""
    found: dict[str, tuple[Place, ...]] = {}
    original = Source.text

    def text(self: Source) -> str:
        result: str = original.__get__(self)
        head = result.count("\n") - len(self.lines)
        found[result] = (*[("", 0)] * head, *self.places)
        return result

    with patch.object(Source, "text", property(text)):
        yield found


def branches(root: Path, files: Iterable[Path]) -> set[Place]:
    """Return all branches in the files."""
    found = set()
    for path in files:
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
            match = _DIRECTIVE.match(line)
            if match and match[1] in _OPENING:
                found.add((path.relative_to(root).as_posix(), number))
    return found


def reached(text: str, places: Sequence[Place]) -> Iterator[Place]:
    """Yield the branches of a source whose conditions hold."""
    macros: dict[str, str] = {}
    # Of each open conditional: whether the enclosing code, this branch, and any so far is active.
    open_: list[tuple[bool, bool, bool]] = []
    for line, place in zip(text.splitlines(), places, strict=False):
        match = _DIRECTIVE.match(line)
        if match is None:
            continue
        kind, rest = match[1], match[2]
        active = all(item[1] for item in open_)
        if kind == "define":
            name, _, value = rest.partition(" ")
            if active and "(" not in name:
                macros[name] = value.strip()
            continue
        if kind == "endif":
            open_.pop()
            continue
        if kind in ("if", "ifdef", "ifndef"):
            condition = {"ifdef": f"defined({rest})", "ifndef": f"!defined({rest})"}.get(kind, rest)
            taken = active and _holds(condition, macros)
            open_.append((active, taken, taken))
        else:
            outer, _, before = open_.pop()
            taken = outer and not before and (kind == "else" or _holds(rest, macros))
            open_.append((outer, taken, before or taken))
        if taken:
            yield place


def _holds(condition: str, macros: dict[str, str]) -> bool:
    """Return the truth of a condition of integers, comparisons, `defined`, `!`, `&&` and `||`."""
    text = re.sub(
        r"defined\s*\(?\s*(\w+)\s*\)?", lambda match: str(int(match[1] in macros)), condition
    )
    while names := re.findall(r"\b[A-Za-z_]\w*", text):
        for name in names:
            text = re.sub(rf"\b{name}\b", macros.get(name) or "0", text)
    text = text.replace("&&", " and ").replace("||", " or ")
    return bool(eval(re.sub(r"!(?!=)", " not ", text), {"__builtins__": {}}))
