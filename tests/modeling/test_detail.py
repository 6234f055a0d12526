"""The size of meshes follows the parameter detail."""

from __future__ import annotations

from oitbench.modeling.detail import copies, divisions, enlargement


def test_divisions_make_triangles_proportional_to_detail() -> None:
    assert divisions(16, 1.0) == 16
    assert divisions(16, 4.0) == 32
    assert divisions(16, 0.0, least=3) == 3


def test_fewer_copies_are_larger_so_that_their_area_stays() -> None:
    count = copies(1000, 0.25)
    assert count == 250
    assert count * enlargement(1000, count) ** 2 == 1000
    assert copies(1000, 0) > 0
    assert enlargement(1000, 2000) == 1
