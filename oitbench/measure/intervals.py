"""Medians with intervals that assume nothing about the distribution of the samples."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from oitbench.results.times import Interval

COVERAGE = 0.95
"""Least probability that an interval holds the true median."""
LEAST_SAMPLES = 6
"""Samples below which not even the smallest and the largest enclose the median with `COVERAGE`."""


def interval(samples: Sequence[float]) -> Interval:
    """Return the median of independent samples, its interval, and the samples.

    The interval runs from the j-th smallest to the j-th largest sample. Each sample lies below the
    true median with probability 1/2, so the number of those that do is binomial, and the interval
    misses the true median only if fewer than j samples lie on one of its sides. The largest j that
    reaches `COVERAGE` is chosen (David & Nagaraja 2003, Order Statistics, section 7.1).

    Parameters
    ----------
    samples : sequence of float
        At least one.
    """
    from scipy import stats

    ordered = np.sort(np.asarray(samples, dtype=np.float64))
    count = len(ordered)
    low = high = coverage = None
    j = int(stats.binom.ppf((1 - COVERAGE) / 2, count, 0.5))
    if j >= 1:
        low, high = float(ordered[j - 1]), float(ordered[count - j])
        coverage = float(1 - 2 * stats.binom.cdf(j - 1, count, 0.5))
    return Interval(float(np.median(ordered)), low, high, coverage, list(map(float, samples)))
