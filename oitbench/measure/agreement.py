"""The check that a timed picture is the picture that accuracy was measured with."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from oitbench.gl.frame import Image

_RENDERINGS = 4
"""Accurate renderings that show how far a picture differs from itself."""
_ALLOWED = 2.0
"""A timed picture may differ by this factor more than accurate ones differ from each other."""


def difference(timed: Image, render: Callable[[], Image]) -> str:
    """Return how a timed picture differs from accurate renderings of its frame, or "".

    Equal pictures are equal bit for bit. Where drivers run the fragments of a pixel in any order,
    accurate renderings differ from each other too; then that is the allowed difference.

    Parameters
    ----------
    timed : array, shape (h, w, 3)
    render : callable
        Renders the frame as it is scored.
    """
    accurate = [render()]
    if np.array_equal(timed, accurate[0], equal_nan=True):
        return ""
    accurate += [render() for _ in range(_RENDERINGS - 1)]
    spread = max(_rms(accurate[0], other) for other in accurate[1:])
    found = min(_rms(timed, one) for one in accurate)
    if found <= _ALLOWED * spread:
        return ""
    return f"the timed picture differs from the scored one by an RMSE of {found:.2g}"


def _rms(one: Image, other: Image) -> float:
    """Return the root mean square of the difference; infinite if only one of two is finite."""
    finite = np.isfinite(one)
    if not np.array_equal(finite, np.isfinite(other)):
        return float("inf")
    squares = np.square(one[finite].astype(np.float64) - other[finite])
    return float(np.sqrt(squares.mean())) if squares.size else 0.0
