"""A results folder as reports read it: panels, ablations, images and flat rows."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

from oitbench.errors import UsageError
from oitbench.results.records import Results
from oitbench.truths import EXACT, MATCHED
from tests.damage import flip_bit
from tests.report.made_up import FACTS, finished, store, unfinished, unstable, with_effects


def test_scenes_and_methods_are_ordered(tmp_path: Path) -> None:
    places = [("panes", "murk"), ("panes", "glow[n=16]"), ("lists", "glow[n=8]")]
    results = Results(tmp_path, tuple(unfinished(*place) for place in places), FACTS)
    assert results.scenes == ("panes", "lists")
    assert results.methods == ("glow[n=8]", "glow[n=16]", "murk")


def test_cells_that_leave_effects_out_belong_to_the_panel_of_the_complete_cell(
    tmp_path: Path,
) -> None:
    shadows = ("TRANSLUCENT_SHADOWS", "COLORED_SHADOWS")
    cells = (
        with_effects(tmp_path, "full", 0.1),
        with_effects(tmp_path, "full", 0.3, effects="-diffusion", gone=["DIFFUSION"]),
        with_effects(tmp_path, "full", 0.1, effects="-translucent_shadows", gone=shadows),
        with_effects(tmp_path, "full", 0.2, effects="-shadows", gone=["SHADOWS"]),
        with_effects(tmp_path, "plain", 0.4),
        unfinished("panes", "plain", effects="-shadows"),
    )
    (panel,) = Results(tmp_path, cells, FACTS).panels()
    assert panel.title == "panes"
    assert [cell.method for cell in panel.cells] == ["full", "plain"]
    found = {a.named: a.implied for a in panel.ablations if a.complete is panel.cells[0]}
    assert found == {
        ("DIFFUSION",): (),
        ("TRANSLUCENT_SHADOWS",): ("COLORED_SHADOWS",),
        ("SHADOWS",): (),
    }
    assert panel.ablations[-1].reduced.status == "failed"
    assert panel.ablations[-1].implied == ()


def test_a_cell_without_its_complete_cell_has_a_panel_of_its_own(tmp_path: Path) -> None:
    alone = with_effects(tmp_path, "full", 0.3, effects="-diffusion", gone=["DIFFUSION"])
    (panel,) = Results(tmp_path, (alone,), FACTS).panels()
    assert panel.ablations == ()
    assert panel.cells == (alone,)


def test_panels_of_several_sizes_show_them(tmp_path: Path) -> None:
    cell = unfinished("panes", "murk")
    other = msgspec.structs.replace(cell, size=(8, 4))
    panels = Results(tmp_path, (cell, other), FACTS).panels()
    assert [panel.title for panel in panels] == ["panes · 8 × 4", "panes · 16 × 16"]
    assert len({panel.slug for panel in panels}) == 2


def test_rows_are_flat(tmp_path: Path) -> None:
    cells = (
        finished(tmp_path, "panes", "murk", 0.3),
        unstable(tmp_path, "panes", "glow[n=16]"),
        unfinished("panes", "<b>bold</b>"),
        finished(tmp_path, "lists", "murk", 0.1, traced=False),
    )
    frame = Results.load(store(tmp_path, *cells)).frame()
    assert len(frame) == 4
    assert frame["flip_matched"].notna().sum() == 1
    assert set(frame["name"]) == {"murk", "glow", "<b>bold</b>"}
    assert not frame.map(lambda value: isinstance(value, list | dict)).any(axis=None)


def test_images_and_maps_can_be_missing(tmp_path: Path) -> None:
    cell = finished(tmp_path, "panes", "murk", 0.3, traced=False)
    results = Results(tmp_path, (cell,), FACTS)
    assert results.image(cell, "color") is not None
    assert results.image(cell, MATCHED) is None
    maps = results.flip_maps(cell, EXACT)
    assert maps is not None
    assert [errors.shape for errors in maps] == [(16, 16)] * 2
    assert results.flip_maps(cell, MATCHED) is None
    assert cell.outcome is not None
    path = tmp_path / cell.outcome.images["flip_exact"].path
    path.unlink()
    results = Results(tmp_path, (cell,), FACTS)
    assert results.flip_maps(cell, EXACT) is None
    (fault,) = results.faults
    assert fault == f"{path} cannot be read (No such file or directory); run again to render it"


def test_no_damaged_image_is_shown(tmp_path: Path) -> None:
    cell = finished(tmp_path, "panes", "murk", 0.3)
    assert cell.outcome is not None
    for kind, image in cell.outcome.images.items():
        path = tmp_path / image.path
        whole = path.read_bytes()
        for number in range(3, 8 * len(whole), 8 * len(whole) // 25):
            flip_bit(path, number)
            results = Results(tmp_path, (cell,), FACTS)
            assert results.fault(cell, kind) == f"{path} is damaged; run again to render it"
            assert len(results.faults) == 1
            path.write_bytes(whole)


def test_folders_without_results_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"holds no cells\.jsonl"):
        Results.load(tmp_path)
