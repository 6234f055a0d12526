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


def test_distances_fill_their_range() -> None:
    lists = lists_of("width=64,height=64,nearest=3,farthest=4")
    assert 3 <= lists.z.min() < 3.01
    assert 3.99 < lists.z.max() <= 4
    tied = lists_of("width=64,height=64,nearest=3,farthest=4,ties=true")
    assert sorted({*tied.z.flat}) == pytest.approx([3, 10 / 3, 11 / 3, 4])


def test_layers_of_glass_have_one_of_three_coverages() -> None:
    lists = lists_of("width=64,height=64,family=glass,alpha_low=0.1,alpha_high=0.9")
    values, counts = np.unique(lists.coverage, return_counts=True)
    np.testing.assert_allclose(values, [0.1, 0.3, 0.9], rtol=1e-6)
    np.testing.assert_allclose(counts / lists.coverage.size, 1 / 3, atol=0.02)


def test_two_strong_layers_stand_behind_a_tuft_in_any_order() -> None:
    text = "width=32,height=32,layers=12,family=tuft,alpha_low=0.2,alpha_high=0.5"
    lists = lists_of(f"{text},nearest=5,farthest=30")
    strong = lists.coverage > 0.3
    assert (strong.sum(axis=0) == 2).all()
    np.testing.assert_allclose(lists.coverage[~strong], 0.2, rtol=1e-6)
    assert lists.z[~strong].min() >= 5
    assert lists.z[~strong].max() <= 6
    assert lists.z[strong].min() > 6
    assert strong.any(axis=(1, 2)).all()
    assert np.diff(np.sort(lists.z, axis=0), axis=0).min() > 5e-4


def test_the_default_lists_stay_the_same() -> None:
    lists = lists_of("width=2,height=2,layers=2")
    z = [1.179589, 10.4810095, 16.5475769, 18.997715, 9.727706, 3.3109672, 15.2250109, 19.03409]
    coverage = [0.2958524, 0.7949323, 0.2812928, 0.4182792, 0.6294461, 0.5446343, 0.1271653, 0.0748]
    np.testing.assert_allclose(lists.z.ravel(), z, rtol=1e-6)
    np.testing.assert_allclose(lists.coverage.ravel(), coverage, rtol=1e-4)


@pytest.mark.parametrize(
    ("text", "culprit"),
    [
        ("nearest=5,farthest=5.05", r"farthest is 5\.05 m; it must exceed nearest = 5 m by 0\.1 m"),
        ("ties=true,family=tuft", "a tuft has no tied distances"),
    ],
)
def test_impossible_lists_are_refused(text: str, culprit: str) -> None:
    with pytest.raises(UsageError, match=culprit):
        build(f"fragment_lists[{text}]")
