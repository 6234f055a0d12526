"""The fingerprint of a scene: a hash of all values that a picture of it depends on."""

from __future__ import annotations

import dataclasses
import hashlib
from typing import Any

import numpy as np

from oitbench.scene import Scene

_DECIMALS = 5
"""Floats are rounded to this, because processors differ in the last digits of sines."""


def fingerprint(scene: Scene) -> str:
    """Return the SHA-256 of all values of `scene` except its name, floats rounded to 5 decimals.

    The names of the scene's classes and fields enter the hash, too. Renaming one invalidates all
    stored references.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    str
        64 hexadecimal digits.
    """
    digest = hashlib.sha256()
    _feed(digest, dataclasses.replace(scene, name=""))
    return digest.hexdigest()


def _feed(digest: Any, value: Any) -> None:
    """Add `value` in an unambiguous form: each part is preceded by its type and its length."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        digest.update(f"<{type(value).__name__}".encode())
        for field in dataclasses.fields(value):
            if field.init:
                digest.update(f";{field.name}=".encode())
                _feed(digest, getattr(value, field.name))
        digest.update(b">")
    elif isinstance(value, tuple | list):
        digest.update(f"({len(value)}:".encode())
        for item in value:
            _feed(digest, item)
    elif isinstance(value, bool | str) or value is None:
        digest.update(f"{type(value).__name__}:{value!r};".encode())
    elif isinstance(value, int | float | np.generic | np.ndarray):
        array = np.asarray(value)
        if array.dtype.kind in "iub":
            digest.update(f"int{array.shape}:".encode())
            digest.update(array.astype("<i8").tobytes())
        else:
            # Adding zero turns −0 into 0.
            rounded = np.round(array.astype("<f8"), _DECIMALS) + 0.0
            digest.update(f"float{array.shape}:".encode())
            digest.update(rounded.tobytes())
    else:
        raise TypeError(f"{type(value).__name__} has no fingerprint")
