"""A small suite of two scenes, one of them with a reference, and results of it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest

from oitbench.matrix.run import run_matrix
from oitbench.path_traced.references.rendering import plan_rendering, render_reference
from oitbench.path_traced.references.storage import FOLDER, save
from oitbench.path_traced.references.wanted import Wanted
from oitbench.plugins import Collection
from oitbench.suites.description import Suite, write_suite
from oitbench.suites.freezing import freeze
from oitbench.suites.planning import plan_suite
from oitbench.truths import EXACT, MATCHED
from tests.cli.conftest import call as call

SIZE = (16, 16)
METHODS = ("alpha_blend", "a_buffer")
_HEAD = '''"""A scene for tests."""
from oitbench.parameters import Parameter
parameters = {"detail": Parameter(1.0, low=0.0, help="no effect")}
'''
PANES = f"""{_HEAD}
from oitbench.modeling.mesh import quad
from oitbench.scene import Camera, Material, Object, Scene

def build(*, name, detail):
    panes = [
        Object(
            f"pane {{number}}",
            quad((0.2 * number, 0, -2 - number), (0.9, 0, 0), (0, 0.9, 0)),
            Material(coverage=0.5, emission=(0.5, 0.3, 0.2 * number)),
        )
        for number in range(3)
    ]
    return Scene(name, Camera((0, 0, 0), (0, 0, -1)), tuple(panes), background=(0.8, 0.8, 0.8))
"""
LISTS = f"""{_HEAD}
from oitbench.stability.layers import random_lists, scene_of
from dataclasses import replace

def build(*, name, detail):
    return replace(scene_of(random_lists(3)), name=name)
"""


@dataclass(frozen=True)
class World:
    """A collection, the suite that was frozen from it, its file, and a finished run."""

    folder: Path
    suite: Suite
    file: Path
    results: Path


def store_reference(folder: Path) -> None:
    """Store the matched reference of the scene `glazing`."""
    scene = Collection.load([folder]).build_scene("glazing")
    wanted = Wanted(scene, "glazing", SIZE, 1, MATCHED)
    save(folder / FOLDER, render_reference(scene, plan_rendering(wanted)))


@pytest.fixture(scope="session")
def world(tmp_path_factory: pytest.TempPathFactory) -> World:
    """Tests must not change it."""
    folder = tmp_path_factory.mktemp("world")
    (folder / "scenes").mkdir()
    (folder / "scenes" / "glazing.py").write_text(PANES)
    (folder / "scenes" / "lists.py").write_text(LISTS)
    store_reference(folder)
    suite = freeze("tiny", ["glazing", "lists"], SIZE, 1, (EXACT, MATCHED), [folder])
    file = folder / "tiny.json"
    write_suite(file, suite)
    matrix = plan_suite(str(file), METHODS, [folder], out=folder / "results")
    summary = run_matrix(matrix)
    assert summary.statuses == {"ok": 4}
    return World(folder, suite, file, folder / "results")
