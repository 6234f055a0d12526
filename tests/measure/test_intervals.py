"""Order-statistic intervals of medians."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.measure.intervals import COVERAGE, LEAST_SAMPLES, interval


@pytest.mark.parametrize(
    ("count", "place", "coverage"),
    # 1 − 2 Σ_{i<j} C(n, i) / 2^n for the j-th smallest and the j-th largest of n samples.
    [(6, 1, 1 - 2 / 64), (8, 1, 1 - 2 / 256), (9, 2, 1 - 20 / 512), (15, 4, 1 - 1152 / 2**15)],
)
def test_the_ends_are_samples_with_a_known_coverage(
    count: int, place: int, coverage: float
) -> None:
    samples = np.random.default_rng(count).permutation(np.arange(1.0, count + 1)).tolist()
    found = interval(samples)
    assert (found.low, found.high) == (place, count + 1 - place)
    assert found.coverage == pytest.approx(coverage, abs=1e-12)
    assert found.median == (count + 1) / 2
    assert found.samples == samples


@pytest.mark.parametrize("count", range(1, LEAST_SAMPLES))
def test_few_samples_have_a_median_and_no_interval(count: int) -> None:
    found = interval([float(number) for number in range(count)])
    assert found.median == (count - 1) / 2
    assert found.ends is None
    assert found.coverage is None


def test_the_interval_holds_the_true_median_as_often_as_it_says() -> None:
    # The exponential distribution is far from symmetric; its median is ln 2.
    generator = np.random.default_rng(7)
    found = [interval(generator.exponential(size=9).tolist()) for _ in range(2000)]
    hits = [one.low is not None and one.low <= np.log(2) <= (one.high or 0) for one in found]
    # Four standard errors of the share of 2000 trials.
    error = 4 * (0.961 * 0.039 / 2000) ** 0.5
    assert np.mean(hits) == pytest.approx(1 - 20 / 512, abs=error)
    assert np.mean(hits) > COVERAGE - error


def test_an_outlier_changes_neither_the_median_nor_the_interval() -> None:
    calm, wild = interval([1.0, *[2.0] * 7, 3.0]), interval([1.0, *[2.0] * 7, 900.0])
    assert calm.median == wild.median == 2.0
    assert calm.ends == wild.ends == (2.0, 2.0)
