"""Checks of the values in a scene. Their messages name the owner and the field."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from oitbench.errors import SceneError


def require(condition: bool, message: str) -> None:
    """Raise `SceneError` with `message` unless `condition` holds."""
    if not condition:
        raise SceneError(message)


def require_finite(owner: str, **values: npt.ArrayLike | None) -> None:
    """Raise `SceneError` if one of `values` contains NaN or infinity; None is skipped.

    Parameters
    ----------
    owner : str
        The object that the values belong to, as in "camera".
    **values : array_like or None
        The values by the names of their fields.
    """
    for name, value in values.items():
        if value is not None and not np.isfinite(np.asarray(value, dtype=np.float64)).all():
            raise SceneError(f"{owner}: {name} holds NaN or infinity; every value must be finite")
