"""The report of the phenomena of transparency."""

from __future__ import annotations

from pathlib import Path

from oitbench.image.metrics import FLIP_LDR
from oitbench.plugins import Collection
from oitbench.report import Figure, ImageGrid
from tests.report.made_up import context, with_effects


def test_plates_of_methods_of_diffusion_and_of_effects_left_out(tmp_path: Path) -> None:
    shadows = ("TRANSLUCENT_SHADOWS", "COLORED_SHADOWS")
    cells = [
        with_effects(tmp_path, "full", 0.1),
        with_effects(tmp_path, "full", 0.3, effects="-diffusion", gone=["DIFFUSION"]),
        with_effects(tmp_path, "full", 0.1, effects="-translucent_shadows", gone=shadows),
        with_effects(tmp_path, "plain", 0.4, missing=["DIFFUSION"]),
    ]
    shown = context(tmp_path, cells, tmp_path)
    methods, pair, ablation = Collection.load().reports["phenomena"].build(shown)
    assert isinstance(methods, ImageGrid)
    assert [tile.label for tile in methods.tiles] == [
        "matched tracing",
        "full path tracing",
        "full",
        "plain",
    ]
    assert methods.tiles[2].values[1] == "all effects"
    assert methods.tiles[3].values[1] == "misses diffusion"
    assert all(tile.error_map is not None for tile in methods.tiles[2:])
    assert isinstance(pair, Figure)
    assert "full" in pair.caption
    assert isinstance(ablation, ImageGrid)
    assert [tile.label for tile in ablation.tiles] == [
        "matched tracing",
        "all effects",
        "without diffusion",
        "without translucent shadows",
    ]
    caption = "Leaving out translucent shadows also leaves out colored shadows."
    assert caption in ablation.figure.caption


def test_of_methods_that_miss_the_same_effects_the_best_is_shown(tmp_path: Path) -> None:
    lost, both = ["DIFFUSION"], ["DIFFUSION", "REFRACTION"]
    cells = [
        with_effects(tmp_path, "murk", 0.4, missing=both),
        with_effects(tmp_path, "plain", 0.3, missing=lost),
        with_effects(tmp_path, "clear", 0.2, missing=lost),
        with_effects(tmp_path, "full", 0.5),
    ]
    report = Collection.load().reports["phenomena"]
    best = report.best_by_missing_effects(cells, FLIP_LDR)
    assert [(missing, cell.method) for missing, cell in best.items()] == [
        ((), "full"), (tuple(lost), "clear"), (tuple(both), "murk")
    ]  # fmt: skip
