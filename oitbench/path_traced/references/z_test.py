"""Is a new rendering an estimate of the same picture? A z-test for each pixel."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from oitbench.image.files import Image

SIGNIFICANCE = 0.01
REQUIRED_FRACTION = 0.9975
"""Of the pixels: what Mitsuba's own rendering tests ask for."""

_HALF_RELATIVE = 2.0**-11
_ABSOLUTE = 1e-5
"""Errors that are no noise: rounding to half floats when stored, to float32 when traced."""


@dataclass(frozen=True, eq=False)
class ZTest:
    """The outcome of a z-test.

    Parameters
    ----------
    passed : bool
    fraction : float
        Share of the pixels that pass.
    p_value : array, shape (h, w), float32
        The least of a pixel's three channels.
    """

    passed: bool
    fraction: float
    p_value: npt.NDArray[np.float32]


def z_test(mean: Image, reference: Image, variance: npt.ArrayLike) -> ZTest:
    """Test the hypothesis that two images have one expectation.

    Parameters
    ----------
    mean, reference : array, shape (h, w, 3)
        The new rendering and the stored one.
    variance : array, shape (h, w, 3)
        Of their difference: the sum of the variances of both means.

    Returns
    -------
    ZTest
        Passed if 99.75 % of the pixels do, at a level of 0.01 with Šidák's correction for the
        number of pixels and channels.

    Notes
    -----
    As in Mitsuba's `test_renders.py`; after Subr & Arvo 2007, "Statistical Hypothesis Testing for
    Assessing Monte Carlo Estimators".
    """
    truth = reference.astype(np.float64)
    rounding = _HALF_RELATIVE * np.abs(truth) + _ABSOLUTE
    deviation = np.sqrt(np.asarray(variance, dtype=np.float64) + rounding**2)
    z = np.abs(mean.astype(np.float64) - truth) / deviation
    p_values = np.array([math.erfc(value / math.sqrt(2)) for value in z.ravel()]).reshape(z.shape)
    # 1 − (1 − a)^(1/n), without losing it in a rounding.
    level = -math.expm1(math.log1p(-SIGNIFICANCE) / z.size)
    lowest = p_values.min(axis=-1)
    fraction = float((lowest > level).mean())
    return ZTest(fraction >= REQUIRED_FRACTION, fraction, lowest.astype(np.float32))
