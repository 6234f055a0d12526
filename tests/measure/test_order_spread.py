"""The spread of a picture over random orders of the draws."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from oitbench.gl.frame import Frame, Image
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.image import metrics
from oitbench.matrix.bench import Bench
from oitbench.matrix.cell import Cell
from oitbench.matrix.plain_frames import permuted
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


@pytest.mark.parametrize(("method", "drawn"), [("a_buffer", 8), ("alpha_blend", 12)])
def test_permuted_draws_end_once_they_have_no_effect(
    method: str, drawn: int, bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    seeds: list[int] = []
    render = Frame.render

    def counted(frame: Frame, transmittance: bool = False, permutation: int | None = None) -> None:
        if permutation is not None:
            seeds.append(permutation)
        render(frame, transmittance, permutation)

    monkeypatch.setattr(Frame, "render", counted)
    spread(bench, method, 12)
    assert seeds == list(range(1, drawn + 1))


def test_a_late_change_counts(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    """Seven equal pictures, and one that differs: all others are drawn, too."""
    image, seen = Frame.image, [0]

    def changed(frame: Frame) -> Image:
        found = image(frame)
        seen[0] += 1
        return found + np.float32(seen[0] == 8)

    scene = bench.collection.build_scene("layer_stack")
    method = bench.collection.expand_methods(["a_buffer"])[0]
    with (
        UploadedScene(bench.device, scene) as uploaded,
        Frame(uploaded, method, (8, 8), scene.effects & method.shows) as frame,
    ):
        monkeypatch.setattr(Frame, "image", changed)
        found = metrics.order_spread(permuted(frame, 12))
    assert seen == [12]
    assert found[metrics.ORDER_SPREAD_MAX] == pytest.approx(1.0)


@pytest.mark.parametrize("preset", PRESETS)
def test_cells_have_the_number_of_orders_of_their_preset(preset: str) -> None:
    cells = plan_matrix(["layer_stack"], ["a_buffer"], preset).cells
    assert {cell.permutations for cell in cells} == {PRESETS[preset].permutations}
