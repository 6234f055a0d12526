"""The rectangle around marked blocks."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.gl.tiling import Scissor, rectangle

FRAME: Scissor = (0, 0, 40, 20)


@pytest.mark.parametrize(
    ("blocks", "scissor", "expected"),
    [
        ([], FRAME, None),
        ([(0, 0)], FRAME, (0, 0, 16, 16)),
        ([(1, 2)], FRAME, (32, 16, 8, 4)),
        ([(0, 1), (1, 0)], FRAME, (0, 0, 32, 20)),
        ([(0, 1)], (20, 4, 20, 16), (20, 4, 12, 12)),
        ([(0, 0)], (20, 4, 20, 16), (20, 4, 0, 12)),
    ],
)
def test_a_rectangle_surrounds_all_marked_blocks_within_the_scissor(
    blocks: list[tuple[int, int]], scissor: Scissor, expected: Scissor | None
) -> None:
    marked = np.zeros((2, 3), bool)
    for row, column in blocks:
        marked[row, column] = True
    assert rectangle(marked, 16, scissor) == expected
