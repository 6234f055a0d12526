"""Results of a suite are complete and unmodified, or a fault names the difference."""

from __future__ import annotations

import shutil
import zipfile
from pathlib import Path
from typing import Any

import msgspec
import pytest

from oitbench.errors import UsageError
from oitbench.image import files, metrics, stored
from oitbench.results.schema import Record
from oitbench.results.store import CELLS, RUN, Store
from oitbench.suites import submission
from oitbench.suites.submission import Fault, check
from tests.cli.helpers import Call
from tests.damage import flip_bit
from tests.made_up import changed
from tests.suites.conftest import World

CELL = ("glazing", "alpha_blend")


@pytest.fixture
def results(world: World, tmp_path: Path) -> Path:
    """A copy of the finished run."""
    return shutil.copytree(world.results, tmp_path / "results")


def find(folder: Path) -> Record:
    with Store.open(folder) as store:
        (found,) = [r for r in store.records() if (r.scene, r.method) == CELL]
        return found


def put(folder: Path, record: Record) -> None:
    """Add a record with a valid checksum."""
    with Store.open(folder) as store:
        store.append(record)


def alter(folder: Path, **paths: Any) -> None:
    """Change fields of the cell, by paths whose dots are `__`."""
    record = find(folder)
    for path, value in paths.items():
        record = changed(record, path.replace("__", "."), value)
    put(folder, record)


def faults(folder: Path, world: World) -> list[Fault]:
    return list(check(folder, world.suite).faults)


def test_a_finished_run_is_complete(world: World) -> None:
    verdict = check(world.results, world.suite)
    assert verdict.faults == ()
    assert (verdict.cells, verdict.methods) == (4, ("a_buffer", "alpha_blend"))


def test_a_missing_cell_is_named(results: Path, world: World) -> None:
    lines = (results / CELLS).read_text().splitlines(keepends=True)
    kept = [line for line in lines if '"scene":"glazing","method":"alpha_blend"' not in line]
    assert len(kept) == 3
    (results / CELLS).write_text("".join(kept))
    assert faults(results, world) == [Fault(*CELL, "missing")]


def test_a_changed_record_is_named(results: Path, world: World) -> None:
    lines = (results / CELLS).read_text().splitlines(keepends=True)
    lines[1] = lines[1].replace('"status":"ok"', '"status":"ok" ')
    (results / CELLS).write_text("".join(lines))
    reasons = [fault.reason for fault in faults(results, world)]
    assert reasons == ["cells.jsonl: line 2 changed or is damaged", "missing"]


def test_a_metric_that_is_not_that_of_the_pictures_is_named(results: Path, world: World) -> None:
    scores = find(results).outcome.scores  # type: ignore[union-attr]
    for name, value in scores["matched"].metrics.items():
        if name not in metrics.NAMES:
            continue
        better = {**scores["matched"].metrics, name: None if value is None else 0.999 * value}
        alter(results, outcome__scores=changed(scores, "matched.metrics", better))
        expected = [Fault(*CELL, f"{name} against matched is not that of the pictures")]
        assert faults(results, world) == (expected if value else [])


def test_a_changed_image_is_named(results: Path, world: World) -> None:
    image = find(results).outcome.images["color"]  # type: ignore[union-attr]
    flip_bit(results / image.path, 4000)
    assert faults(results, world) == [Fault(*CELL, f"{results / image.path} is damaged")]


def test_another_truth_is_named(results: Path, world: World) -> None:
    images = find(results).outcome.images  # type: ignore[union-attr]
    for truth, reason in (
        ("matched", "the matched reference was another one"),
        ("exact", "exact compositing has another mean radiance"),
    ):
        pixels = 1.02 * files.read_exr(results / images[truth].path)
        other = stored.store(results, f"images/{truth}", files.image_channels(pixels))
        alter(results, outcome__images={**images, truth: other})
        reasons = [fault.reason for fault in faults(results, world)]
        assert reason in reasons
        assert f"flip_ldr@67ppd against {truth} is not that of the pictures" in reasons


@pytest.mark.parametrize(
    ("paths", "reason"),
    [
        ({"size": (8, 8)}, "size 8x8, not 16x16"),
        ({"ssaa": 2}, "ssaa 2, not 1"),
        ({"effects": "none"}, "effects none, not requested"),
        ({"shading": "slices=8"}, "shading slices=8, not default"),
        ({"scene": "other"}, "the suite has no such scene"),
        ({"view": "left"}, "the suite has no such scene"),
    ],
)
def test_cells_that_are_not_of_the_suite_are_named(
    paths: dict[str, Any], reason: str, results: Path, world: World
) -> None:
    alter(results, **paths)
    (fault,) = faults(results, world)
    assert fault.reason == reason


