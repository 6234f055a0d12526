"""Cells that a user should look at: suspect ones, and how a run that has some ends."""

from __future__ import annotations

import resource
from pathlib import Path

import pytest

from oitbench.errors import StorageError
from oitbench.matrix.bench import Bench
from oitbench.matrix.cell import Cell
from oitbench.matrix.run import Summary
from oitbench.plugins import Collection
from oitbench.results.schema import TROUBLED, Record, Status
from tests.damage import largest_file
from tests.made_up import failed, record

SCENE = '''"""A pane, a wall, and a camera that looks at one of them or at none."""
import numpy as np
from oitbench import Parameter
from oitbench.modeling.mesh import quad
from oitbench.scene import Camera, Material, Object, Scene

parameters = {"look": Parameter("pane", choices=("pane", "away")), "coverage": Parameter(0.5)}


def build(*, name: str, look: str, coverage: float) -> Scene:
    mesh = quad((0, 0, 0), (1, 0, 0), (0, 1, 0))
    target = {"pane": (0.0, 0.0, 0.0), "away": (0.0, 0.0, 9.0)}[look]
    return Scene(
        name,
        Camera((0.0, 0.0, 4.0), target),
        (Object("pane", mesh, Material(coverage, emission=(1.0, 0.5, 0.25))),),
        background=(0.1, 0.2, 0.3),
    )
'''


@pytest.fixture(scope="module")
def views(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A collection with the scene `view`."""
    folder = tmp_path_factory.mktemp("views")
    (folder / "scenes").mkdir()
    (folder / "scenes" / "view.py").write_text(SCENE)
    return folder


def cell(scene: str) -> Cell:
    return Cell(scene, "weighted_sum", (8, 8), 1, permutations=1, truths=("exact",))


@pytest.mark.parametrize(
    ("scene", "status"),
    [
        ("view", "ok"),
        ("view[look=away]", "suspect"),
        # There is nothing to draw, so nothing is missing.
        ("view[look=away,coverage=1.0]", "ok"),
    ],
)
def test_a_cell_in_which_nothing_was_drawn_is_suspect(
    scene: str, status: str, views: Path, tmp_path: Path
) -> None:
    with Bench(Collection.load([views]), tmp_path) as bench:
        found = bench.run(cell(scene))
    assert found.status == status, found.reason
    assert ("no fragment" in found.reason) == (status == "suspect")
    # The perfect score of an empty picture stays in the record, beside the reason.
    assert found.finished


@pytest.mark.parametrize(
    ("method", "most", "status"),
    [
        ("depth_peeling", 2, "skipped"),
        ("dual_depth_peeling", 2, "skipped"),
        ("depth_peeling", 3, "ok"),
        ("depth_peeling", None, "ok"),
        ("depth_peeling[layers=2]", 2, "ok"),
        ("a_buffer", 2, "ok"),
        ("a_buffer[resolve=iterative]", 2, "ok"),
    ],
)
def test_a_method_that_peels_more_layers_than_a_preset_allows_is_skipped(
    method: str, most: int | None, status: str, tmp_path: Path
) -> None:
    wanted = Cell(
        "layer_stack[count=3]", method, (8, 8), 1, permutations=1, truths=("exact",),
        most_layers=most,
    )  # fmt: skip
    with Bench(Collection.load(), tmp_path) as bench:
        found = bench.run(wanted)
    assert found.status == status, found.reason
    assert ("3 layers lie at one pixel" in found.reason) == (status == "skipped")


def test_a_full_disk_is_no_fault_of_a_cell(views: Path, tmp_path: Path) -> None:
    with Bench(Collection.load([views]), tmp_path) as bench:
        bench.run(cell("view"))
        soft = resource.getrlimit(resource.RLIMIT_FSIZE)
        with largest_file(10), pytest.raises(StorageError, match="free some space"):
            bench.run(cell("view[look=away]"))
        assert resource.getrlimit(resource.RLIMIT_FSIZE) == soft


@pytest.mark.parametrize("status", sorted(TROUBLED))
def test_a_run_with_a_troubled_cell_exits_with_1(status: Status) -> None:
    assert Summary().exit_code == 0
    assert Summary(troubled=[failed(status=status)]).exit_code == 1


def test_a_suspect_record_keeps_what_is_worse() -> None:
    made: Record = record(status="unstable", reason="pixels: 1 nan").suspect("it is odd")
    assert (made.status, made.reason) == ("unstable", "pixels: 1 nan; it is odd")
    assert made.suspect("it is odd") == made
    assert record().suspect("it is odd").status == "suspect"
