"""What can go wrong at the edge: each message is one line that names the culprit and the mend."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class OitbenchError(Exception):
    """Base of all errors that a user can mend; the command line prints it and exits with 2."""


class UsageError(OitbenchError):
    """A wrong name, value, size or folder was given."""


class SceneError(OitbenchError):
    """A scene describes something that cannot be rendered."""


class DeclarationError(OitbenchError):
    """A method's declaration is inconsistent, or its shader does not compile."""


class CapabilityError(OitbenchError):
    """The OpenGL or Mitsuba of this machine lacks what was asked for; the cell is skipped."""


def unknown(kind: str, name: str, known: Iterable[str]) -> UsageError:
    """Return the error for a wrong name, with the nearest known names.

    Parameters
    ----------
    kind : str
        What the name should have been, as in "method".
    name : str
        The name that was given.
    known : iterable of str
        All valid names.
    """
    names = sorted(known)
    near = difflib.get_close_matches(name, names, n=2, cutoff=0.5)
    hint = f"did you mean {' or '.join(near)}?" if near else f"known: {', '.join(names) or 'none'}"
    return UsageError(f"unknown {kind} '{name}'; {hint}")
