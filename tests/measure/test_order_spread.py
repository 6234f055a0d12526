"""How far random orders of the draws spread a cell's picture is measured and recorded."""

from __future__ import annotations

from pathlib import Path

import pytest

from oitbench.gl.device import Device
from oitbench.image import metrics
from oitbench.matrix.bench import Bench
from oitbench.matrix.cell import Cell
from oitbench.matrix.plan import PRESETS, plan_matrix
from oitbench.plugins import Collection


@pytest.fixture
def bench(device: Device, tmp_path: Path) -> Bench:
    return Bench(Collection.load(), tmp_path)


def spread(bench: Bench, method: str, permutations: int) -> tuple[float | None, float | None]:
    cell = Cell("layer_stack", method, (32, 24), ssaa=1, permutations=permutations)
    record = bench.run(cell)
    names = (metrics.ORDER_SPREAD_MAX, metrics.ORDER_SPREAD_MEAN)
    most, mean = (record.metric("exact", name) for name in names)
    return most, mean


def test_only_methods_that_depend_on_order_spread(bench: Bench) -> None:
    assert spread(bench, "a_buffer", 3) == (0.0, 0.0)
    assert spread(bench, "a_buffer", 0) == (None, None)
    few, many = spread(bench, "alpha_blend", 2), spread(bench, "alpha_blend", 6)
    assert few[0] is not None
    assert few[1] is not None
    assert many[0] is not None
    assert 0.01 < few[1] < few[0] <= many[0]


def test_larger_presets_try_more_orders() -> None:
    tried = {name: preset.permutations for name, preset in PRESETS.items()}
    assert tried["quick"] < tried["standard"] == tried["paper"] == 16
    (cell,) = plan_matrix(["layer_stack"], ["a_buffer"], "standard").cells
    assert cell.permutations == 16
