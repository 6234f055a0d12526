"""Names of views: of a scene's own camera, of the eyes of a stereo pair, and as part of labels."""

from __future__ import annotations

import re
from collections.abc import Iterable

from oitbench.errors import UsageError

MAIN = "main"
"""Name of the view of `Scene.camera`."""
EYES = ("left", "right")
"""Names of the views of a stereo pair."""
_NAME = re.compile(r"[a-z][a-z0-9_]*")


def is_name(text: str) -> bool:
    """Return whether `text` can name a view: small letters, digits and underscores."""
    return _NAME.fullmatch(text) is not None


def seen(scene: str, view: str) -> str:
    """Return the label of a scene with its view, as in `tumblers@above`; `scene` for the main one.

    Parameters
    ----------
    scene : str
        Canonical label.
    view : str
    """
    return scene if view == MAIN else f"{scene}@{view}"


def selection(scene: str, view: str) -> str:
    """Return the arguments of a command that select a scene and its view."""
    return scene if view == MAIN else f"{scene} --view {view}"


def parse(texts: Iterable[str]) -> tuple[str, ...]:
    """Return the views that `NAME[,NAME]` select, each once.

    Raises
    ------
    UsageError
        If a name is none.
    """
    names = [name.strip() for text in texts for name in text.split(",")]
    for name in names:
        if not is_name(name):
            raise UsageError(f"cannot read view '{name}'; write NAME or NAME,NAME")
    return tuple(dict.fromkeys(names))
