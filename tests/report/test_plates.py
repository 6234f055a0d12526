"""Pictures of cells and truths."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest

from oitbench.image import files, metrics, stored
from oitbench.report import plates
from oitbench.report.error_maps import MapScale, scale_of
from oitbench.results.pictures import REDUCED
from oitbench.results.store import IMAGES
from oitbench.truths import EXACT, MATCHED
from tests.report.made_up import SIDE, context, finished


def test_a_traced_truth_is_beside_the_picture_of_its_size(tmp_path: Path) -> None:
    cell = finished(tmp_path, "panes", "murk", 0.3)
    assert cell.outcome is not None
    images, half = cell.outcome.images, SIDE // 2
    for kind, gray in ((REDUCED, 0.25), (MATCHED, 0.5)):
        small = np.full((half, half, 3), gray, np.float32)
        written = stored.store(tmp_path, f"{IMAGES}/{kind}", files.image_channels(small))
        images = images | {kind: written}
    cell = msgspec.structs.replace(
        cell, outcome=msgspec.structs.replace(cell.outcome, images=images)
    )
    shown = context(tmp_path, [cell], tmp_path)
    (panel,) = shown.results.panels()
    sizes = {}
    for truth in (EXACT, MATCHED):
        traced = plates.show_truth(shown, panel, truth, tmp_path)
        tile = plates.show_cell(shown, cell, truth, tmp_path, values=(), scale=MapScale())
        assert traced.picture is not None
        assert tile.picture is not None
        sizes[truth] = traced.picture.shape[0], tile.picture.shape[0]
        assert (f"{half} × {half}" in traced.tile.values) == (truth == MATCHED)
    assert sizes == {EXACT: (SIDE, SIDE), MATCHED: (half, half)}


def test_maps_of_small_errors_are_not_black(tmp_path: Path) -> None:
    cells = [finished(tmp_path, "panes", "murk", error) for error in (0.002, 0.004)]
    scale = scale_of(cells, EXACT, metrics.FLIP_LDR)
    largest = max(cell.metric(EXACT, metrics.FLIP_LDR) or 0.0 for cell in cells)
    assert largest <= scale.top <= 10 * largest
    assert scale.colored(np.full((1, 1), largest, np.float32)).max() > 0.4
    assert f"to {scale.top:g} or more" in scale.words


def test_the_scale_of_large_errors_ends_at_one(tmp_path: Path) -> None:
    scale = scale_of([finished(tmp_path, "panes", "murk", 0.9)], EXACT, metrics.FLIP_LDR)
    assert scale.top == 1.0
    assert [*scale.ticks.values()] == ["0", "0.0625", "0.25", "0.5625", "1"]
    assert "or more" not in scale.words


@pytest.mark.parametrize(
    ("label", "lines"),
    [
        ("adaptive[nodes=4]", ["adaptive", "[nodes=4]"]),
        ("multilayer_alpha", ["multilayer_", "alpha"]),
        ("dual_depth_peeling", ["dual_depth_", "peeling"]),
        ("phenomenological", ["phenomenol-", "ogical"]),
        ("stochastic[samples=64]", ["stochastic", "[samples=64", "]"]),
        ("_odd__name", ["_odd__name"]),
    ],
)
def test_labels_end_lines_at_underscores_and_before_parameters(
    label: str, lines: list[str]
) -> None:
    assert plates.lines_of(label, 11) == lines
    assert plates.lines_of(label, 99) == [label]
