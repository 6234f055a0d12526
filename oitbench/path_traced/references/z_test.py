"""A z-test for each pixel of whether two renderings estimate the same image."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from oitbench.image.files import Image

SIGNIFICANCE = 0.01
REQUIRED_FRACTION = 0.9975
"""Fraction of the pixels that must pass, as in Mitsuba's own rendering tests."""

_HALF_RELATIVE = 2.0**-11
"""Relative error of the stored mean, which is rounded to half floats."""
_ABSOLUTE = 1e-5
"""Absolute error of the new rendering, which is traced in float32."""


@dataclass(frozen=True, eq=False)
class ZTest:
    """The outcome of a z-test.

    Parameters
    ----------
    passed : bool
    fraction : float
        Fraction of the pixels that pass.
    p_value : array, shape (h, w), float32
        The smallest p-value of the three channels of each pixel.
    """

    passed: bool
    fraction: float
    p_value: npt.NDArray[np.float32]


def z_test(mean: Image, reference: Image, variance: npt.ArrayLike) -> ZTest:
    """Test the hypothesis that two images have the same expectation.

    Parameters
    ----------
    mean, reference : array, shape (h, w, 3)
        The new rendering and the stored one.
    variance : array, shape (h, w, 3)
        Variance of their difference: the sum of the variances of both means.

    Returns
    -------
    ZTest
        It is passed if 99.75 % of the pixels pass at a significance level of 0.01, with Šidák's
        correction for the number of pixels and channels.

    References
    ----------
    `test_renders.py` of Mitsuba, after Subr & Arvo 2007, "Statistical Hypothesis Testing for
    Assessing Monte Carlo Estimators".
    """
    truth = reference.astype(np.float64)
    rounding = _HALF_RELATIVE * np.abs(truth) + _ABSOLUTE
    deviation = np.sqrt(np.asarray(variance, dtype=np.float64) + rounding**2)
    z = np.abs(mean.astype(np.float64) - truth) / deviation
    p_values = np.array([math.erfc(value / math.sqrt(2)) for value in z.ravel()]).reshape(z.shape)
    # 1 − (1 − a)^(1/n), computed without cancellation.
    level = -math.expm1(math.log1p(-SIGNIFICANCE) / z.size)
    lowest = p_values.min(axis=-1)
    fraction = float((lowest > level).mean())
    return ZTest(fraction >= REQUIRED_FRACTION, fraction, lowest.astype(np.float32))
