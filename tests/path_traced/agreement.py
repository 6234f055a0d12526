"""Comparison of noisy images with closed forms."""

from __future__ import annotations

import importlib.util

import numpy as np
import numpy.typing as npt
import pytest

from oitbench.path_traced.trace.sections import Estimate

needs_mitsuba = pytest.mark.skipif(
    importlib.util.find_spec("mitsuba") is None, reason="Mitsuba is not installed"
)


def assert_mean(estimate: Estimate, expected: npt.ArrayLike) -> None:
    """Compare the mean of all pixels with `expected`, within six of its standard errors."""
    error = np.sqrt(estimate.variance.mean(axis=(0, 1)) / estimate.mean[..., 0].size)
    deviation = np.abs(estimate.mean.mean(axis=(0, 1)) - expected)
    assert (error < 0.02 * np.max(expected)).all()
    assert (deviation < 6 * error + 1e-5).all(), (deviation, error)
