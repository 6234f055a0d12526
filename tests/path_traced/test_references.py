"""Stored references: what comes back, what is out of date, and what a check notices."""

from __future__ import annotations

import dataclasses
import importlib.util
import json
from pathlib import Path

import numpy as np
import pytest

from oitbench.cli import main
from oitbench.errors import UsageError
from oitbench.path_traced.references import obtain as references
from oitbench.path_traced.references import stored
from oitbench.path_traced.references.fingerprint import fingerprint
from oitbench.path_traced.references.stored import Reference
from oitbench.path_traced.references.z_test import z_test
from oitbench.path_traced.trace.render import Estimate
from oitbench.scene import Camera, Material, Mesh, Object, Scene, Texture

needs_mitsuba = pytest.mark.skipif(
    importlib.util.find_spec("mitsuba") is None, reason="Mitsuba is not installed"
)
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
    return Reference(
        scene=LABEL,
        size=SIZE,
        ssaa=2,
        spp=16,
        seed=seed,
        mitsuba="3.9.1",
        fingerprint=fingerprint(scene),
        noise_floor={"flip_ldr@67ppd": 0.001, "rmse_lin": 0.002},
        mean=random.random((SIZE[1], SIZE[0], 3)).astype(np.float32),
        variance=(1e-9 * random.random((SIZE[1], SIZE[0], 3))).astype(np.float32),
    )


def test_a_reference_comes_back_as_it_was_stored(tmp_path: Path) -> None:
    scene = _scene()
    reference = _reference(scene)
    stored.save(tmp_path / "reference", reference)
    found = references.load_reference(scene, LABEL, SIZE, 2, [tmp_path])
    assert found is not None
    assert found.facts() == reference.facts()
    assert not found.stale
    np.testing.assert_allclose(found.mean, reference.mean, rtol=2**-11)
    np.testing.assert_array_equal(found.variance, reference.variance)


def test_a_radiance_beyond_half_floats_is_kept(tmp_path: Path) -> None:
    reference = _reference(_scene())
    bright = dataclasses.replace(reference, mean=reference.mean * np.float32(1e6))
    stored.save(tmp_path, bright)
    found = stored.read(tmp_path, LABEL, SIZE)
    assert found is not None
    np.testing.assert_array_equal(found.mean, bright.mean)


def test_another_label_size_or_grid_is_not_found(tmp_path: Path) -> None:
    scene = _scene()
    stored.save(tmp_path / "reference", _reference(scene))
    assert references.load_reference(scene, "window", SIZE, 2, [tmp_path]) is None
    assert references.load_reference(scene, LABEL, (8, 12), 2, [tmp_path]) is None
    assert references.load_reference(scene, LABEL, SIZE, 1, [tmp_path]) is None
    assert references.load_reference(scene, LABEL, SIZE, 2, [tmp_path / "none"]) is None


def test_a_changed_scene_makes_its_reference_stale(tmp_path: Path) -> None:
    stored.save(tmp_path / "reference", _reference(_scene()))
    found = references.load_reference(_scene(coverage=0.501), LABEL, SIZE, 2, [tmp_path])
    assert found is not None
    assert found.stale
    assert "has changed" in found.message


def test_the_fingerprint_sees_every_value_but_the_name() -> None:
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


