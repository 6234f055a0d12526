"""Flicker and popping of made-up changes."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.image.files import Image
from oitbench.motion import metrics
from oitbench.motion.metrics import BLOCK, VISIBLE

SIDE = 4 * BLOCK
ALL = np.ones((SIDE, SIDE), bool)


def nothing() -> Image:
    return np.zeros((SIDE, SIDE, 3), np.float32)


def test_flicker_is_the_mean_change_of_transparent_pixels() -> None:
    excess = nothing()
    excess[0, :2] = [[0.3, -0.3, 0.0], [0.1, 0.1, 0.1]]
    pixels = np.zeros((SIDE, SIDE), bool)
    pixels[0, :4] = True
    found = metrics.flicker(excess, pixels)
    assert found.mean == pytest.approx((0.2 + 0.1) / 4)
    assert found.largest == pytest.approx(0.2)
    assert metrics.flicker(excess, ~ALL) == metrics.Flicker(0, 0, 0)


def test_a_block_that_jumps_as_a_whole_counts_in_full() -> None:
    change = nothing()
    change[BLOCK : 2 * BLOCK, :BLOCK, 1] = -0.25
    found = metrics.jumps(change)
    assert found.shape == (4, 4)
    assert found[1, 0] == pytest.approx(0.25)
    assert np.count_nonzero(found) == 1
    assert metrics.jump(metrics.in_block(change, (1, 0))) == pytest.approx(0.25)


def test_noise_and_edges_are_no_jumps() -> None:
    random = np.random.default_rng(1)
    noise = random.normal(0, 0.2, (SIDE, SIDE, 3)).astype(np.float32)
    assert metrics.jumps(noise).max() == 0
    edge = nothing()
    edge[:, 3] = 0.8  # a column of each block
    assert metrics.jumps(edge).max() == 0
    half = nothing()
    half[:, : BLOCK // 2] = 0.4
    assert metrics.jumps(half).max() > 0.05


def test_blocks_at_the_edge_may_be_smaller() -> None:
    change = np.full((BLOCK + 3, 2 * BLOCK + 1, 3), 0.5, np.float32)
    mean, error = metrics.blocks(change)
    assert mean.shape == (2, 3, 3)
    np.testing.assert_allclose(mean, 0.5)
    np.testing.assert_allclose(error, 0, atol=1e-7)


def test_isolated_jumps_come_before_steady_motion() -> None:
    steady = np.array([[0.5, 0.0]])
    pop = np.array([[0.5, 0.1]])
    found = list(metrics.isolated([steady, steady, pop, steady]))
    assert found[0] == (2, (0, 1))
    # Larger, but as large as before and after.
    assert (1, (0, 0)) not in found
    assert list(metrics.isolated([steady])) == [(0, (0, 0))]
    assert list(metrics.isolated([0 * steady, 0 * steady])) == []


def test_a_step_of_the_display_is_visible() -> None:
    assert pytest.approx(1 / 255) == VISIBLE
    assert metrics.mean([]) == 0
