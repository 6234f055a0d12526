"""References: storage, lookup, staleness and checks."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from oitbench.errors import SceneError, UsageError
from oitbench.image import stored
from oitbench.path_traced.references import lookup, rendering, storage
from oitbench.path_traced.references.check import check, failure_folder
from oitbench.path_traced.references.storage import Reference, Rendering
from oitbench.path_traced.references.z_test import z_test
from oitbench.path_traced.trace.render import Estimate
from oitbench.path_traced.version import TRACER
from oitbench.places import own_folder
from oitbench.scene import Scene
from tests.path_traced.agreement import needs_mitsuba
from tests.path_traced.stored import KEY, LABEL, SIZE, make_reference, make_scene, read_back


def test_a_stored_reference_can_be_read(tmp_path: Path) -> None:
    scene = make_scene()
    reference = make_reference(scene)
    storage.save(tmp_path / "reference", reference)
    found = lookup.find(scene, LABEL, SIZE, 2, [tmp_path])
    assert found.message == ""
    assert found.reference is not None
    assert found.reference.rendering == reference.rendering
    assert found.reference.noise_floor == reference.noise_floor
    expected = storage.stored_precision(reference)
    np.testing.assert_array_equal(found.reference.mean, expected.mean)
    np.testing.assert_allclose(expected.mean, reference.mean, rtol=2**-11)
    np.testing.assert_array_equal(found.reference.variance, reference.variance)


def test_the_references_of_the_collection_are_intact_and_written_unchanged(tmp_path: Path) -> None:
    shipped = own_folder() / storage.FOLDER
    infos = storage.read_manifest(shipped)
    assert infos
    for info in infos.values():
        for image in (info.mean, info.variance):
            stored.verify(shipped, image)
    named = {image.path for info in infos.values() for image in (info.mean, info.variance)}
    assert {path.name for path in shipped.glob("*.exr")} == named
    (tmp_path / storage.MANIFEST).write_bytes((shipped / storage.MANIFEST).read_bytes())
    known = next(iter(infos.values())).rendering
    reference = storage.read(shipped, known.scene, known.size)
    assert reference is not None
    storage.save(tmp_path, reference)
    for path in tmp_path.iterdir():
        assert path.read_bytes() == (shipped / path.name).read_bytes(), path.name


def test_a_radiance_beyond_half_floats_is_kept(tmp_path: Path) -> None:
    reference = make_reference(make_scene())
    bright = dataclasses.replace(reference, mean=reference.mean * np.float32(1e6))
    storage.save(tmp_path, bright)
    np.testing.assert_array_equal(read_back(tmp_path).mean, bright.mean)
    np.testing.assert_array_equal(storage.stored_precision(bright).mean, bright.mean)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("mean", np.nan, "its mean holds NaN or infinity"),
        ("mean", np.inf, "its mean holds NaN or infinity"),
        ("variance", np.nan, "its variance holds NaN or infinity"),
        ("variance", -1e-12, "its variance is negative"),
    ],
)
def test_impossible_values_are_refused(name: str, value: float, message: str) -> None:
    reference = make_reference(make_scene())
    image = getattr(reference, name).copy()
    image[3, 4, 1] = value
    with pytest.raises(SceneError, match=message):
        dataclasses.replace(reference, **{name: image})


def test_an_image_of_another_size_is_refused() -> None:
    reference = make_reference(make_scene())
    with pytest.raises(SceneError, match="its mean is not 12x8 pixels"):
        dataclasses.replace(reference, mean=reference.mean[:-1])


def test_another_label_size_or_grid_is_not_found(tmp_path: Path) -> None:
    scene = make_scene()
    storage.save(tmp_path / "reference", make_reference(scene))
    nothing = lookup.Found(None)
    assert lookup.find(scene, "window", SIZE, 2, [tmp_path]) == nothing
    assert lookup.find(scene, LABEL, (8, 12), 2, [tmp_path]) == nothing
    assert lookup.find(scene, LABEL, SIZE, 1, [tmp_path]) == nothing
    assert lookup.find(scene, LABEL, SIZE, 2, [tmp_path / "none"]) == nothing


@pytest.mark.parametrize("changed", ["scene", "tracer"])
def test_a_stale_reference_is_reported_and_not_used(
    changed: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    storage.save(tmp_path / "reference", make_reference(make_scene()))
    scene = make_scene(coverage=0.5 + 1e-7 if changed == "scene" else 0.5)
    if changed == "tracer":
        monkeypatch.setattr(lookup, "TRACER", TRACER + 1)
    found = lookup.find(scene, LABEL, SIZE, 2, [tmp_path])
    assert found.reference is None
    part = {"scene": "the scene", "tracer": "the path tracer"}[changed]
    assert f"{KEY}: {part} has changed since" in found.message
    assert f"run 'oitbench reference {LABEL}'" in found.message
    assert found.stale is not None
    assert found.stale[0] == tmp_path / "reference"


def test_a_stale_reference_can_be_adopted(tmp_path: Path) -> None:
    before, now = make_scene(), make_scene(coverage=0.501)
    folder = tmp_path / "reference"
    storage.save(folder, make_reference(before))
    images = {path.name: path.read_bytes() for path in folder.glob("*.exr")}
    found = lookup.find(now, LABEL, SIZE, 2, [tmp_path])
    assert found.stale is not None
    lookup.adopt(now, *found.stale)
    assert lookup.find(now, LABEL, SIZE, 2, [tmp_path]).message == ""
    assert lookup.find(before, LABEL, SIZE, 2, [tmp_path]).reference is None
    assert {path.name: path.read_bytes() for path in folder.glob("*.exr")} == images
    with pytest.raises(UsageError, match="entry other@12x8 is missing or damaged"):
        storage.adopt(folder, "other@12x8", found.stale[1].rendering)


def test_z_test_passes_noise_and_fails_a_shift() -> None:
    random = np.random.default_rng(4)
    truth = random.random((64, 64, 3)).astype(np.float32)
    sigma = 0.01
    noisy = (truth + sigma * random.standard_normal(truth.shape)).astype(np.float32)
    variance = np.full(truth.shape, sigma**2)
    result = z_test(noisy, truth, variance)
    assert result.passed
    assert result.fraction == 1
    shifted = noisy.copy()
    shifted[:1] += np.float32(0.1)
    result = z_test(shifted, truth, variance)
    assert not result.passed
    assert 0.98 < result.fraction < 0.99
    assert result.p_value.shape == (64, 64)
    few = noisy.copy()
    few[0, :8] += np.float32(0.1)
    assert z_test(few, truth, variance).passed


def test_without_noise_the_z_test_accepts_rounding_to_half_floats_only() -> None:
    truth = np.random.default_rng(4).uniform(0, 50, (16, 16, 3)).astype(np.float32)
    half = truth.astype(np.float16).astype(np.float32)
    variance = np.zeros(truth.shape)
    assert z_test(truth, half, variance).passed
    assert not z_test(truth * np.float32(1.01), half, variance).passed


def test_the_noise_floor_is_the_error_between_the_halves() -> None:
    first = np.full((16, 16, 3), 0.5, dtype=np.float32)
    second = first + np.float32(0.25)
    floor = rendering.noise_floor(Estimate(first, first, (first, second), 2), 0.0)
    assert floor["rmse_lin"] == pytest.approx(0.25)
    flip = floor["flip_ldr@67ppd"]
    assert flip is not None
    assert flip > 0.01
    none = rendering.noise_floor(Estimate(first, first, (first, first), 2), 0.0)
    assert none == {"flip_ldr@67ppd": 0, "rmse_lin": 0}


@needs_mitsuba
def test_a_reference_is_rendered_once_and_every_method_gets_the_stored_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    shipped = tmp_path / "collection"
    scene = make_scene()
    storage.save(shipped / "reference", make_reference(make_scene(coverage=0.4)))
    rendered: list[str] = []

    def render_reference(scene: Scene, wanted: Rendering) -> Reference:
        rendered.append(wanted.key)
        return rendering.render_reference(scene, wanted)

    monkeypatch.setattr(lookup, "render_reference", render_reference)

    def obtain(scene: Scene, *folders: Path) -> tuple[Reference, str]:
        return lookup.find_or_render(scene, LABEL, SIZE, 2, folders)

    first, message = obtain(scene, shipped)
    assert rendered == [KEY]
    assert "has changed" in message
    second, same = obtain(scene, shipped)
    third, none = obtain(scene)
    assert rendered == [KEY]
    assert (same, none) == (message, "")
    for other in (second, third):
        np.testing.assert_array_equal(other.mean, first.mean)
    assert second.noise_floor == {"flip_ldr@67ppd": 0, "rmse_lin": 0}
    # Another tracer, and another scene of the same label, have references of their own.
    obtain(make_scene(coverage=0.5 + 1e-7))
    assert len(rendered) == 2
    monkeypatch.setattr(rendering, "TRACER", TRACER + 1)
    obtain(scene)
    assert len(rendered) == 3
    monkeypatch.undo()
    storage.save(shipped / "reference", make_reference(scene))
    assert obtain(scene, shipped)[0].rendering.spp == 16


@needs_mitsuba
def test_a_cache_that_cannot_be_written_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    reference, message = lookup.find_or_render(make_scene(), LABEL, SIZE, 2, [])
    assert "not cached" in message
    assert reference.mean.shape == (SIZE[1], SIZE[0], 3)
    np.testing.assert_array_equal(reference.mean, storage.stored_precision(reference).mean)


@needs_mitsuba
def test_a_check_fails_on_a_changed_mean_and_writes_images(tmp_path: Path) -> None:
    scene = make_scene()
    wanted = rendering.plan_rendering(scene, LABEL, SIZE, 2)
    storage.save(tmp_path, rendering.render_reference(scene, wanted))
    back = read_back(tmp_path)
    assert check(scene, back, tmp_path / "out").passed
    assert not (tmp_path / "out").exists()
    bad = dataclasses.replace(back, mean=back.mean + np.float32(0.02))
    assert not check(scene, bad, tmp_path / "out").passed
    names = {path.name for path in failure_folder(tmp_path / "out", back).iterdir()}
    kinds = ("image", "reference", "error", "p_value")
    assert names == {f"{kind}.{suffix}" for kind in kinds for suffix in ("exr", "png")}
