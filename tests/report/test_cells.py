"""Values of cells: totals, noise floors, and the cell that misses the fewest effects."""

from __future__ import annotations

from pathlib import Path

from oitbench.image import metrics
from oitbench.report.cells import (
    effect_label,
    effect_labels,
    most_complete,
    total_memory,
    total_traffic,
)
from oitbench.results.ranking import largest_noise_floor
from oitbench.truths import MATCHED
from tests.report.made_up import FLOOR, finished, unfinished, with_effects


def test_totals_include_shared_shading(tmp_path: Path) -> None:
    cell = with_effects(tmp_path, "full", 0.1)
    assert cell.outcome is not None
    assert total_memory(cell.outcome) == 3072 + 2**20
    assert total_traffic(cell.outcome) == 400


def test_the_most_complete_cell_misses_the_least_then_errs_the_least(tmp_path: Path) -> None:
    near = with_effects(tmp_path, "near", 0.1, missing=["DIFFUSION"])
    far = with_effects(tmp_path, "far", 0.4)
    assert most_complete([near, far], metrics.FLIP_LDR) is far
    nearer = with_effects(tmp_path, "nearer", 0.2)
    assert most_complete([far, near, nearer], metrics.FLIP_LDR) is nearer
    unscored = finished(tmp_path, "panes", "unscored", 0.1, traced=False)
    assert most_complete([unscored, far], metrics.FLIP_LDR) is far
    assert most_complete([], metrics.FLIP_LDR) is None


def test_noise_floors_belong_to_a_traced_truth(tmp_path: Path) -> None:
    cells = [
        unfinished("panes", "glow"),
        finished(tmp_path, "panes", "murk", 0.1, traced=False),
    ]
    assert largest_noise_floor(cells, MATCHED, metrics.FLIP_LDR) is None
    cells.append(finished(tmp_path, "panes", "glow", 0.1))
    assert largest_noise_floor(cells, MATCHED, metrics.FLIP_LDR) == FLOOR
    assert largest_noise_floor(cells, MATCHED, metrics.FLIP_HDR) is None


def test_names_of_effects() -> None:
    assert effect_label("COLORED_SHADOWS") == "colored shadows"
    assert effect_labels(["INFERRED_AO", "VOLUME"]) == "inferred AO, volume"
