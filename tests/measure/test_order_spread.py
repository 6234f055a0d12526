"""The spread of a picture over random orders of the draws."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from oitbench.image import metrics
from oitbench.matrix.bench import Bench
from oitbench.matrix.cell import Cell
from oitbench.matrix.plan import PRESETS, plan_matrix
from oitbench.plugins import Collection
from oitbench.truths import EXACT


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    with Bench(Collection.load(), tmp_path) as bench:
        yield bench


def spread(bench: Bench, method: str, permutations: int) -> tuple[float | None, float | None]:
    cell = Cell("layer_stack", method, (32, 24), ssaa=1, permutations=permutations, truths=(EXACT,))
    record = bench.run(cell)
    names = (metrics.ORDER_SPREAD_MAX, metrics.ORDER_SPREAD_MEAN)
    most, mean = (record.metric("exact", name) for name in names)
    return most, mean


def test_only_methods_that_depend_on_the_order_have_a_spread(bench: Bench) -> None:
    assert spread(bench, "a_buffer", 3) == (0.0, 0.0)
    assert spread(bench, "a_buffer", 0) == (None, None)
    few, many = spread(bench, "alpha_blend", 2), spread(bench, "alpha_blend", 6)
    assert few[0] is not None
    assert few[1] is not None
    assert many[0] is not None
    assert 0.01 < few[1] < few[0] <= many[0]


@pytest.mark.parametrize("preset", PRESETS)
def test_cells_have_the_number_of_orders_of_their_preset(preset: str) -> None:
    cells = plan_matrix(["layer_stack"], ["a_buffer"], preset).cells
    assert {cell.permutations for cell in cells} == {PRESETS[preset].permutations}
