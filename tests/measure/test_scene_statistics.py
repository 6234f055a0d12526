"""Statistics of scenes: geometry, fragments and depth complexity."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from oitbench.catalog.catalog import Catalog, Choice
from oitbench.gl.device import Device
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.measure import scene_statistics, survey
from oitbench.measure.survey import SceneView
from oitbench.modeling.mesh import quad
from oitbench.results.statistics import SceneStatistics
from oitbench.scene import Camera, Material, Object, Scene
from oitbench.workers import memory
from tests.helpers import WHITE, collection, opened, random_lists, scene_of

SIZE = (16, 8)
GLASS, WALL = Material(coverage=0.5, emission=WHITE), Material(emission=WHITE)


def panes() -> Scene:
    """Three panes on the left half of the picture; the farthest is behind a wall."""
    left = [
        Object(f"pane {k}", quad((-9, 0, z), (9, 0, 0), (0, 9, 0)), GLASS)
        for k, z in enumerate((-1.0, -2.0, -4.0))
    ]
    wall = Object("wall", quad((0, 0, -3), (99, 0, 0), (0, 99, 0)), WALL)
    return Scene("panes", Camera((0, 0, 0), (0, 0, -1)), (*left, wall))


def measured(device: Device, scene: Scene) -> SceneStatistics:
    with UploadedScene(device, scene) as uploaded:
        return scene_statistics.measure(uploaded, SIZE)


def test_geometry_and_visible_fragments_are_counted(device: Device) -> None:
    found = measured(device, panes())
    assert (found.objects, found.transparent_objects, found.draws) == (4, 3, 4)
    assert (found.triangles, found.transparent_triangles) == (8, 6)
    # The wall hides one of three panes.
    assert (found.fragments, found.covered_pixels) == (2 * 64, 64)
    assert found.complexity.histogram == [(0, 64), (2, 64)]
    assert (found.complexity.mean, found.complexity.median, found.complexity.worst) == (2, 2, 2)


def test_named_views_are_measured_and_eyes_are_not() -> None:
    above = Camera((0, 5, -2), (0, 0, -2))
    found = scene_statistics.views_of(replace(panes(), views={"above": above}))
    assert list(found) == ["main", "above"]
    assert found["above"].camera == above


def test_strands_are_as_wide_as_pixels_of_the_frame(device: Device) -> None:
    scene = collection().build_scene("hair[detail=0.002]")
    with UploadedScene(device, scene, rows=SIZE[1]) as uploaded:
        found = scene_statistics.measure(uploaded, SIZE)
    assert found.transparent_triangles > 0


def test_each_layer_of_lists_is_a_draw(device: Device) -> None:
    scene = scene_of(random_lists(5))
    with UploadedScene(device, scene) as uploaded:
        found = scene_statistics.measure(uploaded, (16, 16))
    assert (found.objects, found.triangles, found.draws) == (0, 0, 5)
    assert found.fragments == 5 * 256


def test_frames_and_statistics_share_one_count(device: Device) -> None:
    with opened(device, panes(), "a_buffer", SIZE) as frame:
        found = scene_statistics.measure(frame.scene, SIZE, frame.plan.effects)
        assert frame.scene.fragment_counts(SIZE, frame.plan.effects) is frame.complexity
    assert found.fragments == frame.complexity.sum()


def test_median_and_mean_are_those_of_covered_pixels() -> None:
    found = scene_statistics.describe(np.array([[0, 0, 0, 0], [1, 1, 2, 8]]))
    assert (found.mean, found.median, found.worst) == (3.0, 1.5, 8)
    assert found.histogram == [(0, 4), (1, 2), (2, 1), (8, 1)]


def test_an_empty_picture_has_no_mean() -> None:
    found = scene_statistics.describe(np.zeros((2, 2), np.int64))
    assert (found.mean, found.median, found.worst) == (None, None, 0)


def test_a_scene_that_fails_costs_only_its_row() -> None:
    with Catalog() as catalog:
        chosen = [
            Choice("broken", "broken", "no such thing"),
            Choice("layer_stack[count=-1]", "layer_stack"),
            *catalog.expand_scenes(["layer_stack[count=3]"]),
        ]
        rows = list(survey.survey(catalog, chosen, SIZE, memory.share(1)))
    assert rows[0] == SceneView("broken", error="no such thing")
    assert "count" in rows[1].error
    assert rows[2].statistics is not None
    assert rows[2].statistics.fragments == 3 * 128
    assert (rows[2].view, rows[2].effects) == ("main", ("coverage",))
    lines = survey.table(rows, SIZE).splitlines()
    assert len(lines) == 3
    assert lines[2].startswith("| `layer_stack[count=3]` | main | 3 | 6 | 6 | 3 | 384 | 100.0 % |")


@pytest.mark.parametrize("size", [(10**6, 1)])
def test_a_size_beyond_the_driver_is_a_reason(size: tuple[int, int]) -> None:
    with Catalog() as catalog:
        chosen = catalog.expand_scenes(["layer_stack"])
        (row,) = survey.survey(catalog, chosen, size, memory.share(1))
    assert "driver's limit" in row.error
