"""Runs of the matrix: a cell that fails does not affect other cells."""

from __future__ import annotations

import json
import shutil
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from oitbench.effects import SHADING, Effect, names
from oitbench.errors import CapabilityError, UsageError
from oitbench.gl.frame import Frame
from oitbench.image.files import read_exr, read_flip_maps
from oitbench.image.metrics import FLIP_HDR, FLIP_LDR
from oitbench.matrix import machine
from oitbench.matrix.bench import Bench
from oitbench.matrix.cell import Cell, choose_effects
from oitbench.matrix.plan import plan_matrix
from oitbench.matrix.run import Summary, run_matrix
from oitbench.matrix.timed_cells import ScoredCell, Timing
from oitbench.measure import timing
from oitbench.measure.rounds import Schedule
from oitbench.measure.timing import Timings
from oitbench.method.demands import default_demands
from oitbench.plugins import Collection
from oitbench.results.records import Results
from oitbench.results.schema import TRANSMITTANCE, EffectNames, Nonfinite, Outcome, Record
from oitbench.results.store import CELLS, read_cells
from oitbench.truths import EXACT, FULL, MATCHED, TRACED
from tests.helpers import method

SIZE = (32, 32)
MATRIX = (["calm", "restless[count=5]"], ["alpha_blend", "a_buffer[node=compact]"])
"""Scenes and methods."""


def run(
    plugins: Path, out: Path, scenes: list[str], methods: list[str], **more: Any
) -> tuple[Summary, dict[tuple[str, str], Record]]:
    """Run cells with one sample per pixel; return the summary, and records by scene and method."""
    given = {"size": SIZE, "ssaa": 1, "out": out, "collections": [plugins], **more}
    summary = run_matrix(plan_matrix(scenes, methods, **given))
    return summary, {(record.scene, record.method): record for record in records_of(out)}


