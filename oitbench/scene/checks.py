"""Checks of the values that scenes are made of: they name the owner and the field."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from oitbench.errors import SceneError


def require(condition: bool, message: str) -> None:
    """Raise `SceneError` with `message` unless `condition` holds."""
    if not condition:
        raise SceneError(message)


def require_finite(owner: str, **arrays: npt.ArrayLike | None) -> None:
    """Raise `SceneError` if one of `arrays` holds NaN or infinity."""
    for name, values in arrays.items():
        if values is not None and not np.isfinite(np.asarray(values, dtype=np.float64)).all():
            raise SceneError(f"{owner}: {name} holds NaN or infinity; every value must be finite")
