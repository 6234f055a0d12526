"""Errors for users: each message is one line that names the culprit and the fix."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class OitbenchError(Exception):
    """Base of all errors that a user can fix; the command line prints it and exits with 2."""


class UsageError(OitbenchError):
    """A name, value, size or folder is wrong."""


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