@pytest.mark.parametrize(
    ("paths", "reason"),
    [
        ({"fingerprints__scene": "0" * 32}, "the scene was another one"),
        ({"seed": 2}, "seed 2, not 1"),
        ({"permutations": 4}, "permutations 4, not 16"),
        ({"truths": ["exact"]}, "truths exact, not exact, matched"),
        ({"time": None}, "it has no time"),
        ({"time__block__rounds": 9}, "timed in other rounds, not 15 in 60 s"),
        ({"outcome__effects__requested": []}, "the scene requested other effects"),
        ({"outcome__shading__settings": {"slices": 8}}, "other settings of shared shading"),
        ({"status": "failed", "reason": "no memory"}, "failed: no memory"),
        ({"status": "suspect", "reason": "strange"}, "suspect: strange"),
        ({"status": "unstable", "reason": "pixels: 1 nan"}, None),
        ({"status": "skipped", "outcome": None, "time": None}, None),
    ],
)
def test_cells_of_other_settings_are_named(
    paths: dict[str, Any], reason: str | None, results: Path, world: World
) -> None:
    alter(results, **paths)
    assert faults(results, world) == ([] if reason is None else [Fault(*CELL, reason)])


def test_another_exposure_is_named(results: Path, world: World) -> None:
    alter(results, outcome__exposure=1.0)
    assert Fault(*CELL, "exposure 1, not 0") in faults(results, world)


@pytest.mark.parametrize(
    ("paths", "reason"),
    [
        ({"fingerprints__engine": "x"}, "cells of different versions of the engine"),
        ({"fingerprints__metrics": "x"}, "cells of different versions of the metrics"),
        ({"fingerprints__method": "x"}, "cells of different versions of alpha_blend"),
        ({"gl__renderer": "other"}, "cells of different renderers"),
    ],
)
def test_cells_that_do_not_belong_together_are_named(
    paths: dict[str, Any], reason: str, results: Path, world: World
) -> None:
    alter(results, **paths)
    (fault,) = faults(results, world)
    assert fault.reason.startswith(reason)


def test_changed_facts_of_the_run_are_named(results: Path, world: World) -> None:
    text = (results / RUN).read_text()
    (results / RUN).write_text(text.replace('"seed": 1', '"seed": 2'))
    (fault,) = faults(results, world)
    assert fault.reason == "run.json is missing, changed or damaged"


def test_other_metrics_cannot_check(
    results: Path, world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(metrics, "_RELATIVE_EPSILON", 0.02)
    with pytest.raises(UsageError, match=r"cannot check tiny: the metric relmse_lin\(eps=1e-2\)"):
        check(results, world.suite)


def test_the_command_prints_faults_and_packs(call: Call, results: Path, world: World) -> None:
    suite = ("--suite", world.file)
    answer = call("submit", "--check", results, *suite)
    text = "complete and unmodified: 2 methods in 2 scenes of tiny\n"
    assert (answer.code, answer.out, answer.err) == (0, f"{results}: {text}", "")
    assert not results.with_suffix(".zip").exists()
    answer = call("submit", results, *suite)
    assert (answer.code, answer.out.splitlines()[1]) == (0, f"{results}.zip: to be sent")
    first = (results.parent / "results.zip").read_bytes()
    call("submit", results, *suite)
    assert (results.parent / "results.zip").read_bytes() == first
    with zipfile.ZipFile(results.parent / "results.zip") as archive:
        archive.extractall(results.parent / "sent")
    assert check(results.parent / "sent" / "results", world.suite).faults == ()
    (results.parent / "results.zip").unlink()
    alter(results, seed=2)
    answer = call("submit", results, *suite)
    assert (answer.code, answer.err) == (1, "")
    for part in ("glazing", "alpha_blend", "seed 2, not 1", "no results of tiny: 1 fault\n"):
        assert part in answer.out
    assert not (results.parent / "results.zip").exists()
    call("submit", results, "--suite", "oitbench-0").assert_refused("did you mean oitbench-1")


def test_results_of_another_suite_are_refused(world: World) -> None:
    scenes = [msgspec.structs.replace(s, fingerprint="0" * 32) for s in world.suite.scenes]
    other = msgspec.structs.replace(world.suite, scenes=scenes)
    found = submission.check(world.results, other)
    assert {fault.reason for fault in found.faults} == {"the scene was another one"}
    assert len(found.faults) == 4
