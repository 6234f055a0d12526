"""The search for the parameters of a method with the smallest error, in a box."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from oitbench.errors import UsageError
from oitbench.parameters import AnyParameter, Value

_DIGITS = 3
"""Significant digits of a value, so that labels stay short and name exactly what was rendered."""
_FIRST_STEP = 0.15
"""Side of the first simplex, relative to the box."""
_TOLERANCE = 0.01
"""The search ends when the simplex is this small, relative to the box."""


@dataclass(frozen=True)
class Axis:
    """A parameter to be fitted, between its bounds.

    If both bounds are positive, equal steps are equal ratios.
    """

    name: str
    low: float
    high: float

    def value(self, place: float) -> float:
        """Return the value at a place in [0, 1], rounded to three digits."""
        if self.low > 0:
            exact = self.low * (self.high / self.low) ** place
        else:
            exact = self.low + (self.high - self.low) * place
        return min(max(float(f"{exact:.{_DIGITS}g}"), self.low), self.high)

    def place(self, value: float) -> float:
        """Return the place of a value in [0, 1]."""
        if self.low > 0:
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)


def free_axes(
    method: str, parameters: Mapping[str, AnyParameter], fixed: Collection[str]
) -> tuple[Axis, ...]:
    """Return the parameters to be fitted: decimal numbers with two bounds that are not `fixed`.

    Parameters
    ----------
    method : str
        Name in error messages.
    parameters : mapping of str to Parameter
    fixed : collection of str
        Names of those that the user has set.

    Raises
    ------
    UsageError
        There is none.
    """
    found = tuple(
        Axis(name, item.low, item.high)
        for name, item in parameters.items()
        if isinstance(item.default, float) and item.low is not None and item.high is not None
        if name not in fixed
    )
    if not found:
        raise UsageError(
            f"{method} has no parameter to fit; fit decimal numbers with a low and a high bound"
        )
    return found


def minimize(
    axes: Sequence[Axis],
    start: Mapping[str, Value],
    error: Callable[[Mapping[str, float]], float],
    evaluations: int,
) -> dict[str, float]:
    """Return the values with the smallest error that the simplex search of Nelder and Mead finds.

    The search starts at `start`, which is among the candidates: the result is never worse.

    Parameters
    ----------
    axes : sequence of Axis
    start : mapping of str to float
        Values of at least all axes.
    error : callable
        Called once for each set of values that differ when they are rounded.
    evaluations : int
        Largest number of errors that are computed.
    """
    from scipy import optimize

    found: dict[tuple[float, ...], float] = {}

    def at(places: npt.NDArray[np.float64]) -> float:
        values = tuple(axis.value(float(p)) for axis, p in zip(axes, places, strict=True))
        if values not in found:
            found[values] = error(dict(zip((axis.name for axis in axes), values, strict=True)))
        return found[values]

    first = np.array([axis.place(float(start[axis.name])) for axis in axes])
    inward = np.where(first < 0.5, _FIRST_STEP, -_FIRST_STEP)
    optimize.minimize(
        at,
        first,
        method="Nelder-Mead",
        bounds=[(0, 1)] * len(axes),
        options={
            "initial_simplex": np.vstack([first, first + np.diag(inward)]),
            "maxfev": evaluations,
            "xatol": _TOLERANCE,
            "fatol": 0.0,
        },
    )
    best = min(found, key=lambda values: found[values])
    return dict(zip((axis.name for axis in axes), best, strict=True))
