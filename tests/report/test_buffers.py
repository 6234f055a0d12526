"""The report of what methods store."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image as PngImage

from oitbench.plugins import Collection
from oitbench.report import ImageGrid, Note
from tests.report.made_up import SIDE, context, finished, unfinished

BUFFERS = Collection.load().reports["buffers"]
METHOD = "phenomenological[steps=4]"


def test_views_of_a_method_and_the_shadow_map_have_pictures(tmp_path: Path) -> None:
    cells = [
        finished(tmp_path, "frosted_panes[detail=0.1]", name, 0.1, name=name.partition("[")[0])
        for name in ("alpha_blend", METHOD, "phenomenological[steps=5]")
    ]
    (plate,) = BUFFERS.build(context(tmp_path, cells, tmp_path))
    assert isinstance(plate, ImageGrid)
    assert plate.figure.title == f"frosted_panes[detail=0.1]: {METHOD}"
    assert plate.figure.png.exists()
    labels = [tile.label for tile in plate.tiles]
    assert labels == ["color", "accumulated", "transmittance", "diffusion", "shadow_map"]
    for tile in plate.tiles[:-1]:
        assert tile.picture is not None
        with PngImage.open(tile.picture) as picture:
            assert picture.size == (SIDE, SIDE)
            assert tile.values[1] in picture.info["Description"]
            assert np.asarray(picture).any()


def test_a_cell_that_cannot_be_drawn_costs_only_its_own_plate(tmp_path: Path) -> None:
    cells = [
        finished(tmp_path, scene, METHOD, 0.1, name="phenomenological")
        for scene in ("panes", "glass_bars")
    ]
    # The third scene needs the same targets as the second.
    cells.append(finished(tmp_path, "tumblers", METHOD, 0.1, name="phenomenological"))
    lost, drawn = BUFFERS.build(context(tmp_path, cells, tmp_path))
    assert isinstance(lost, Note)
    assert lost.text.startswith(f"panes: {METHOD}: unknown scene 'panes'")
    assert isinstance(drawn, ImageGrid)
    assert drawn.figure.title.startswith("glass_bars")


@pytest.mark.parametrize("name", ["murk", "alpha_blend"])
def test_methods_with_no_views_have_no_plate(tmp_path: Path, name: str) -> None:
    cells = [finished(tmp_path, "panes", name, 0.1), unfinished("panes", "phenomenological")]
    (note,) = BUFFERS.build(context(tmp_path, cells, tmp_path))
    assert note.text == "No finished cell belongs to a method that declares views."
