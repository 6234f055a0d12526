"""The look of methods and the choice of the FLIP metric."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from oitbench.image import metrics
from oitbench.method.families import BLENDING, CURVES, OTHER
from oitbench.report import palette
from oitbench.truths import EXACT, MATCHED
from tests.report.made_up import context, finished, unfinished


def test_looks_follow_from_the_families_of_records(tmp_path: Path) -> None:
    murk, glow = (
        finished(tmp_path, "panes", method, 0.3, outcome={"family": family})
        for method, family in (("murk", CURVES), ("glow", BLENDING))
    )
    lost = unfinished("panes", "haze")
    for cells in ([murk, lost], [glow, murk, lost]):
        shown = context(tmp_path, cells, tmp_path)
        style = shown.style("murk")
        assert (style.color, style.marker) == palette.family_look(CURVES)
        assert shown.style("haze").color == palette.family_look(OTHER)[0]


@pytest.mark.parametrize("truth", [EXACT, MATCHED])
def test_the_map_belongs_to_the_metric(tmp_path: Path, truth: str) -> None:
    cell = finished(tmp_path, "panes", "murk", 0.3)
    ldr = context(tmp_path, [cell], tmp_path)
    hdr = replace(ldr, hdr=True)
    assert [ldr.flip, hdr.flip] == [metrics.FLIP_LDR, metrics.FLIP_HDR]
    maps = []
    for shown in (ldr, hdr):
        errors = shown.flip_map(cell, truth)
        assert errors is not None
        # The file has half floats.
        assert float(errors.mean()) == pytest.approx(cell.metric(truth, shown.flip), abs=1e-4)
        maps.append(errors)
    assert not np.array_equal(maps[0], maps[1])


def test_cells_can_lack_maps(tmp_path: Path) -> None:
    cells = [finished(tmp_path, "panes", "murk", 0.3, traced=False), unfinished("panes", "glow")]
    shown = context(tmp_path, cells, tmp_path)
    assert [shown.flip_map(cell, MATCHED) for cell in cells] == [None, None]
