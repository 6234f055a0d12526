"""Crops of scenes: what a file may state, and how a command knows them."""

from __future__ import annotations

from pathlib import Path

import pytest

from oitbench.catalog.catalog import Catalog
from oitbench.crops import check, of_view
from oitbench.plugins import Collection

SCENE = """from oitbench.parameters import Parameter

crops = {crops}
parameters = {{"detail": Parameter(1.0, low=0.0)}}


def build(**values):
    raise AssertionError("no picture is needed")
"""


def write_scene(folder: Path, crops: str) -> Path:
    (folder / "scenes").mkdir()
    (folder / "scenes" / "mine.py").write_text(SCENE.format(crops=crops))
    return folder


@pytest.mark.parametrize(
    "crops",
    [
        "{'rim': (0.5, 0.5, 0.6, 0.1)}",
        "{'rim': (-0.1, 0, 0.5, 0.5)}",
        "{'rim': (0, 0, 0.001, 0.5)}",
        "{'rim': (0, 0, 0.5)}",
        "{'rim': (0, 0, float('nan'), 0.5)}",
        "{'rim': ('0', 0, 0.5, 0.5)}",
        "{'rim': None}",
        "{'Rim of it': (0, 0, 1, 1)}",
        "{'rim@': (0, 0, 1, 1)}",
        "{3: (0, 0, 1, 1)}",
        "[(0, 0, 1, 1)]",
    ],
)
def test_a_crop_that_is_none_is_an_error_of_its_file(tmp_path: Path, crops: str) -> None:
    with Catalog([write_scene(tmp_path, crops)]) as catalog:
        error = catalog.entry("scene", "mine").error
    assert "mine.py" in error
    assert "crop" in error
    assert "\n" not in error


def test_a_crop_may_reach_the_edges() -> None:
    found = check({"rim": (0, 0, 1, 1), "foot@above": [0.7, 0.9, 0.3, 0.1]})
    assert found == {"rim": (0.0, 0.0, 1.0, 1.0), "foot@above": (0.7, 0.9, 0.3, 0.1)}


def test_a_view_has_its_own_crops() -> None:
    crops = {"rim": (0.0, 0.0, 1.0, 1.0), "foot@above": (0.0, 0.0, 0.5, 0.5)}
    assert of_view(crops, "main") == {"rim": crops["rim"]}
    assert of_view(crops, "above") == {"foot": crops["foot@above"]}


def test_a_catalog_knows_the_crops_of_known_scenes(tmp_path: Path) -> None:
    folder = write_scene(tmp_path, "{'rim': (0, 0, 0.5, 0.5)}")
    with Catalog([folder]) as catalog:
        found = catalog.crops(["mine", "gone.glb"])
    assert found == {"mine": {"rim": (0, 0, 0.5, 0.5)}}


def test_some_scenes_of_the_suite_have_crops() -> None:
    scenes = Collection.load().scenes
    assert sum(bool(scenes[name].crops) for name in scenes) >= 10