@pytest.fixture(scope="module")
def finished(plugins: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the results of two scenes and two methods."""
    out = tmp_path_factory.mktemp("finished")
    run(plugins, out, *MATRIX)
    return out


def records_of(folder: Path) -> list[Record]:
    return list(read_cells(folder / CELLS).values())


def outcome_of(record: Record) -> Outcome:
    assert record.outcome is not None
    return record.outcome


def test_every_cell_has_one_record(finished: Path) -> None:
    records = records_of(finished)
    assert {(r.scene, r.method) for r in records} == set(product(*MATRIX))
    assert {r.status for r in records} == {"ok"}


def test_a_record_has_all_facts_for_reports(finished: Path) -> None:
    record = next(r for r in records_of(finished) if r.method == "a_buffer[node=compact]")
    outcome = outcome_of(record)
    assert record.name == "a_buffer"
    assert outcome.parameters == {
        "node": "compact",
        "resolve": "sorted",
        "storage": "linked",
        "msaa": 1,
    }
    assert record.size == SIZE
    assert outcome.effects == EffectNames(["COVERAGE"], ["COVERAGE"], [])
    layers = 3 if record.scene == "calm" else 5
    assert outcome.statistics.complexity.worst == layers
    assert outcome.statistics.fragments == layers * 32 * 32
    counts = Results.load(finished).complexity(record)
    assert counts is not None
    np.testing.assert_array_equal(counts, np.full(SIZE[::-1], layers))
    passed = Results.load(finished).image(record, TRANSMITTANCE)
    assert passed is not None
    random = np.random.default_rng(layers)
    random.uniform(1, 9, (layers, 4, 4))
    expected = (1 - random.random((layers, 4, 4), dtype=np.float32)).prod(axis=0)
    np.testing.assert_allclose(np.unique(passed), np.unique(expected), rtol=1e-5)
    heads = next(term for term in outcome.memory.terms if term.resource == "heads")
    assert heads.bytes == 4 * 32 * 32
    assert outcome.traffic.bytes == sum(term.bytes for term in outcome.traffic.terms)
    assert outcome.demands == default_demands(method(record.method))
    assert outcome.nonfinite == Nonfinite()
    error = record.metric("exact", "rmse_lin")
    assert error is not None
    assert 0 < error < 0.01
    for truth in TRACED:
        assert "traced" in outcome.scores[truth].reason
    assert outcome.transparent_pixels == 32 * 32
    assert record.time is not None
    assert len(record.time.method_ms.samples) == 9
    assert record.time.method_ms.ends is not None
    parts = ["start of the frame", "capture", "resolve_sorted"]
    assert [part.name for part in record.time.passes] == parts
    assert record.time.block.cpu == machine.processor()
    assert record.time.block.foreign is not None
    assert read_exr(finished / outcome.images["color"].path).shape == (32, 32, 3)
    assert (finished / outcome.images["exact"].path).is_file()
    ldr, hdr = read_flip_maps(finished / outcome.images["flip_exact"].path)
    assert ldr.mean() == pytest.approx(record.metric("exact", FLIP_LDR), abs=1e-3)
    assert hdr.mean() == pytest.approx(record.metric("exact", FLIP_HDR), abs=1e-3)


def test_run_json_has_the_renderer_and_the_time(finished: Path) -> None:
    facts = json.loads((finished / "run.json").read_text())
    assert facts["gl"]["renderer"]
    assert facts["wall"]["total"] > 0


def test_a_second_run_keeps_finished_cells(plugins: Path, finished: Path) -> None:
    before = records_of(finished)
    summary, _ = run(plugins, finished, ["calm"], ["alpha_blend", "a_buffer[node=compact]"])
    assert (summary.kept, summary.statuses) == (2, {})
    assert records_of(finished) == before


def test_only_the_cell_of_a_truncated_line_is_run_again(
    plugins: Path, finished: Path, tmp_path: Path
) -> None:
    folder = shutil.copytree(finished, tmp_path / "copy")
    cells = folder / CELLS
    cells.write_text(cells.read_text()[:-40])
    assert len(records_of(folder)) == 3
    summary, records = run(plugins, folder, *MATRIX)
    assert (summary.kept, summary.statuses) == (3, {"ok": 1})
    assert len(records) == 4


def test_force_runs_finished_cells_again(plugins: Path, finished: Path) -> None:
    summary, _ = run(plugins, finished, ["calm"], ["alpha_blend"], force=True)
    assert (summary.kept, summary.statuses) == (0, {"ok": 1})
    assert len(records_of(finished)) == 4


def test_a_failing_cell_does_not_affect_other_cells(plugins: Path, tmp_path: Path) -> None:
    broken = str(plugins / "methods" / "broken")
    methods = [broken, "demanding", "unstable", "alpha_blend"]
    summary, records = run(
        plugins, tmp_path, ["calm", "crasher", "raiser", "poisoned"], methods, workers=2
    )
    failing = {name: records["calm", name] for name in ("broken", "demanding", "unstable")}
    assert failing["broken"].status == "failed"
    assert f"{broken}/draw.glsl:2: error" in failing["broken"].reason
    assert failing["demanding"].status in ("skipped", "failed")
    assert "no_such_thing" in failing["demanding"].reason
    assert failing["unstable"].status == "unstable"
    assert outcome_of(failing["unstable"]).nonfinite.nan == 32 * 32
    assert failing["unstable"].reason == "pixels: 1024 nan"
    assert records["calm", "alpha_blend"].status == "ok"
    assert records["calm", "alpha_blend"].time is not None
    for scene, reason in (
        ("crasher", "the worker process ended with code 7"),
        ("raiser", "ValueError: the scene is unwell"),
        ("poisoned", "background holds NaN or infinity"),
    ):
        assert records[scene, "alpha_blend"].status == "failed"
        assert reason in records[scene, "alpha_blend"].reason
    assert sum(summary.statuses.values()) == 16


def test_failed_cells_are_run_again(plugins: Path, tmp_path: Path) -> None:
    for _ in range(2):
        summary, _ = run(plugins, tmp_path, ["poisoned"], ["alpha_blend"])
        assert (summary.kept, summary.statuses) == (0, {"failed": 1})


def test_a_cell_that_hangs_is_ended(plugins: Path, tmp_path: Path) -> None:
    _, records = run(plugins, tmp_path, ["sleeper", "calm"], ["alpha_blend"], timeout=8.0)
    assert records["sleeper", "alpha_blend"].status == "timeout"
    assert (
        records["sleeper", "alpha_blend"].reason == "took longer than 8 s while building the scene"
    )
    assert records["calm", "alpha_blend"].status == "ok"


def test_a_frame_beyond_the_limit_of_the_driver_fails(plugins: Path, tmp_path: Path) -> None:
    _, records = run(plugins, tmp_path, ["calm"], ["alpha_blend"], size=(1_000_000, 1))
    assert records["calm", "alpha_blend"].status == "failed"
    assert "the driver's limit" in records["calm", "alpha_blend"].reason


def test_plans_are_checked_before_anything_is_written(plugins: Path, tmp_path: Path) -> None:
    for wrong, message in (
        ({"size": (0, 5)}, "size 0x5"),
        ({"workers": -1}, "workers is -1"),
        ({"timeout": 0.0}, "timeout is 0 s"),
        ({"preset": "huge"}, "unknown preset 'huge'"),
        ({"effects": ("-fog",)}, "unknown effect 'fog'"),
        ({"methods": ["alpha_bland"]}, "did you mean alpha_blend"),
        ({"truths": ("fell",)}, "unknown truth 'fell'; did you mean full"),
    ):
        with pytest.raises(UsageError, match=message):
            plan_matrix(**{"out": tmp_path / "out", **wrong})  # type: ignore[arg-type]
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("preset", "truths", "planned"),
    [
        ("quick", (), (EXACT, MATCHED, FULL)),
        ("guard", (), (EXACT,)),
        ("guard", ("matched",), (EXACT, MATCHED)),
        ("quick", ("full", "exact"), (EXACT, FULL)),
    ],
)
def test_exact_compositing_is_among_the_truths(
    preset: str, truths: tuple[str, ...], planned: tuple[str, ...]
) -> None:
    matrix = plan_matrix(["glass_bars"], ["alpha_blend"], preset, truths=truths)
    assert [cell.truths for cell in matrix.cells] == [planned]


def axis(scene: str, method: str, *effects: str, **more: Any) -> list[str]:
    """Return the effect settings of the planned cells of one scene and method."""
    planned = plan_matrix([scene], [method], effects=effects, **more)
    return [cell.effects for cell in planned.cells]


def test_each_effect_is_left_out_in_turn() -> None:
    shadows = ["-shadows", "-translucent_shadows", "-colored_shadows", "-caustics"]
    # Only the first method refracts; both have shading.
    assert axis("shadow_trio", "phenomenological", "each") == ["requested", "-refraction", *shadows]
    assert axis("shadow_trio", "sorted_over", "each") == ["requested", *shadows]
    # This method renders colored transmission.
    assert "-colored_transmission" in axis("shadow_trio", "dual_depth_peeling", "each")
    assert axis("layer_stack", "phenomenological", "each") == ["requested"]


def test_settings_that_are_given_twice_make_one_cell() -> None:
    settings = ("requested", "each", "-caustics", "none")
    shadows = ["-shadows", "-translucent_shadows", "-colored_shadows", "-caustics"]
    assert axis("shadow_trio", "sorted_over", *settings) == ["requested", *shadows, "none"]


def test_a_scene_that_cannot_be_built_is_planned_without_ablations(plugins: Path) -> None:
    assert axis("raiser", "sorted_over", "each", collections=[plugins]) == ["requested"]


def test_effects_that_depend_on_an_effect_are_left_out_with_it() -> None:
    requested = (
        Effect.TRANSLUCENT_SHADOWS | Effect.COLORED_SHADOWS | Effect.CAUSTICS | Effect.SHADOWS
    )
    assert choose_effects("-translucent_shadows", requested) == Effect.SHADOWS
    assert choose_effects("-shadows", requested) == Effect.NONE
    assert choose_effects("-caustics", requested) == requested & ~Effect.CAUSTICS
    occlusion = Effect.AMBIENT_OCCLUSION | Effect.INFERRED_AO
    assert choose_effects("-ambient_occlusion", occlusion) == Effect.NONE
    assert choose_effects("-inferred_ao", occlusion) == Effect.AMBIENT_OCCLUSION


def test_cells_are_timed_with_their_effects(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    timed: list[Effect] = []

    def measure(frames: dict[str, Frame], *_: Any) -> Timings:
        timed.extend(frame.plan.effects for frame in frames.values())
        return Timings(errors={name: CapabilityError("not now") for name in frames})

    monkeypatch.setattr(timing, "measure", measure)
    cells = [
        Cell("shadow_trio[detail=0.05]", "sorted_over", (8, 8), effects=effects, truths=(EXACT,))
        for effects in ("requested", "-translucent_shadows")
    ]
    with Bench(Collection.load(), tmp_path) as bench:
        scored = [ScoredCell(cell, outcome_of(bench.run(cell)).plan) for cell in cells]
        found = bench.time(scored, Schedule(rounds=1, budget=0.0))
    assert found == [Timing(reason="not now")] * 2
    shadows = [names(effects & SHADING) for effects in timed]
    assert shadows == [
        ["SHADOWS", "TRANSLUCENT_SHADOWS", "COLORED_SHADOWS", "CAUSTICS"],
        ["SHADOWS"],
    ]


def test_a_folder_that_cannot_be_written_to_is_refused(plugins: Path) -> None:
    with pytest.raises(UsageError, match="cannot be written to"):
        run(plugins, Path("/proc/results"), ["calm"], ["alpha_blend"])


def test_a_run_without_a_driver_is_refused(
    plugins: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("__EGL_VENDOR_LIBRARY_FILENAMES", "/dev/null")
    with pytest.raises(CapabilityError, match=r"no OpenGL 4\.5 context"):
        run(plugins, tmp_path, ["calm"], ["alpha_blend"])
