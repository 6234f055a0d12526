"""The look of methods and the choice of the FLIP metric."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from oitbench.image import metrics
from oitbench.truths import EXACT, MATCHED
from tests.report.made_up import context, finished, unfinished


def test_methods_that_differ_in_parameters_share_a_color(tmp_path: Path) -> None:
    cells = [unfinished("panes", label) for label in ("murk", "glow[n=8]", "glow[n=16]")]
    shown = context(tmp_path, cells, tmp_path)
    small, large = shown.style("glow[n=8]"), shown.style("glow[n=16]")
    assert small.color == large.color != shown.style("murk").color
    assert small.marker != large.marker


def test_a_color_does_not_depend_on_the_other_methods(tmp_path: Path) -> None:
    murk, glow = unfinished("panes", "murk"), unfinished("panes", "glow")
    styles = [context(tmp_path, cells, tmp_path).style("murk") for cells in ([murk], [glow, murk])]
    assert styles[0] == styles[1]


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
