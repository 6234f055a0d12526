"""The report of lists, curves and blending at equal bytes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pandas as pd
import pytest

from oitbench.image import files, metrics, stored
from oitbench.matrix.plan import plan_matrix
from oitbench.plugins import Collection
from oitbench.report import Artifact, Figure, Note, Table
from oitbench.results.schema import COMPLEXITY, TRANSMITTANCE, Memory, Record, Scores
from oitbench.truths import EXACT
from tests.benchmarks import crossover
from tests.report.made_up import context, finished

CROSSOVER = Collection.load().reports["crossover"]
BYTES = {"k_buffer": 64.0, "wavelet[rank=2]": 56.0, "weighted_blended": 9.0, "sorted_over": 0.0}
FLIP = {"wavelet": 0.2}
"""FLIP of methods that differ from the others, contrary to their RMSE in the scene below."""


def cells(
    folder: Path, scene: str, layers: int, opacity: float, objects: int, **errors: float
) -> list[Record]:
    """Return the cells of one picture whose pixels all have equal layers."""
    shape = (4, 4)
    passed = np.full((*shape, 3), (1 - opacity) ** layers, np.float32)
    maps: dict[str, files.Channels] = {
        COMPLEXITY: files.count_channels(np.full(shape, layers)),
        TRANSMITTANCE: files.image_channels(passed),
    }
    images = {kind: stored.store(folder, f"images/{kind}", maps[kind]) for kind in maps}
    found = []
    for method, size in BYTES.items():
        name = method.partition("[")[0]
        made = finished(folder, scene, method, 0.1, name=name)
        assert made.outcome is not None
        values = {metrics.RMSE: errors.get(name, 0.5), metrics.FLIP_LDR: FLIP.get(name, 0.3)}
        outcome = msgspec.structs.replace(
            made.outcome,
            memory=Memory(1, 8 * size, []),
            images=made.outcome.images | images,
            statistics=msgspec.structs.replace(made.outcome.statistics, objects=objects),
            scores={EXACT: Scores(dict(values))},
        )
        found.append(msgspec.structs.replace(made, outcome=outcome))
    return found


def stacks(folder: Path) -> list[Record]:
    """Return stacks in which lists and curves are equal at 16 layers of opacity 0.1."""
    return [
        cell
        for opacity in (0.02, 0.1, 0.5)
        for layers in (4, 16, 64)
        for seed in (1, 2)
        for cell in cells(
            folder,
            f"lists[layers={layers},alpha={opacity},seed={seed}]",
            layers,
            opacity,
            objects=0,
            k_buffer=0.001 * layers,
            wavelet=0.16 * opacity,
        )
    ]


def built(folder: Path, made: list[Record]) -> list[Artifact]:
    drawn: list[Artifact] = CROSSOVER.build(context(folder, made, folder))
    return drawn


def test_the_crossings_are_printed_and_drawn(tmp_path: Path) -> None:
    drawn = built(tmp_path, stacks(tmp_path))
    assert [type(part) for part in drawn] == [Figure, Figure, Table, Table, Table]
    assert all(part.png.is_file() for part in drawn if isinstance(part, Figure))
    rows = pd.read_csv(tmp_path / "crossover.csv")
    assert set(rows["bytes"]) == {"56 to 64 bytes per pixel"}
    by_layers = rows[rows["layers"].isna()]
    np.testing.assert_allclose(by_layers["opacity"], [0.02, 0.1, 0.5], rtol=1e-5)
    assert by_layers["curves"].to_list() == ["everywhere", "beyond 16 layers", "not at 64 layers"]
    np.testing.assert_allclose(by_layers["crossing"], [np.nan, 16, np.nan], rtol=1e-5)
    by_opacity = rows[rows["opacity"].isna()]
    assert by_opacity["layers"].to_list() == [4, 16, 64]
    assert by_opacity["curves"].to_list() == ["below 0.025", "below 0.10", "below 0.40"]
    assert set(rows["best_list"]) == {"k_buffer"}
    assert set(rows["best_curve"]) == {"wavelet[rank=2]"}


def test_stacks_that_an_interrupted_run_lacks_are_named(tmp_path: Path) -> None:
    *made, last = stacks(tmp_path)
    found = built(tmp_path, made)
    note = next(part for part in found if isinstance(part, Note))
    assert note.text.endswith(f"not shown: lists[alpha={last.scene.split('alpha=')[1][:3]}].")
    rows = pd.read_csv(tmp_path / "crossover.csv")
    np.testing.assert_allclose(rows["opacity"].dropna(), [0.02, 0.1], rtol=1e-5)
    assert not pd.read_csv(tmp_path / "crossover-scenes.csv").size


def test_real_scenes_are_compared_in_each_group(tmp_path: Path) -> None:
    scene = cells(tmp_path, "panes", 5, 0.3, objects=3, k_buffer=0.01, wavelet=0.02)
    *_, table, methods = built(tmp_path, [*stacks(tmp_path), *scene])
    assert isinstance(table, Table)
    row = pd.read_csv(tmp_path / "crossover-scenes.csv").iloc[0]
    assert (row["scene"], row["layers"]) == ("panes", 5)
    assert row["opacity"] == pytest.approx(0.3)
    assert (row["lists"], row["curves"]) == ("k_buffer", "wavelet[rank=2]")
    assert row["blending"] == "weighted_blended"
    assert (row["winner"], row["winner_flip"]) == ("lists", "curves")
    assert len(table.rows) == 1
    assert isinstance(methods, Table)
    assert [row[1:] for row in methods.rows] == [
        ("lists", "k_buffer", 64.0),
        ("curves", "wavelet[rank=2]", 56.0),
    ]


def test_scenes_without_stacks_have_a_table(tmp_path: Path) -> None:
    scene = cells(tmp_path, "panes", 5, 0.3, objects=3)
    assert [type(part) for part in built(tmp_path, scene)] == [Table, Table]


def test_results_without_both_families_have_a_note(tmp_path: Path) -> None:
    (note,) = built(tmp_path, [finished(tmp_path, "panes", "k_buffer", 0.1, name="k_buffer")])
    assert isinstance(note, Note)
    assert "tests.benchmarks.crossover" in note.text


def test_methods_of_the_report_exist() -> None:
    assert set(CROSSOVER.FAMILIES) <= set(Collection.load().methods)


@pytest.mark.parametrize("name", crossover.PARTS)
def test_the_command_can_be_planned(name: str, tmp_path: Path) -> None:
    for part in crossover.PARTS[name]:
        settings: dict[str, Any] = {"ssaa": 1, "truths": [EXACT], "out": tmp_path}
        planned = plan_matrix(part.scenes, part.methods, "guard", part.size, **settings)
        assert planned.cells
        families = {CROSSOVER.FAMILIES[cell.method.partition("[")[0]] for cell in planned.cells}
        assert families == {"lists", "curves", "blending"}
