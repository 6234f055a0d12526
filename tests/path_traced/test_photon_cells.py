"""The grid of cells in which photons are collected."""

from __future__ import annotations

import numpy as np

from oitbench.path_traced.photons.cells import BITS, WIDER, PhotonCells


def test_sparse_photons_are_collected_in_wide_cells_and_none_is_lost() -> None:
    middle = 1 << (BITS - 1)
    rng = np.random.default_rng(1)
    many = middle + rng.integers(0, WIDER, (3000, 2))  # all in one wide cell
    few = middle + 400 + rng.integers(0, 400, (3000, 2))
    fields = np.concatenate([many, few]).astype(np.uint64)
    power = rng.random((len(fields), 3))
    cells = PhotonCells()
    for part in (slice(0, 2000), slice(2000, None)):
        keys = (fields[part, 0] << np.uint64(2 * BITS)) | (fields[part, 1] << np.uint64(BITS))
        cells.add(keys | np.uint64(middle), power[part])
    keys, sums = cells.finish()
    assert (np.diff(keys.astype(object)) > 0).all()
    wide = keys >> np.uint64(3 * BITS + 3) == 1
    # Each photon counts twice, because cells overlap along the axis.
    np.testing.assert_allclose(sums[~wide].sum(axis=0), 2 * power[: len(many)].sum(axis=0))
    np.testing.assert_allclose(sums[wide].sum(axis=0), 2 * power[len(many) :].sum(axis=0))
