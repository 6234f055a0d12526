"""A suite runs only where scenes, references and metrics are those that were frozen."""

from __future__ import annotations

import shutil
from pathlib import Path

import msgspec
import pytest

import oitbench
from oitbench.errors import UsageError
from oitbench.image import metrics
from oitbench.path_traced.references.storage import FOLDER, MANIFEST, read
from oitbench.places import Places, own_folder
from oitbench.suites.description import known_suites, read_suite, write_suite
from oitbench.suites.digests import different_metrics, pixel_digest, probe_metrics
from oitbench.suites.planning import plan_suite
from oitbench.truths import TRACED, TRUTHS
from tests.cli.helpers import Call
from tests.suites.conftest import METHODS, PANES, World, store_reference


@pytest.fixture
def copy(world: World, tmp_path: Path) -> Path:
    """A copy of the collection."""
    return shutil.copytree(world.folder, tmp_path / "world", ignore=lambda *_: ["results"])


def refusal(suite: Path, folder: Path) -> str:
    with pytest.raises(UsageError, match="this checkout differs from the suite tiny: ") as caught:
        plan_suite(str(suite), METHODS, [folder], out=folder / "none")
    assert not (folder / "none").exists()
    return str(caught.value)


def test_the_same_checkout_gives_the_cells(world: World, copy: Path) -> None:
    matrix = plan_suite(str(world.file), METHODS, [copy], out=copy / "out")
    keys = {world.suite.key(scene, name) for scene in world.suite.scenes for name in METHODS}
    assert {cell.key for cell in matrix.cells} == keys
    assert {cell.permutations for cell in matrix.cells} == {world.suite.permutations}
    schedule = matrix.schedule
    assert (schedule.rounds, schedule.budget) == (world.suite.rounds, world.suite.budget)


def test_a_changed_scene_is_named(world: World, copy: Path) -> None:
    (copy / "scenes" / "glazing.py").write_text(PANES.replace("0.9, 0, 0", "0.91, 0, 0"))
    assert "the scene glazing has changed;" in refusal(world.file, copy)
    (copy / "scenes" / "glazing.py").unlink()
    assert "the scene glazing: unknown scene 'glazing'" in refusal(world.file, copy)


def test_a_changed_reference_is_named(world: World, copy: Path) -> None:
    (copy / FOLDER / MANIFEST).unlink()
    expected = "the matched reference of glazing is missing: glazing@16x16.matched is not stored"
    assert expected in refusal(world.file, copy)
    (copy / "scenes" / "glazing.py").write_text(PANES.replace("0.5, 0.3", "0.5, 0.4"))
    store_reference(copy)
    brighter = copy / "scenes" / "glazing.py"
    brighter.write_text(PANES)
    found = refusal(world.file, copy)
    assert "the matched reference of glazing is missing" in found
    assert "the scene has changed since this reference was rendered" in found


def test_other_pixels_of_a_reference_are_named(world: World, tmp_path: Path) -> None:
    scenes = [
        msgspec.structs.replace(s, references=dict.fromkeys(s.references, "0" * 32))
        for s in world.suite.scenes
    ]
    file = tmp_path / "tiny.json"
    write_suite(file, msgspec.structs.replace(world.suite, scenes=scenes))
    assert "the matched reference of glazing has changed;" in refusal(file, world.folder)


def test_other_effects_are_named(world: World, tmp_path: Path) -> None:
    scenes = [
        msgspec.structs.replace(s, effects=[], ranked_by="matched") for s in world.suite.scenes
    ]
    file = tmp_path / "tiny.json"
    write_suite(file, msgspec.structs.replace(world.suite, scenes=scenes))
    found = refusal(file, world.folder)
    assert "the scene glazing requests other effects" in found
    assert "the scene glazing is ranked by exact, not matched" in found
    assert "and 1 more" in found


def test_a_changed_metric_is_named(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(metrics, "_PIXELS_PER_DEGREE", 60.0)
    found = refusal(world.file, world.folder)
    assert "the metric flip_ldr@67ppd gives 0." in found
    assert "the metric flip_hdr@67ppd gives 0." in found


def test_a_changed_file_of_a_suite_is_refused(world: World, tmp_path: Path) -> None:
    file = tmp_path / "tiny.json"
    file.write_text(world.file.read_text().replace('"ssaa": 1', '"ssaa": 2'))
    with pytest.raises(UsageError, match=r"is no suite, or was changed \(its checksum"):
        read_suite(str(file))
    with pytest.raises(UsageError, match="cannot be read"):
        read_suite(str(tmp_path / "none.json"))


def test_fixed_options_are_refused(call: Call, world: World, tmp_path: Path) -> None:
    suite = ("--suite", world.file)
    call("run", *suite, "--size", "8x8").assert_refused("fixes size; leave them out")
    call("run", *suite, "--seed", "0").assert_refused("fixes seed; leave them out")
    answer = call("run", *suite, "--preset", "quick", "--truth", "full", "--scene", "lists")
    answer.assert_refused("fixes preset and scenes and truths; leave them out")
    config = tmp_path / "run.toml"
    config.write_text("ssaa = 3\n")
    call("run", "--config", config, *suite).assert_refused("fixes ssaa; leave them out")
    with pytest.raises(UsageError, match="fixes scenes and size; leave them out"):
        oitbench.run(["lists"], size=(8, 8), suite=str(world.file), out=tmp_path / "out")


def test_a_run_of_a_suite_is_repeated_by_its_configuration(
    call: Call, world: World, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    options = ("--collection", world.folder, "--out", out, "--method", "alpha_blend")
    answer = call("run", "--suite", world.file, *options)
    assert answer.code == 0, answer
    assert "2 ok; 0 kept" in answer.out
    text = (out / "run.toml").read_text()
    assert "suite = " in text
    assert "preset" not in text
    answer = call("run", "--config", out / "run.toml")
    assert answer.code == 0, answer
    assert "nothing to do; 2 kept" in answer.out
    again = oitbench.run(
        methods=["alpha_blend"], suite=str(world.file), collections=[world.folder], out=out
    )
    assert again.summary is not None
    assert (again.summary.kept, again.exit_code) == (2, 0)
    assert (out / "run.toml").read_text() == text


@pytest.mark.parametrize("name", known_suites())
def test_shipped_suites_agree_with_the_stored_references(name: str) -> None:
    """Scenes are not built: a stored reference names the content of its scene."""
    suite = read_suite(name)
    assert suite.name == name
    assert suite.truths == list(TRUTHS)
    assert different_metrics(suite.metrics, probe_metrics()) == []
    assert {scene.scene for scene in suite.scenes} <= set(Places((own_folder(),)).scenes)
    assert len(suite.scenes) > 20
    for scene in suite.scenes:
        for truth in TRACED if scene.references else ():
            key = f"{scene.scene}@{suite.size[0]}x{suite.size[1]}.{truth}"
            reference = read(own_folder() / FOLDER, key)
            assert reference is not None, key
            assert reference.rendering.fingerprint == scene.fingerprint, key
            assert pixel_digest(reference.mean) == scene.references[truth], key
