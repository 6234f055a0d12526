"""References: storage, lookup, staleness and checks."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import msgspec
import numpy as np
import pytest

from oitbench.effects import Effect
from oitbench.errors import SceneError, UsageError
from oitbench.image import stored
from oitbench.modeling.mesh import sphere
from oitbench.path_traced.references import lookup, pieces, rendering, storage
from oitbench.path_traced.references.check import check, failure_folder
from oitbench.path_traced.references.storage import Reference, Rendering
from oitbench.path_traced.references.wanted import PART_SSAA, REFRACTED_SSAA
from oitbench.path_traced.references.z_test import z_test
from oitbench.path_traced.trace.render import Progress
from oitbench.path_traced.version import TRACER
from oitbench.places import own_folder
from oitbench.scene import Camera, DirectionalLight, Material, Medium, Object, Scene
from oitbench.truths import MATCHED
from tests.path_traced.agreement import needs_mitsuba
from tests.path_traced.stored import (
    KEY,
    LABEL,
    SIZE,
    make_matched,
    make_reference,
    make_scene,
    read_back,
    wanted,
)


def test_a_stored_reference_can_be_read(tmp_path: Path) -> None:
    scene = make_scene()
    reference = make_reference(scene)
    storage.save(tmp_path / "reference", reference)
    found = lookup.find(wanted(scene), [tmp_path])
    assert found.message == ""
    assert found.reference is not None
    assert found.reference.rendering == reference.rendering
    assert found.reference.noise_floor == reference.noise_floor
    expected = storage.stored_precision(reference)
    np.testing.assert_array_equal(found.reference.mean, expected.mean)
    np.testing.assert_allclose(expected.mean, reference.mean, rtol=2**-11)
    assert reference.variance is not None
    np.testing.assert_array_equal(found.reference.variance, reference.variance)
    assert found.reference.seconds == reference.seconds


def test_the_references_of_the_collection_are_intact_and_written_unchanged(tmp_path: Path) -> None:
    shipped = own_folder() / storage.FOLDER
    infos = storage.read_manifest(shipped)
    assert infos
    for info in infos.values():
        for image in info.images:
            stored.verify(shipped, image)
    named = {image.path for info in infos.values() for image in info.images}
    assert {path.name for path in shipped.glob("*.exr")} == named
    (tmp_path / storage.MANIFEST).write_bytes((shipped / storage.MANIFEST).read_bytes())
    reference = storage.read(shipped, next(iter(infos)))
    assert reference is not None
    storage.save(tmp_path, reference)
    for path in tmp_path.iterdir():
        assert path.read_bytes() == (shipped / path.name).read_bytes(), path.name


def test_a_radiance_beyond_half_floats_is_kept(tmp_path: Path) -> None:
    reference = make_reference(make_scene())
    bright = dataclasses.replace(reference, parts=(reference.mean * np.float32(1e6),))
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
    changed = {"parts": (image,)} if name == "mean" else {"variance": image}
    with pytest.raises(SceneError, match=message):
        dataclasses.replace(reference, **changed)


def test_an_image_of_another_size_is_refused() -> None:
    reference = make_reference(make_scene())
    with pytest.raises(SceneError, match="its mean is not 12x8 pixels"):
        dataclasses.replace(reference, parts=(reference.mean[:-1],))


def test_another_label_size_or_grid_is_not_found(tmp_path: Path) -> None:
    scene = make_scene()
    storage.save(tmp_path / "reference", make_reference(scene))
    nothing = lookup.Found(None)
    for other in (
        wanted(scene, label="window"),
        wanted(scene, size=(8, 12)),
        wanted(scene, ssaa=1),
        wanted(scene, MATCHED),
    ):
        assert lookup.find(other, [tmp_path]) == nothing
    assert lookup.find(wanted(scene), [tmp_path / "none"]) == nothing


@pytest.mark.parametrize("changed", ["scene", "tracer", "effects"])
def test_a_stale_reference_is_reported_and_not_used(
    changed: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    reference = make_reference(make_scene())
    if changed == "effects":
        how = msgspec.structs.replace(reference.rendering, effects=["COVERAGE", "VOLUME"])
        reference = dataclasses.replace(reference, rendering=how)
    storage.save(tmp_path / "reference", reference)
    scene = make_scene(coverage=0.5 + 1e-7 if changed == "scene" else 0.5)
    if changed == "tracer":
        monkeypatch.setattr(lookup, "TRACER", TRACER + 1)
    found = lookup.find(wanted(scene), [tmp_path])
    assert found.reference is None
    part = {"scene": "the scene", "tracer": "the path tracer", "effects": "the set of effects"}
    assert f"{KEY}: {part[changed]} has changed since" in found.message
    assert f"run 'oitbench reference {LABEL}'" in found.message
    assert found.stale is not None
    assert found.stale[0] == tmp_path / "reference"


def test_a_stale_reference_can_be_adopted(tmp_path: Path) -> None:
    before, now = make_scene(), make_scene(coverage=0.501)
    folder = tmp_path / "reference"
    storage.save(folder, make_reference(before))
    images = {path.name: path.read_bytes() for path in folder.glob("*.exr")}
    found = lookup.find(wanted(now), [tmp_path])
    assert found.stale is not None
    lookup.adopt(now, *found.stale)
    assert lookup.find(wanted(now), [tmp_path]).message == ""
    assert lookup.find(wanted(before), [tmp_path]).reference is None
    assert {path.name: path.read_bytes() for path in folder.glob("*.exr")} == images
    with pytest.raises(UsageError, match=r"entry other@12x8\.full is missing or damaged"):
        storage.adopt(folder, "other@12x8.full", found.stale[1].rendering)


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


def test_the_noise_floor_is_half_the_difference_of_the_halves() -> None:
    first = np.full((16, 16, 3), 0.5, dtype=np.float32)
    second = first + np.float32(0.25)
    floor = pieces.noise_floor((first, second), 0.0)
    assert floor["rmse_lin"] == pytest.approx(0.125)
    assert floor["flip_hdr@67ppd"] is not None
    flip = floor["flip_ldr@67ppd"]
    assert flip is not None
    assert flip > 0.01
    none = pieces.noise_floor((first, first), 0.0)
    assert set(none.values()) == {0}


@needs_mitsuba
def test_a_reference_is_rendered_once_and_every_method_gets_the_stored_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    shipped = tmp_path / "collection"
    scene = make_scene()
    storage.save(shipped / "reference", make_reference(make_scene(coverage=0.4)))
    rendered: list[str] = []

    def render_reference(scene: Scene, planned: Rendering, progress: Progress) -> Reference:
        rendered.append(planned.key)
        return rendering.render_reference(scene, planned, progress)

    monkeypatch.setattr(lookup, "render_reference", render_reference)

    def obtain(scene: Scene, *folders: Path) -> tuple[Reference, str]:
        return lookup.find_or_render(wanted(scene), folders)

    first, message = obtain(scene, shipped)
    assert rendered == [KEY]
    assert "has changed" in message
    second, same = obtain(scene, shipped)
    third, none = obtain(scene)
    assert rendered == [KEY]
    assert (same, none) == (message, "")
    for other in (second, third):
        np.testing.assert_array_equal(other.mean, first.mean)
    assert set(second.noise_floor.values()) == {0}
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
    reference, message = lookup.find_or_render(wanted(make_scene()), [])
    assert "not cached" in message
    assert reference.mean.shape == (SIZE[1], SIZE[0], 3)
    np.testing.assert_array_equal(reference.mean, storage.stored_precision(reference).mean)


@needs_mitsuba
def test_a_check_fails_on_a_changed_mean_and_writes_images(tmp_path: Path) -> None:
    scene = make_scene()
    planned = rendering.plan_rendering(wanted(scene))
    storage.save(tmp_path, rendering.render_reference(scene, planned))
    back = read_back(tmp_path)
    assert check(scene, back, tmp_path / "out").passed
    assert not (tmp_path / "out").exists()
    bad = dataclasses.replace(back, parts=(back.mean + np.float32(0.02),))
    assert not check(scene, bad, tmp_path / "out").passed
    names = {path.name for path in failure_folder(tmp_path / "out", back).iterdir()}
    kinds = ("image", "reference", "error", "p_value")
    assert names == {f"{kind}.{suffix}" for kind in kinds for suffix in ("exr", "png")}


@pytest.mark.parametrize("parts", [1, 8])
def test_the_parts_of_a_matched_reference_are_kept_apart(parts: int, tmp_path: Path) -> None:
    scene = make_scene()
    reference = make_matched(scene, parts)
    storage.save(tmp_path / "reference", reference)
    assert len(list((tmp_path / "reference").glob("*.exr"))) == parts
    found = lookup.find(wanted(scene, MATCHED), [tmp_path]).reference
    assert found is not None
    assert found.rendering.key == KEY.replace("full", "matched")
    assert len(found.parts) == parts
    for part, expected in zip(found.parts, reference.parts, strict=True):
        np.testing.assert_allclose(part, expected, rtol=2**-11)
    mean = np.mean(np.stack(reference.parts), axis=0)
    np.testing.assert_allclose(found.mean, mean, rtol=2**-10)
    with pytest.raises(SceneError, match="it has 2 parts"):
        dataclasses.replace(reference, parts=reference.parts[:1] * 2)


def test_matched_and_full_references_of_a_scene_stand_side_by_side(tmp_path: Path) -> None:
    scene = make_scene()
    for reference in (make_reference(scene), make_matched(scene), make_matched(scene, 1)):
        storage.save(tmp_path, reference)
    # The second matched one has replaced the first.
    assert len(list(tmp_path.glob("*.exr"))) == 3
    assert read_back(tmp_path).variance is not None


def test_the_main_view_is_never_stored_however_its_name_was_made() -> None:
    plain = make_reference(make_scene()).rendering
    named = msgspec.convert({**msgspec.to_builtins(plain), "view": "".join("main")}, Rendering)
    assert named == plain
    assert msgspec.json.encode(named) == msgspec.json.encode(plain)


def glass(medium: Medium | None = None) -> Scene:
    """Return a refracting ball, in fog if there is a medium."""
    material = Material(coverage=1.0, transmission=(0.9, 0.9, 0.9), index=1.5, solid=True)
    ball = Object("ball", sphere((0.0, 0.0, 0.0), 0.5, 8, 4), material)
    sun = DirectionalLight((0.0, -1.0, 0.0), (1.0, 1.0, 1.0))
    return Scene(
        LABEL, Camera((0.0, 0.0, 4.0)), (ball,), lights=(sun,) if medium else (), medium=medium
    )


def test_refraction_takes_a_fine_grid_unless_it_is_left_out() -> None:
    scene = glass()
    assert wanted(scene, MATCHED).grid == REFRACTED_SSAA
    assert wanted(scene, MATCHED, ssaa=16).grid == 16
    fog = Medium(0.1, (-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
    assert wanted(glass(fog), MATCHED).grid == PART_SSAA
    assert wanted(scene).grid == 2
    without = wanted(scene, MATCHED, chosen=~Effect.REFRACTION)
    assert without.grid == 2
    assert without.key == "window[seed=2]@12x8.matched-refraction"
    # Nothing is left out of a full reference, and coverage never.
    assert wanted(scene, chosen=Effect.NONE).key == KEY
    assert "COVERAGE" not in wanted(scene, MATCHED, chosen=Effect.NONE).left_out


@needs_mitsuba
def test_only_pictures_with_random_numbers_have_parts() -> None:
    plain = rendering.plan_rendering(wanted(glass(), MATCHED), spp=5)
    assert (plain.parts, plain.spp) == (1, 1)
    fog = Medium(1.0, (-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
    foggy = rendering.plan_rendering(wanted(glass(fog), MATCHED), spp=5)
    assert (foggy.parts, foggy.spp) == (8, 5)
    clear = wanted(glass(fog), MATCHED, chosen=~(Effect.VOLUME | Effect.CAUSTICS))
    assert rendering.plan_rendering(clear).parts == 1
    assert clear.key.endswith(".matched-caustics-volume")


@needs_mitsuba
def test_a_matched_picture_has_no_floor_or_that_of_its_parts(tmp_path: Path) -> None:
    scene = make_scene()
    plain = rendering.render_reference(scene, rendering.plan_rendering(wanted(scene, MATCHED)))
    assert set(plain.noise_floor.values()) == {0}
    assert plain.seconds > 0
    storage.save(tmp_path, plain)
    back = read_back(tmp_path, plain.rendering.key)
    assert check(scene, back, tmp_path / "out").passed
    bad = dataclasses.replace(back, parts=(back.mean + np.float32(0.02),))
    assert not check(scene, bad, tmp_path / "out").passed
    floor = pieces.noise_floor(make_matched(scene).parts, 0.0)
    # Uniform noise has a deviation of 1/√12, and the mean of eight a √8 times smaller one.
    assert floor["rmse_lin"] == pytest.approx(1 / (12 * 8) ** 0.5, rel=0.1)
