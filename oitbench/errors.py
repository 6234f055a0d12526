"""Errors for users: each message is one line that names the culprit and the fix."""

from __future__ import annotations

import difflib
import traceback
from collections.abc import Iterable
from pathlib import Path


def printable(text: str) -> str:
    """Return `text` as one line that every terminal and every UTF-8 file can hold.

    Line breaks become blanks. Control characters, and bytes of file names that are not UTF-8,
    become escapes.
    """
    kept = (c if c.isprintable() else " " if c.isspace() else ascii(c)[1:-1] for c in text)
    return "".join(kept)


class OitbenchError(Exception):
    """Base of all errors that a user can fix; the command line prints it and exits with 2."""

    def __init__(self, message: str) -> None:
        super().__init__(printable(message))


class UsageError(OitbenchError):
    """A name, value, size or folder is wrong."""


class StorageError(UsageError):
    """A file cannot be written, as on a full disk; it ends a run, since it is no cell's fault."""


class SceneError(OitbenchError):
    """A scene describes something that cannot be rendered."""


class DeclarationError(OitbenchError):
    """A method's declaration is inconsistent, or its shader does not compile."""


class CapabilityError(OitbenchError):
    """The machine's OpenGL or Mitsuba lacks a required capability; the cell is skipped."""


def unknown(kind: str, name: str, known: Iterable[str]) -> UsageError:
    """Return the error for a wrong name, with the nearest known names.

    Parameters
    ----------
    kind : str
        Kind of the name, as in "method".
    name : str
        The wrong name.
    known : iterable of str
        All valid names.
    """
    names = sorted(known)
    near = difflib.get_close_matches(name, names, n=2, cutoff=0.5)
    hint = f"did you mean {' or '.join(near)}?" if near else f"known: {', '.join(names) or 'none'}"
    return UsageError(f"unknown {kind} '{name}'; {hint}")


def locate(error: BaseException, file: Path | None = None) -> str:
    """Return a plugin's error as one line: file, line, kind, message and near names.

    Parameters
    ----------
    error : BaseException
        Raised by code of `file`, or by code that it called.
    file : Path, optional
        Default: the file in which it was raised.
    """
    frames = traceback.extract_tb(error.__traceback__)
    if isinstance(error, SyntaxError):
        source = f": {error.text.strip()}" if error.text else ""
        return f"{file or error.filename}:{error.lineno}: SyntaxError: {error.msg}{source}"
    name = str(file) if file is not None else frames[-1].filename
    lines = [frame.lineno for frame in frames if frame.filename == name]
    place = f"{name}:{lines[-1]}" if lines else name
    text = str(error) if isinstance(error, OitbenchError) else f"{type(error).__name__}: {error}"
    known: Iterable[str] = ()
    if isinstance(error, AttributeError) and error.obj is not None:
        known = dir(error.obj)
    wrong = getattr(error, "name", None)
    near = difflib.get_close_matches(wrong, known, n=1) if wrong else []
    hint = f"; did you mean {near[0]}?" if near else ""
    return f"{place}: {' '.join(text.split())}{hint}"
