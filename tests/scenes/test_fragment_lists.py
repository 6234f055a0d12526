"""Fragment lists: distances, coverage and colors follow the promised distributions."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.errors import UsageError
from oitbench.scene import FragmentLists
from tests.scenes.helpers import build


def lists_of(text: str) -> FragmentLists:
    lists = build(f"fragment_lists[{text}]").lists
    assert lists is not None
    return lists


def test_lists_are_distinct_unsorted_and_in_range() -> None:
    lists = lists_of("width=32,height=16,layers=12,alpha_low=0.2,alpha_high=0.4")
    assert lists.z.shape == (12, 16, 32)
    assert 0.5 <= lists.z.min() < 0.6
    assert 19.5 < lists.z.max() <= 20
    assert np.diff(np.sort(lists.z, axis=0), axis=0).min() > 5e-4
    ascending = (np.diff(lists.z, axis=0) > 0).mean()
    assert 0.45 < ascending < 0.55
    assert 0.2 <= lists.coverage.min() < 0.22
    assert 0.38 < lists.coverage.max() <= 0.4
    assert not lists.transmission.any()


def test_the_background_is_not_black() -> None:
    assert min(build("fragment_lists[detail=0.1]").background) > 0


def test_distances_are_uniform() -> None:
    lists = lists_of("layers=4")
    counts, _ = np.histogram(lists.z, bins=8, range=(0.5, 20))
    np.testing.assert_allclose(counts / lists.z.size, 1 / 8, atol=2e-3)


def test_ties_tints_and_high_dynamic_range_are_options() -> None:
    lists = lists_of("width=32,height=32,layers=8,ties=true,tinted=true,hdr=true")
    assert all(len(np.unique(lists.z[:, row, 0])) < 8 for row in range(32))
    assert 0.4 < lists.transmission.mean() < 0.6
    assert lists.transmission.max() < 1
    assert 0.01 <= lists.radiance.min() < 0.02
    assert 50 < lists.radiance.max() <= 100
    assert 0.8 < np.median(lists.radiance) < 1.25


def test_distances_of_long_lists_differ() -> None:
    lists = lists_of("width=16,height=16,layers=700")
    assert np.diff(np.sort(lists.z, axis=0), axis=0).min() > 0
    assert lists.z.max() <= 20


def test_detail_scales_the_number_of_lists() -> None:
    assert lists_of("detail=0.25").z.shape == (8, 128, 128)


def test_a_least_coverage_above_the_greatest_is_refused() -> None:
    with pytest.raises(UsageError, match=r"alpha_low is 0\.9; .* alpha_high = 0\.1"):
        build("fragment_lists[alpha_low=0.9,alpha_high=0.1]")
