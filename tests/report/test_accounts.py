"""Bars of memory and time, and beside them that of what all methods share."""

from __future__ import annotations

from pathlib import Path

import pytest

from oitbench.report import accounts
from oitbench.report.artifacts import Figure
from reports import memory, time, traffic
from tests.report.made_up import context, with_effects


def test_shared_shading_is_no_part_of_a_methods_bar(tmp_path: Path) -> None:
    cells = [with_effects(tmp_path, method, 0.2, shadow_maps=2**20) for method in ("a", "b")]
    shown = context(tmp_path, cells, tmp_path)
    (panel,) = shown.results.panels()
    outcome = cells[0].outcome
    assert outcome is not None
    bar = memory._ACCOUNT.bar(shown, cells[0], outcome)
    shared = memory._ACCOUNT.shared(panel, outcome)
    assert bar.length == pytest.approx(3072 / 2**20)
    assert shared.total.startswith("1.00 MiB")
    assert time._ACCOUNT.bar(shown, cells[0], outcome).length == pytest.approx(10.0)
    assert time._ACCOUNT.shared(panel, outcome).total == "1.00 ms"


@pytest.mark.parametrize(("shadow_maps", "broken"), [(2**20, True), (1024, False)])
def test_a_long_shared_bar_has_a_visible_break(
    tmp_path: Path, shadow_maps: int, broken: bool
) -> None:
    cell = with_effects(tmp_path, "a", 0.2, shadow_maps=shadow_maps)
    figure = accounts.build(context(tmp_path, [cell], tmp_path), memory._ACCOUNT)[0]
    assert isinstance(figure, Figure)
    assert ("break" in figure.caption) == broken


def test_memory_and_traffic_have_the_same_unit(tmp_path: Path) -> None:
    cell = with_effects(tmp_path, "a", 0.2)
    assert cell.outcome is not None
    shown = context(tmp_path, [cell], tmp_path)
    assert traffic._ACCOUNT.bar(shown, cell, cell.outcome).total.endswith("MiB")
    row = shown.results.frame().iloc[0]
    assert row["traffic_mib"] == pytest.approx(400 / 2**20)