def test_a_damaged_manifest_is_named_with_its_mend(tmp_path: Path) -> None:
    scene = _scene()
    stored.save(tmp_path / "reference", _reference(scene))
    path = tmp_path / "reference" / stored.MANIFEST
    whole = path.read_text()
    path.write_text(whole[: len(whole) // 2])
    with pytest.raises(UsageError, match="damaged; restore it, or delete it"):
        references.load_reference(scene, LABEL, SIZE, 2, [tmp_path])
    path.write_text(json.dumps({"version": 99, "references": {}}))
    with pytest.raises(UsageError, match="version 99"):
        stored.read_manifest(path.parent)
    manifest = json.loads(whole)
    del manifest["references"][stored.entry_key(LABEL, SIZE)]["spp"]
    path.write_text(json.dumps(manifest))
    with pytest.raises(UsageError, match=r"window\[seed=2\]@12x8 is damaged"):
        stored.read(path.parent, LABEL, SIZE)


def test_a_missing_image_is_an_error(tmp_path: Path) -> None:
    reference = _reference(_scene())
    stored.save(tmp_path, reference)
    (tmp_path / f"{reference.key}.mean.exr").unlink()
    with pytest.raises(UsageError, match="no such image"):
        stored.read(tmp_path, LABEL, SIZE)


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


def test_without_noise_the_z_test_forgives_half_floats_only() -> None:
    truth = np.random.default_rng(4).uniform(0, 50, (16, 16, 3)).astype(np.float32)
    half = truth.astype(np.float16).astype(np.float32)
    variance = np.zeros(truth.shape)
    assert z_test(truth, half, variance).passed
    assert not z_test(truth * np.float32(1.01), half, variance).passed


def test_the_noise_floor_is_what_the_halves_differ_by() -> None:
    first = np.full((16, 16, 3), 0.5, dtype=np.float32)
    second = first + np.float32(0.25)
    floor = references.noise_floor(Estimate(first, first, (first, second), 2), 0.0)
    assert floor["rmse_lin"] == pytest.approx(0.25)
    flip = floor["flip_ldr@67ppd"]
    assert flip is not None
    assert flip > 0.01
    none = references.noise_floor(Estimate(first, first, (first, first), 2), 0.0)
    assert none == {"flip_ldr@67ppd": 0, "rmse_lin": 0}


@needs_mitsuba
def test_a_reference_is_rendered_once_then_cached_and_a_stale_one_passed_over(
    tmp_path: Path,
) -> None:
    cache, shipped = tmp_path / "cache", tmp_path / "collection"
    scene = _scene()
    stored.save(shipped / "reference", _reference(_scene(coverage=0.4)))
    calls: list[int] = []

    def obtain(where: list[Path]) -> Reference:
        return references.obtain_reference(
            scene, LABEL, SIZE, 2, where, cache, progress=lambda done, count: calls.append(done)
        )

    first = obtain([shipped])
    assert len(calls) == 1
    assert not first.stale
    assert "has changed" in first.message
    second = obtain([shipped])
    third = obtain([])
    assert len(calls) == 1
    assert (second.message, third.message) == (first.message, "")
    np.testing.assert_allclose(second.mean, first.mean, rtol=2**-11)
    assert second.noise_floor == {"flip_ldr@67ppd": 0, "rmse_lin": 0}
    stored.save(shipped / "reference", _reference(scene))
    assert obtain([shipped]).spp == 16


@needs_mitsuba
def test_a_cache_that_cannot_be_written_is_told_but_no_error(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    reference = references.obtain_reference(
        _scene(), LABEL, SIZE, 2, [], tmp_path / "file", progress=lambda done, count: None
    )
    assert "not cached" in reference.message
    assert reference.mean.shape == (SIZE[1], SIZE[0], 3)


@needs_mitsuba
def test_a_check_fails_on_a_perturbed_mean_and_shows_it(tmp_path: Path) -> None:
    scene = _scene()
    good = references.render_reference(scene, LABEL, SIZE, progress=lambda done, count: None)
    stored.save(tmp_path, good)
    back = stored.read(tmp_path, LABEL, SIZE)
    assert back is not None
    assert references.check(scene, back, output=tmp_path / "out").passed
    assert not (tmp_path / "out").exists()
    bad = dataclasses.replace(back, mean=back.mean + np.float32(0.02))
    assert not references.check(scene, bad, output=tmp_path / "out").passed
    names = {path.name for path in (tmp_path / "out" / back.key).iterdir()}
    kinds = ("image", "reference", "error", "p_value")
    assert names == {f"{kind}.{suffix}" for kind in kinds for suffix in ("exr", "png")}


SCENE_FILE = '''"""A film over a background."""
import numpy as np
from oitbench.scene import Camera, Material, Mesh, Object, Scene
from oitbench.parameters import Parameter

parameters = {"coverage": Parameter(0.5)}


def build(*, name: str, coverage: float) -> Scene:
    corners = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0)], dtype=np.float32)
    mesh = Mesh(corners, np.array([(0, 1, 2)], dtype=np.uint32))
    film = Object("film", mesh, Material(coverage, emission=(1.0, 0.5, 0.25)))
    return Scene(name, Camera((0.0, 0.0, 4.0)), (film,), background=(0.1, 0.2, 0.3))
'''


@needs_mitsuba
def test_the_command_renders_checks_and_notices_a_change(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "mine"
    (folder / "scenes").mkdir(parents=True)
    path = folder / "scenes" / "pane.py"
    path.write_text(SCENE_FILE)

    def run(*arguments: str) -> tuple[int, str]:
        words = ["--collection", str(folder), "-o", str(tmp_path / "failures"), *arguments]
        return _main(monkeypatch, capsys, *words)

    code, output = _main(monkeypatch, capsys, "pane", "--size", "12x8", "--collection", str(folder))
    assert code == 0, output
    assert stored.read_manifest(folder / "reference").keys() == {"pane@12x8"}
    code, output = run("--check", "pane")
    assert (code, "passed" in output) == (0, True), output
    image = folder / "reference" / "pane@12x8.mean.exr"
    stored.save(folder / "reference", _perturbed(folder / "reference"))
    assert image.is_file()
    code, output = run("--check", "pane")
    assert (code, "failed" in output) == (1, True), output
    path.write_text(SCENE_FILE.replace("(0.1, 0.2, 0.3)", "(0.9, 0.2, 0.3)"))
    code, output = run("--check", "pane")
    assert (code, "stale" in output) == (1, True), output
    for wrong in (["pain"], ["pane", "--size", "12"], ["pane", "--check", "--size", "3x3"]):
        code, output = run(*wrong)
        assert code == 2, output
        assert output.count("oitbench:") == 1


def _main(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *words: str
) -> tuple[int, str]:
    """Run the verb as the shell would; return its exit code and all that it printed."""
    monkeypatch.setattr("sys.argv", ["oitbench", "reference", *words])
    code: object = 0
    try:
        main()
    except SystemExit as stop:
        code = stop.code or 0
    captured = capsys.readouterr()
    assert isinstance(code, int)
    return code, captured.out + captured.err


def _perturbed(folder: Path) -> Reference:
    reference = stored.read(folder, "pane", (12, 8))
    assert reference is not None
    return dataclasses.replace(reference, mean=reference.mean * np.float32(1.1))
