"""Checks of the values in a scene. Their messages name the owner and the field."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from oitbench.errors import SceneError

LARGEST = float(np.finfo(np.float32).max)
"""The largest number in single precision, in which the renderers compute."""


def require(condition: bool, message: str) -> None:
    """Raise `SceneError` with `message` unless `condition` holds."""
    if not condition:
        raise SceneError(message)


def require_finite(owner: str, **values: npt.ArrayLike | None) -> None:
    """Raise `SceneError` if one of `values` contains NaN, infinity or a number above `LARGEST`.

    Parameters
    ----------
    owner : str
        The object that the values belong to, as in "camera".
    **values : array_like or None
        The values by the names of their fields; None is skipped.
    """
    for name, value in values.items():
        if value is None:
            continue
        array = _floats(value)
        # A comparison with NaN is false.
        if not bool((np.abs(array) <= LARGEST).all()):
            broken = not np.isfinite(array).all()
            found = "NaN or infinity" if broken else f"a number beyond {LARGEST:.2g}"
            raise SceneError(f"{owner}: {name} holds {found}; every value must be finite")


def require_fractions(owner: str, **values: npt.ArrayLike) -> None:
    """Raise `SceneError` unless all of `values` lie in [0, 1]."""
    for name, value in values.items():
        array = _floats(value)
        inside = bool(((array >= 0) & (array <= 1)).all())
        require(inside, f"{owner}: {name} must lie in [0, 1]")


def require_light(owner: str, **values: npt.ArrayLike | None) -> None:
    """Raise `SceneError` unless all of `values` are finite amounts of light, 0 or more."""
    require_finite(owner, **values)
    for name, value in values.items():
        if value is not None:
            allowed = bool((_floats(value) >= 0).all())
            require(allowed, f"{owner}: {name} is negative; light is 0 or more")


def single_precision(owner: str, values: npt.ArrayLike) -> npt.NDArray[np.float32]:
    """Return computed `values` as renderers take them.

    Raises
    ------
    SceneError
        If a value is NaN, or does not fit in single precision.
    """
    array = np.asarray(values, dtype=np.float64)
    fits = bool((np.abs(array) <= LARGEST).all())
    require(fits, f"{owner} exceeds single precision; scale the scene, or move its parts closer")
    return array.astype(np.float32)


def _floats(value: npt.ArrayLike) -> npt.NDArray[np.floating]:
    array = np.asarray(value)
    return array if array.dtype.kind == "f" else array.astype(np.float64)
