"""What a matrix holds, by its preset."""

from __future__ import annotations

import re
from typing import Any

import pytest

from oitbench import parameters
from oitbench.errors import UsageError
from oitbench.matrix.cell import Cell
from oitbench.matrix.plan import PRESETS, plan_matrix
from oitbench.places import own_folder
from oitbench.plugins import Collection
from oitbench.truths import EXACT

FRAMES = (1, 2, 4, 8, 16, 32, 64)


def test_the_noise_preset_runs_random_methods_over_frames_with_and_without_sub_pixels() -> None:
    cells = plan_matrix(["layer_stack"], preset="noise").cells
    methods = Collection.load()
    random = [name for name in methods.methods if methods.methods[name].noisy]
    labels = [
        f"{name}[noise={noise},frames={count}]"
        for name in random
        for noise in ("white", "blue")
        for count in FRAMES
    ]
    expected = {method.label for method in methods.expand_methods(labels)}
    for grid in (1, 2):
        found = [cell.method for cell in cells if cell.ssaa == grid]
        assert len(found) == len(random) * 2 * len(FRAMES)
        assert set(found) == expected
    # Cells of one grid follow each other, so that they share the scene on the device.
    assert [cell.ssaa for cell in cells] == sorted(cell.ssaa for cell in cells)
    assert {cell.truths for cell in cells} == {(EXACT,)}
    assert {cell.permutations for cell in cells} == {0}


def test_a_given_grid_replaces_those_of_the_preset() -> None:
    cells = plan_matrix(["layer_stack"], ["hashed_alpha"], "noise", ssaa=3).cells
    assert [(cell.method, cell.ssaa) for cell in cells] == [("hashed_alpha", 3)]
    with pytest.raises(UsageError, match="ssaa 0"):
        plan_matrix(["layer_stack"], ["hashed_alpha"], "noise", ssaa=0)


@pytest.mark.parametrize("preset", sorted(PRESETS.keys() - {"noise"}))
def test_other_presets_have_one_grid_of_sub_pixels(preset: str) -> None:
    cells = plan_matrix(["layer_stack"], ["hashed_alpha"], preset).cells
    assert [cell.ssaa for cell in cells] == [2]


def test_standard_runs_the_defaults_and_the_sweeps_and_paper_all_grids() -> None:
    methods = Collection.load()
    found = {
        preset: {cell.method for cell in plan_matrix(["layer_stack"], preset=preset).cells}
        for preset in ("standard", "paper")
    }
    swept = {
        name: parameters.selector(name, parameters.sweeps(declared.parameters))
        for name, declared in methods.methods.items()
    }
    assert found["standard"] == {m.label for m in methods.expand_methods(swept.values())}
    assert found["standard"] > set(methods.methods)
    assert any("[" in text for text in swept.values())
    assert found["paper"] > found["standard"]
    axes = [
        parameters.selector(name, parameters.grids(declared.parameters))
        for name, declared in methods.methods.items()
    ]
    assert found["paper"] == {m.label for m in methods.expand_methods(axes)}


@pytest.mark.parametrize("preset", ["standard", "paper"])
def test_the_readme_counts_the_cells_of_the_larger_presets(preset: str) -> None:
    readme = " ".join((own_folder() / "README.md").read_text(encoding="utf-8").split())
    width, height = PRESETS[preset].size
    counted = rf"`--preset {preset}` [^.(]*at {width} × {height}[^.(]* \((\d+) cells\)"
    found = re.search(counted, readme)
    assert found is not None
    assert int(found[1]) == len(plan_matrix(preset=preset).cells)


def test_standard_compares_traced_truths_at_the_size_of_stored_references() -> None:
    def sizes(**options: Any) -> set[tuple[int, int]]:
        cells = plan_matrix(["layer_stack"], ["a_buffer"], "standard", **options).cells
        return {cell.traced_size for cell in cells}

    assert sizes() == {(256, 256)}
    # Elsewhere, no picture has their size.
    for other in ((256, 256), (500, 512)):
        assert sizes(size=other) == {other}
    assert sizes(ssaa=1) == {(512, 512)}


def test_only_standard_leaves_out_peeling_of_many_layers() -> None:
    limits = {name: preset.most_layers for name, preset in PRESETS.items()}
    assert {name for name, most in limits.items() if most is not None} == {"standard"}
    (cell,) = plan_matrix(["layer_stack"], ["depth_peeling"], "standard").cells
    assert cell.most_layers == limits["standard"]


@pytest.mark.parametrize(
    ("size", "small"), [((512, 512), (128, 128)), ((1280, 720), (256, 144)), ((64, 48), (64, 48))]
)
def test_permuted_draws_have_small_pictures(size: tuple[int, int], small: tuple[int, int]) -> None:
    assert Cell("layer_stack", "a_buffer", size).order_size == small
