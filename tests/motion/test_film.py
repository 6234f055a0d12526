"""Filming methods along a path: what pops, what flickers and what stays steady."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from oitbench.gl.device import Device
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.image import files, stored
from oitbench.image.files import Image
from oitbench.image.stored import StoredImage
from oitbench.motion import film as filming
from oitbench.motion.film import Set, Shot, exact_changes, film, reseeded
from oitbench.motion.metrics import VISIBLE
from oitbench.motion.record import FIXED, PER_FRAME, MotionFile, Track
from oitbench.results.schema import Renderer
from oitbench.scene import Scene
from oitbench.scene.paths import orbit
from oitbench.shading import DEFAULT, read_shading
from tests.helpers import collection, method
from tests.motion.scenes import cameras, crossing

SIZE = (32, 32)
NOWHERE = StoredImage("frames/a.exr", "0" * 64, 1)
PATH = cameras()


@pytest.fixture
def stage(device: Device) -> Iterator[Set]:
    with Set(device, crossing(), SIZE, 1, DEFAULT, collection().truth()) as found:
        yield found


@pytest.fixture
def shots(stage: Set) -> list[Shot]:
    return [stage.exact(camera) for camera in PATH]


def track(stage: Set, shots: list[Shot], name: str, per_frame: bool = False) -> Track:
    return film(stage, method(name), PATH, shots, lambda k, image: NOWHERE, per_frame=per_frame)


def verdicts(shots: list[Shot], *tracks: Track) -> list[list[str]]:
    changes = exact_changes(shots)
    found = MotionFile(Renderer("r"), "s", SIZE, 1, 0.0, "", "main", [], [], changes, list(tracks))
    return [found.verdicts(track) for track in tracks]


def test_exact_compositing_neither_pops_nor_flickers(stage: Set, shots: list[Shot]) -> None:
    found = track(stage, shots, "a_buffer")
    # The truth has half floats no more than this method has.
    assert found.worst_flicker < 1e-3
    assert found.flip == pytest.approx([0] * 6, abs=1e-3)
    assert verdicts(shots, found) == [["steady"]]
    assert max(exact_changes(shots)) > 0.01


def test_sorting_by_objects_pops_where_the_order_flips(stage: Set, shots: list[Shot]) -> None:
    found = track(stage, shots, "sorted_over[sort=object]")
    assert found.worst_pop is not None
    assert found.worst_pop.transition == 2
    # Of α L (1 − α), one color replaces the other: 0.25 of linear light.
    assert found.worst_pop.popping > 0.1
    assert found.worst_pop.popping == pytest.approx(found.jumps[2], rel=0.3)
    assert "pops" in verdicts(shots, found)[0]
    # On one side of the flip the order is right.
    flips = sorted(flip or 0 for flip in found.flip)
    assert flips[2] < 0.01 < flips[3]


def test_a_wrong_order_that_stays_does_not_pop(stage: Set, shots: list[Shot]) -> None:
    found = track(stage, shots, "alpha_blend")
    assert min(flip or 0 for flip in found.flip) > 0.01
    assert all(pop.popping < VISIBLE for pop in found.pops)
    assert verdicts(shots, found) == [["steady"]]


def test_random_numbers_flicker_unless_they_stay(stage: Set, shots: list[Shot]) -> None:
    name = "stochastic[samples=4,correction=none]"
    fixed, changing = track(stage, shots, name), track(stage, shots, name, per_frame=True)
    assert (fixed.seeds, changing.seeds) == (FIXED, PER_FRAME)
    assert not any(pop.popping for pop in fixed.pops)
    assert changing.pops == []
    assert fixed.rest is None
    assert changing.rest is not None
    assert changing.rest > VISIBLE
    assert changing.mean_flicker > 1.5 * fixed.mean_flicker
    assert "flickers" in verdicts(shots, changing)[0]


def test_each_frame_has_another_seed() -> None:
    chosen = method("stochastic[seed=65534]")
    assert [reseeded(chosen, k).values["seed"] for k in range(3)] == [65534, 65535, 0]


def test_frames_are_those_of_a_camera_that_was_always_there(
    stage: Set, shots: list[Shot], device: Device
) -> None:
    for camera, shot in ((PATH[0], shots[0]), (PATH[5], shots[5])):
        there = replace(crossing(), camera=camera)
        with Set(device, there, SIZE, 1, DEFAULT, collection().truth()) as alone:
            expected = alone.exact(camera)
        np.testing.assert_allclose(shot.linear, expected.linear, atol=1e-5)
        np.testing.assert_array_equal(shot.transparent, expected.transparent)


def test_geometry_is_uploaded_once(device: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    uploads: list[Scene] = []

    def counted(device: Device, scene: Scene, *rest: object) -> object:
        uploads.append(scene)
        return UploadedScene(device, scene, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(filming, "UploadedScene", counted)
    with Set(device, crossing(), SIZE, 1, DEFAULT, collection().truth()) as stage:
        for camera in PATH:
            stage.exact(camera)
            stage.picture(method("alpha_blend"), camera)
    assert len(uploads) == 1


def test_sprites_face_the_camera_of_each_frame(device: Device) -> None:
    scene = collection().build_scene("smoke_ball[detail=0.05]")
    shading = read_shading("shadow_map=64,slices=4")
    first, second = orbit(scene.camera, 2, 0.5)
    with Set(device, scene, SIZE, 1, shading, collection().truth()) as stage:
        stage.exact(first)
        found = stage.exact(second)
    there = replace(scene, camera=second)
    with Set(device, there, SIZE, 1, shading, collection().truth()) as alone:
        np.testing.assert_array_equal(found.linear, alone.exact(second).linear)


def test_frames_are_kept_in_order(stage: Set, shots: list[Shot], tmp_path: Path) -> None:
    def keep(number: int, image: Image) -> StoredImage:
        return stored.store(tmp_path, f"frames/{number}", files.image_channels(image))

    found = film(stage, method("alpha_blend"), PATH, shots, keep)
    pictures = [files.read_exr(stored.verify(tmp_path, image)) for image in found.frames]
    expected = [stage.picture(method("alpha_blend"), camera) for camera in PATH]
    np.testing.assert_array_equal(np.stack(pictures), np.stack(expected))


def test_sub_pixels_are_averaged(device: Device) -> None:
    with Set(device, crossing(), (8, 8), 4, DEFAULT, collection().truth()) as stage:
        coarse = stage.exact(PATH[0])
    with Set(device, crossing(), SIZE, 1, DEFAULT, collection().truth()) as stage:
        fine = stage.exact(PATH[0])
    np.testing.assert_array_equal(coarse.linear, files.box_downsample(fine.linear, 4))
    blocks = fine.transparent.reshape(8, 4, 8, 4)
    np.testing.assert_array_equal(coarse.transparent, blocks.any(axis=(1, 3)))
