"""The report of sweeps of parameters."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd

from oitbench.plugins import Collection
from oitbench.report import Artifact, Figure, Note
from oitbench.results.schema import EffectNames, Record
from tests.report.made_up import context, finished, unfinished, words

SWEEPS = Collection.load().reports["sweeps"]
VALUES = (0.1, 0.5, 0.3)


def cell(folder: Path, scene: str, method: str, error: float, **fields: Any) -> Record:
    return finished(folder, scene, method, error, name=method.partition("[")[0], **fields)


def swept(folder: Path, *cells: Record) -> tuple[list[Artifact], pd.DataFrame]:
    """Return the artifacts of the report, and its table."""
    drawn = SWEEPS.build(context(folder, cells, folder))
    return drawn, pd.read_csv(folder / "sweeps.csv", keep_default_na=False)


def test_cells_that_differ_in_a_parameter_of_the_method_are_a_curve(tmp_path: Path) -> None:
    cells = [cell(tmp_path, "panes", f"murk[k={v:g},b=true]", v) for v in VALUES]
    others = [cell(tmp_path, "panes", f"murk[k={v:g}]", 0.2) for v in (0.1, 0.3)]
    lost = unfinished("panes", "murk[k=0.7,b=true]")
    (figure, _), rows = swept(tmp_path, *cells, *others, lost)
    assert isinstance(figure, Figure)
    assert figure.title == "k of the method"
    assert figure.png.exists()
    assert rows["value"].to_list() == sorted(VALUES)
    assert rows["method"].to_list() == [f"murk[k={v:g},b=true]" for v in sorted(VALUES)]
    errors = rows.iloc[:, -1].to_list()
    assert errors == sorted(errors)


def test_a_parameter_of_the_scene_has_a_curve_for_each_variant(tmp_path: Path) -> None:
    names = ("murk", "murk[weight=far]")
    cells = [cell(tmp_path, f"panes[near={v:g}]", name, v) for v in VALUES for name in names]
    (figure, _), rows = swept(tmp_path, *cells)
    assert isinstance(figure, Figure)
    assert figure.title == "near of the scene"
    assert set(rows["parameter"]) == {"near"}
    assert rows["method"].to_list() == [name for name in names for _ in VALUES]


def test_a_setting_of_shading_is_swept(tmp_path: Path) -> None:
    settings = ("shadow_map=256", "", "shadow_map=4096")
    cells = [cell(tmp_path, "panes", "murk", 0.1, shading=setting) for setting in settings]
    (figure, _), rows = swept(tmp_path, *cells)
    assert isinstance(figure, Figure)
    assert figure.title == "shadow_map of the shading"
    assert rows["value"].to_list() == [256, 1024, 4096]
    assert set(rows["truth"]) == {"matched tracing"}
    assert rows["shading"].to_list() == ["shadow_map=256", "", "shadow_map=4096"]


def test_the_default_is_a_value(tmp_path: Path) -> None:
    texts = ("[k0=0.1]", "", "[k0=0.9]")
    cells = [cell(tmp_path, "panes", f"phenomenological{text}", 0.1) for text in texts]
    _, rows = swept(tmp_path, *cells)
    default = Collection.load().methods["phenomenological"].parameters["k0"].default
    assert rows["value"].to_list() == [0.1, default, 0.9]


def test_the_truth_ranks_the_effects_of_the_cells(tmp_path: Path) -> None:
    effects = {
        "panes": EffectNames(["COVERAGE"], ["COVERAGE"], []),
        "glass": EffectNames(["COVERAGE", "REFRACTION"], ["COVERAGE"], ["REFRACTION"]),
    }
    cells = [
        cell(tmp_path, scene, f"murk[k={v:g}]", v, outcome={"effects": requested})
        for scene, requested in effects.items()
        for v in VALUES
    ]
    _, rows = swept(tmp_path, *cells)
    found = dict(zip(rows["scene"], rows["truth"], strict=True))
    assert found == {"panes": "exact compositing", "glass": "matched tracing"}


def test_texts_sizes_and_two_values_are_no_sweep(tmp_path: Path) -> None:
    cells = [
        *(cell(tmp_path, "panes", f"murk[kind={kind}]", 0.1) for kind in "abc"),
        *(cell(tmp_path, "panes", f"murk[on={on}]", 0.1) for on in ("true", "false")),
        *(cell(tmp_path, "panes", f"murk[k={v:g}]", 0.1) for v in VALUES[:2]),
        cell(tmp_path, "panes", "murk[k=7]", 0.1, ssaa=3),
    ]
    (note,) = SWEEPS.build(context(tmp_path, cells, tmp_path))
    assert isinstance(note, Note)
    assert "three values" in note.text


def test_values_are_marked_below_the_axis(tmp_path: Path) -> None:
    cells = [
        cell(tmp_path, "layer_stack", f"stochastic[samples={count}]", 1 / count)
        for count in (4, 8, 16, 64)
    ]
    artifacts, _ = swept(tmp_path, *cells)
    found = words(next(item.pdf for item in artifacts if isinstance(item, Figure)))
    assert {"4", "8", "16", "64"} <= {*found}
    assert not {"10", "100"} & {*found}
