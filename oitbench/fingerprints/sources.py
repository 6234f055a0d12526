"""Digests of source files, with neither comments nor docstrings: prose changes no result."""

from __future__ import annotations

import ast
import hashlib
import re
from collections.abc import Mapping
from pathlib import Path

_GLSL_COMMENT = re.compile(r"//(?:\\\n|[^\n])*|/\*.*?\*/", re.DOTALL)


def sources_digest(files: Mapping[str, Path]) -> str:
    """Return a digest of files by name: 32 hexadecimal digits.

    Parameters
    ----------
    files : mapping of str to Path
        Names matter, the folders of the paths do not.
    """
    digest = hashlib.sha256()
    for name, path in sorted(files.items()):
        for part in (name.encode("utf-8", "surrogatepass"), _content(path)):
            digest.update(f"{len(part)}:".encode())
            digest.update(part)
    return digest.hexdigest()[:32]


def _content(path: Path) -> bytes:
    content = path.read_bytes()
    strip = {".py": python_code, ".glsl": glsl_code}.get(path.suffix)
    if strip is None:
        return content
    try:
        return strip(content.decode("utf-8")).encode()
    except (ValueError, SyntaxError, RecursionError):
        return content  # A file that cannot be parsed still has a digest.


def python_code(text: str) -> str:
    """Return a form of Python source that only depends on what the interpreter does with it.

    Every version of Python returns the same: fields that are empty do not appear, as further
    versions have added some.

    Raises
    ------
    SyntaxError
    """
    try:
        tree = ast.parse(text)
    except SystemError:
        # Python 3.11 counts the depth of the tree wrongly if another thread parses meanwhile.
        tree = ast.parse(text)
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            node.body = [item for item in body if not _is_text(item)]  # type: ignore[attr-defined]
    return _form(tree)


def _form(value: object) -> str:
    """Return a syntax tree, or one of its values, as text."""
    if isinstance(value, list):
        return f"[{','.join(map(_form, value))}]"
    if not isinstance(value, ast.AST):
        return repr(value)
    fields = ((name, item) for name, item in ast.iter_fields(value) if item not in (None, []))
    parts = ",".join(f"{name}={_form(item)}" for name, item in fields)
    return f"{type(value).__name__}({parts})"


def _is_text(node: ast.AST) -> bool:
    """Return whether a statement is a docstring or another string that stands for itself."""
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )


def glsl_code(text: str) -> str:
    """Return GLSL source without comments, blank lines, indentation and repeated blanks."""
    lines = _GLSL_COMMENT.sub(" ", text).splitlines()
    return "\n".join(filter(None, (" ".join(line.split()) for line in lines)))
