"""Cells that differ in their view alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from oitbench.api.running import run
from oitbench.errors import UsageError
from oitbench.gl.device import Device
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.image.stored import StoredImage
from oitbench.matrix.plan import plan_matrix
from oitbench.matrix.stage import Stage
from oitbench.path_traced.references import storage
from oitbench.path_traced.references.lookup import find
from oitbench.plugins import Collection
from oitbench.results import baseline
from oitbench.results.records import Results
from oitbench.results.store import read_cells
from oitbench.results.table import flat
from oitbench.scene import Camera, Material, Object, Scene, Strands
from tests.made_up import record
from tests.path_traced.stored import make_reference, make_scene, wanted

STORED = StoredImage("images/none.exr", "", 0)
GUARD: dict[str, Any] = {"preset": "guard", "size": (16, 16), "ssaa": 1}


def test_views_are_an_axis_of_the_matrix() -> None:
    matrix = plan_matrix(["glass_bars"], ["alpha_blend", "a_buffer"], views=["plan,main", "left"])
    assert [(cell.view, cell.method) for cell in matrix.cells] == [
        (view, method)
        for view in ("plan", "main", "left")
        for method in ("alpha_blend", "a_buffer")
    ]
    assert [cell.seen for cell in matrix.cells[::2]] == [
        "glass_bars@plan", "glass_bars", "glass_bars@left",
    ]  # fmt: skip
    assert len({cell.key for cell in matrix.cells}) == 6
    with pytest.raises(UsageError, match="cannot read view 'Plan'"):
        plan_matrix(["glass_bars"], ["alpha_blend"], views=["main,Plan"])


def test_each_view_has_its_own_cells(tmp_path: Path) -> None:
    views = ["main,plan,left,nowhere"]
    outcome = run(["glass_bars"], ["a_buffer"], out=tmp_path, views=views, **GUARD)
    cells = {key.view: found for key, found in read_cells(tmp_path / "cells.jsonl").items()}
    (lost,) = outcome.troubled
    assert "unknown view of glass_bars 'nowhere'; known: left, main, plan, right" in lost.reason
    assert [cells[view].status for view in ("main", "plan", "left")] == ["ok"] * 3
    prints = {found.fingerprints.scene for found in cells.values() if found.fingerprints}
    assert len(prints) == 3
    results = Results.load(tmp_path)
    scenes = ("glass_bars", "glass_bars@plan", "glass_bars@left", "glass_bars@nowhere")
    assert results.scenes == tuple(panel.title for panel in results.panels()) == scenes
    images = [results.image(cells[view], "color") for view in ("main", "plan", "left")]
    stack = np.array([image for image in images if image is not None])
    for one, other in ((0, 1), (0, 2), (1, 2)):
        assert np.abs(stack[one] - stack[other]).max() > 0.01
    again = run(["glass_bars"], ["a_buffer"], out=tmp_path, views=["plan,left"], **GUARD).summary
    assert again is not None
    assert (again.kept, again.statuses) == (2, {})


def test_labels_name_a_view_that_is_not_the_main_one() -> None:
    found = record()
    plan = msgspec.structs.replace(found, view="plan")
    assert (found.seen, plan.seen) == (found.scene, f"{found.scene}@plan")
    assert baseline.label(plan).startswith(f"{found.scene}@plan ")
    assert baseline.label(found).startswith(f"{found.scene} ")
    assert (flat(plan)["scene"], flat(plan)["view"]) == (plan.seen, "plan")


def test_a_reference_belongs_to_its_view(tmp_path: Path) -> None:
    scene = make_scene()
    eye = scene.from_view("left")
    known = make_reference(eye)
    left = msgspec.structs.replace(known.rendering, view="left")
    assert left.key == "window[seed=2]@left@12x8.full"
    assert left.digest == known.rendering.digest
    assert "view" not in msgspec.to_builtins(known.rendering)
    folder = tmp_path / storage.FOLDER
    storage.save(folder, storage.Reference(left, {}, 1.0, known.parts, known.variance))
    assert find(wanted(scene), [tmp_path]).reference is None
    found = find(wanted(eye, view="left"), [tmp_path]).reference
    assert found is not None
    assert found.rendering == left
    stale = find(wanted(scene.from_view("right"), view="left"), [tmp_path])
    assert "run 'oitbench reference window[seed=2] --view left'" in stale.message
    next(folder.glob("*.exr")).unlink()
    with pytest.raises(UsageError, match=r"oitbench reference window\[seed=2\] --view left"):
        storage.read(folder, left.key)


def test_a_scene_is_built_once_for_all_of_its_views(monkeypatch: pytest.MonkeyPatch) -> None:
    from oitbench.matrix.cell import Cell
    from oitbench.matrix.identity import Identities

    built: list[str] = []
    identities = Identities(Collection.load(), lambda: built.append("scene"))
    cells = [Cell("glass_bars", "a_buffer", (8, 8), view=view) for view in ("plan", "main", "left")]
    cameras = {identities.scene(cell).camera for cell in cells}
    assert len(cameras) == 3
    assert built == ["scene"]


def test_frames_without_sub_pixels_have_strands_of_their_own_width(device: Device) -> None:
    strand = Object("s", Strands([[(-1, 0, 0), (1, 0, 0)]], 1e-4), Material(0.5))
    scene = Scene("s", Camera((0, 0, 3)), (strand,))
    method = Collection.load().truth()

    def stage(ssaa: int) -> Stage:
        uploaded = UploadedScene(device, scene, rows=16 * ssaa)
        return Stage("s", (16, 16), ssaa, "", "main", uploaded, method, lambda *_: STORED)

    fine, plain = stage(2), stage(1)
    widths = [
        float(np.ptp(one.geometry.scene.objects[0].mesh.positions[:, 1]))
        for one in (fine.uploaded, fine.coarse, plain.coarse)
    ]
    assert widths[1] == widths[2] == pytest.approx(2 * widths[0])
    assert fine.coarse is fine.coarse
    assert plain.coarse is plain.uploaded
    fine.release()
    plain.release()
