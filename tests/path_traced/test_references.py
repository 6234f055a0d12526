"""References: storage, lookup, staleness and checks."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from oitbench.path_traced.references.fingerprint import fingerprint

from oitbench.errors import UsageError
from oitbench.path_traced.references import lookup, rendering, storage
from oitbench.path_traced.references.check import check
from oitbench.path_traced.references.storage import Reference, ReferenceInfo
from oitbench.path_traced.references.z_test import z_test
from oitbench.path_traced.trace.render import Estimate
from oitbench.places import own_folder
from oitbench.scene import Camera, Material, Mesh, Object, Scene, Texture
from tests.path_traced.agreement import needs_mitsuba

SIZE = (12, 8)
LABEL = "window[seed=2]"


def _scene(coverage: float | Texture = 0.5, exposure: float = 0.0) -> Scene:
    corners = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], dtype=np.float32)
    mesh = Mesh(
        corners,
        np.array([(0, 1, 2), (0, 2, 3)], dtype=np.uint32),
        (corners[:, :2] / 2 + 0.5).astype(np.float32),
    )
    film = Object("film", mesh, Material(coverage, emission=(1.0, 0.25, 0.0)))
    return Scene(
        LABEL, Camera((0.0, 0.0, 4.0)), (film,), background=(0.1, 0.2, 0.3), exposure=exposure
    )


def _reference(scene: Scene, seed: int = 7) -> Reference:
    random = np.random.default_rng(seed)
    info = ReferenceInfo(
        scene=LABEL,
        size=SIZE,
        ssaa=2,
        spp=16,
        seed=seed,
        mitsuba="3.9.1",
        fingerprint=fingerprint(scene),
        noise_floor={"flip_ldr@67ppd": 0.001, "rmse_lin": None},
    )
    return Reference(
        info,
        mean=random.random((SIZE[1], SIZE[0], 3)).astype(np.float32),
        variance=(1e-9 * random.random((SIZE[1], SIZE[0], 3))).astype(np.float32),
    )


def test_a_stored_reference_can_be_read(tmp_path: Path) -> None:
    scene = _scene()
    reference = _reference(scene)
    storage.save(tmp_path / "reference", reference)
    found = lookup.find(scene, LABEL, SIZE, 2, [tmp_path])
    assert found is not None
    assert found.info == reference.info
    assert not found.stale
    np.testing.assert_allclose(found.mean, reference.mean, rtol=2**-11)
    np.testing.assert_array_equal(found.variance, reference.variance)


def test_the_manifests_of_the_collection_can_be_read_and_written_unchanged(tmp_path: Path) -> None:
    shipped = own_folder() / storage.FOLDER
    infos = storage.read_manifest(shipped)
    assert infos
    for info in infos.values():
        assert (shipped / f"{info.key}.mean.exr").is_file()
    (tmp_path / storage.MANIFEST).write_bytes((shipped / storage.MANIFEST).read_bytes())
    info = next(iter(infos.values()))
    reference = storage.read(shipped, info.scene, info.size)
    assert reference is not None
    storage.save(tmp_path, reference)
    for path in tmp_path.iterdir():
        assert path.read_bytes() == (shipped / path.name).read_bytes(), path.name


def test_a_radiance_beyond_half_floats_is_kept(tmp_path: Path) -> None:
    reference = _reference(_scene())
    bright = dataclasses.replace(reference, mean=reference.mean * np.float32(1e6))
    storage.save(tmp_path, bright)
    found = storage.read(tmp_path, LABEL, SIZE)
    assert found is not None
    np.testing.assert_array_equal(found.mean, bright.mean)


def test_another_label_size_or_grid_is_not_found(tmp_path: Path) -> None:
    scene = _scene()
    storage.save(tmp_path / "reference", _reference(scene))
    assert lookup.find(scene, "window", SIZE, 2, [tmp_path]) is None
    assert lookup.find(scene, LABEL, (8, 12), 2, [tmp_path]) is None
    assert lookup.find(scene, LABEL, SIZE, 1, [tmp_path]) is None
    assert lookup.find(scene, LABEL, SIZE, 2, [tmp_path / "none"]) is None


def test_a_changed_scene_makes_its_reference_stale(tmp_path: Path) -> None:
    storage.save(tmp_path / "reference", _reference(_scene()))
    found = lookup.find(_scene(coverage=0.501), LABEL, SIZE, 2, [tmp_path])
    assert found is not None
    assert found.stale
    assert "has changed" in found.message


def test_the_fingerprint_depends_on_every_value_but_the_name() -> None:
    scene = _scene()
    mesh = scene.objects[0].mesh
    moved = mesh.positions.copy()
    moved[2, 1] += np.float32(1e-4)
    other = dataclasses.replace(scene.objects[0], mesh=dataclasses.replace(mesh, positions=moved))
    texels = np.full((2, 2), 0.5, dtype=np.float32)
    changed = [
        _scene(coverage=0.6),
        _scene(exposure=1.0),
        _scene(coverage=Texture(texels)),
        _scene(coverage=Texture(texels.repeat(2, axis=0))),
        dataclasses.replace(scene, objects=(other,)),
        dataclasses.replace(scene, camera=Camera((0.0, 0.0, 4.0), near=0.2)),
    ]
    digests = [fingerprint(item) for item in (scene, *changed)]
    assert len(set(digests)) == len(digests)
    assert fingerprint(dataclasses.replace(scene, name="other")) == digests[0]
    assert fingerprint(_scene(coverage=0.5 + 1e-9)) == digests[0]


def test_a_damaged_manifest_is_reported_with_the_fix(tmp_path: Path) -> None:
    scene = _scene()
    storage.save(tmp_path / "reference", _reference(scene))
    path = tmp_path / "reference" / storage.MANIFEST
    whole = path.read_text()
    path.write_text(whole[: len(whole) // 2])
    with pytest.raises(UsageError, match="damaged; restore it, or delete it"):
        lookup.find(scene, LABEL, SIZE, 2, [tmp_path])
    path.write_text(json.dumps({"version": 99, "references": {}}))
    with pytest.raises(UsageError, match="version 99"):
        storage.read_manifest(path.parent)
    manifest = json.loads(whole)
    del manifest["references"][storage.reference_key(LABEL, SIZE)]["spp"]
    path.write_text(json.dumps(manifest))
    with pytest.raises(UsageError, match=r"window\[seed=2\]@12x8 is damaged; delete the entry"):
        storage.read(path.parent, LABEL, SIZE)
    manifest["references"] = {"other@12x8": json.loads(whole)["references"]["window[seed=2]@12x8"]}
    path.write_text(json.dumps(manifest))
    with pytest.raises(UsageError, match="other@12x8 is damaged"):
        storage.read_manifest(path.parent)


def test_a_missing_image_is_an_error(tmp_path: Path) -> None:
    reference = _reference(_scene())
    storage.save(tmp_path, reference)
    (tmp_path / f"{reference.info.key}.mean.exr").unlink()
    with pytest.raises(UsageError, match="no such image"):
        storage.read(tmp_path, LABEL, SIZE)


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
def test_a_reference_is_rendered_once_and_a_stale_one_is_not_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    shipped = tmp_path / "collection"
    scene = _scene()
    storage.save(shipped / "reference", _reference(_scene(coverage=0.4)))
    rendered: list[str] = []

    def render_reference(scene: Scene, label: str, *rest: Any) -> Reference:
        rendered.append(label)
        return rendering.render_reference(scene, label, *rest)

    monkeypatch.setattr(lookup, "render_reference", render_reference)

    def obtain(*folders: Path) -> Reference:
        return lookup.find_or_render(scene, LABEL, SIZE, 2, folders)

    first = obtain(shipped)
    assert rendered == [LABEL]
    assert not first.stale
    assert "has changed" in first.message
    second = obtain(shipped)
    third = obtain()
    assert rendered == [LABEL]
    assert (second.message, third.message) == (first.message, "")
    np.testing.assert_array_equal(second.mean, first.mean)
    assert second.info.noise_floor == {"flip_ldr@67ppd": 0, "rmse_lin": 0}
    storage.save(shipped / "reference", _reference(scene))
    assert obtain(shipped).info.spp == 16


@needs_mitsuba
def test_a_cache_that_cannot_be_written_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    reference = lookup.find_or_render(_scene(), LABEL, SIZE, 2, [])
    assert "not cached" in reference.message
    assert reference.mean.shape == (SIZE[1], SIZE[0], 3)


@needs_mitsuba
def test_a_check_fails_on_a_changed_mean_and_writes_images(tmp_path: Path) -> None:
    scene = _scene()
    storage.save(tmp_path, rendering.render_reference(scene, LABEL, SIZE, 2))
    back = storage.read(tmp_path, LABEL, SIZE)
    assert back is not None
    assert check(scene, back, tmp_path / "out").passed
    assert not (tmp_path / "out").exists()
    bad = dataclasses.replace(back, mean=back.mean + np.float32(0.02))
    assert not check(scene, bad, tmp_path / "out").passed
    names = {path.name for path in (tmp_path / "out" / back.info.key).iterdir()}
    kinds = ("image", "reference", "error", "p_value")
    assert names == {f"{kind}.{suffix}" for kind in kinds for suffix in ("exr", "png")}
