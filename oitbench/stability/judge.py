"""Compares the values of an expectation, within its bound."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from oitbench.method.declaration import Method
from oitbench.stability.check import Bound, Expectation, Values
from oitbench.stability.tolerance import rounding, tolerance

_SIGMAS = 4.0
"""Standard errors that the mean of a random method may be off."""
_DISPLAY_STEP = 1 / 255


@dataclass(frozen=True)
class Deviation:
    """The error of one expectation, and its bound.

    Parameters
    ----------
    error : float
        Largest absolute error of a pixel or, if `in_mean`, of the mean over the pixels.
    allowed : float
    expected, found : float
        The channel with that error: the value that is right, and the one that was measured.
    in_mean : bool
    """

    error: float
    allowed: float
    expected: float
    found: float
    in_mean: bool = False

    @property
    def holds(self) -> bool:
        """Whether the error is within its bound; false for NaN."""
        return self.error <= self.allowed

    @property
    def excess(self) -> float:
        """The error relative to its bound, to find the worst of several; infinite for NaN."""
        if not self.error:
            return 0.0
        ratio = self.error / self.allowed if self.allowed else math.inf
        return math.inf if math.isnan(ratio) else ratio


def judge(method: Method, expectation: Expectation) -> Deviation:
    """Return the error of an expectation and its bound.

    The error is the largest one of any pixel. For a method with random pixels it is the error of
    their mean instead, if a single pixel exceeds the bound.
    """
    bound = _bound(method, expectation) + expectation.slack
    found, expected = _values(expectation)
    residual = found - expected
    error = float(np.abs(residual).max())
    noise = _SIGMAS * expectation.noise
    if not method.noisy or error <= bound or expectation.noise or not np.isfinite(residual).all():
        worst = int(np.abs(residual).argmax())
        pair = float(expected.flat[worst]), float(found.flat[worst])
        return Deviation(error, bound + noise, *pair, in_mean=noise > 0)
    pixels = residual.reshape(-1, residual.shape[-1])
    mean, deviation = np.abs(pixels.mean(axis=0)), pixels.std(axis=0)
    limits = bound + _SIGMAS * deviation / math.sqrt(len(pixels))
    channel = int(np.argmax(mean - limits))
    pair = float(expected[..., channel].mean()), float(found[..., channel].mean())
    return Deviation(float(mean[channel]), float(limits[channel]), *pair, in_mean=True)


def _bound(method: Method, expectation: Expectation) -> float:
    if expectation.bound is Bound.EQUAL:
        return 0.0
    if expectation.bound is Bound.DISPLAY:
        return _DISPLAY_STEP * expectation.magnitude
    largest = rounding if expectation.bound is Bound.TARGETS else tolerance
    return largest(method, expectation.layers, expectation.magnitude)


def _values(expectation: Expectation) -> tuple[Values, Values]:
    """Return the values found and expected, the latter repeated to the shape of the former."""
    found, expected = (np.asarray(a, np.float64) for a in (expectation.found, expectation.expected))
    for axis in (0, 1):
        expected = np.repeat(expected, found.shape[axis] // expected.shape[axis], axis=axis)
    return found, expected
