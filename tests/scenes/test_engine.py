"""Engine: parts of partial coverage that are meshed and nested, close together in both views."""

from __future__ import annotations

import numpy as np

from oitbench.effects import Effect
from oitbench.modeling.placement import merge
from tests.meshes import bounds, count_hits, hits
from tests.scenes.helpers import build, named, view_distances, view_rays


def test_every_part_is_a_gray_or_colored_cover_that_transmits_nothing() -> None:
    scene = build("engine[detail=0.1]")
    assert scene.transparent == scene.objects
    assert scene.effects == Effect.COVERAGE
    for item in scene.objects:
        assert 0 < float(item.material.coverage) < 1  # type: ignore[arg-type]
        assert item.material.transmission == (0, 0, 0)


def test_a_ray_to_the_middle_crosses_many_close_layers() -> None:
    scene = build("engine[detail=0.1]")
    rays = view_rays(scene.camera, 10)
    whole = merge([item.mesh for item in scene.objects])
    layers = count_hits(whole, scene.camera.position, rays)
    assert layers.max() >= 26
    inner = layers.reshape(10, 10)[2:8, 3:7]
    assert inner.mean() > 11
    ray = np.subtract(scene.camera.target, scene.camera.position)
    gaps = np.diff(hits(whole, scene.camera.position, ray)) * np.linalg.norm(ray)
    assert np.median(gaps) < 0.02


def test_parts_are_nested_as_in_life() -> None:
    scene = build("engine[detail=0.1]")
    low, high = bounds(named(scene, "block").mesh)
    for name in ("pistons", "rods"):
        inner = bounds(named(scene, name).mesh)
        assert (inner[0] > low).all()
        assert (inner[1] < high).all()
    bore = named(scene, "liners").mesh.positions
    pistons = named(scene, "pistons").mesh.positions
    assert np.abs(pistons[:, 0]).max() < 0.04 < np.abs(bore[:, 0]).max()
    assert np.ptp(named(scene, "crankshaft").mesh.positions[:, 2]) < high[2] - low[2] + 0.02


def test_no_order_of_the_moving_parts_is_right() -> None:
    scene = build("engine[detail=0.1]")
    names = ("crankshaft", "rods", "block", "liners")
    spans = [view_distances(scene, named(scene, name).mesh) for name in names]
    for one in spans:
        for other in spans:
            assert one.min() < other.max()


def test_the_engine_is_as_large_as_in_life() -> None:
    meshes = [item.mesh.positions for item in build("engine[detail=0.1]").objects]
    size = np.ptp(np.concatenate(meshes), axis=0)
    assert (size > 0.4).all()
    assert (size < 0.8).all()
