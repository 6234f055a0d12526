"""Checks on methods: promises, failures of every kind, and random methods."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from oitbench.gl.device import Device
from oitbench.scene import WHITE
from oitbench.stability import summary
from oitbench.stability.cases.weights import SWEEP
from oitbench.stability.check import Check, Expectation, Shot
from oitbench.stability.layers import Layer, columns, scene_of
from oitbench.stability.result import BREAKS, DOES_NOT_APPLY, HOLDS, CheckResult
from tests.helpers import foreign_method, method, run_checks, variants, write_method
from tests.stability.helpers import CHECKS, COVERAGE, examine, writing


def test_all_choices_of_precision_and_of_samples_are_variants() -> None:
    labels = [m.label for m in variants(["weighted_blended"])]
    assert "weighted_blended[msaa=4]" in labels
    assert "weighted_blended[precision=float]" in labels
    assert "weighted_blended[weight=7]" in labels
    assert len(labels) == len(set(labels))


def test_variants_have_a_fixed_order() -> None:
    assert [m.label for m in variants(["weighted_average"])] == [
        "weighted_average",
        "weighted_average[precision=float]",
        "weighted_average[count=r32f]",
        "weighted_average[msaa=4]",
    ]


def test_results_are_sorted_by_method_and_reported_as_they_arrive(device: Device) -> None:
    chosen = [CHECKS["single_layer_exact"], CHECKS["white_furnace"]]
    methods = [method("weighted_sum"), method("alpha_blend")]
    reported: list[CheckResult] = []
    found = run_checks(device, methods, chosen, reported.append)
    assert [(item.name, item.check) for item in found] == [
        (one.name, check.name) for one in methods for check in chosen
    ]
    assert [(item.name, item.check) for item in reported] == [
        (one.name, check.name) for check in chosen for one in methods
    ]


def test_only_a_broken_promise_fails(device: Device, tmp_path: Path) -> None:
    names = ("opaque_unchanged", "single_layer_exact", "equal_layers_exact")
    opaque, single, equal = examine(device, writing(tmp_path, "vec4(0.5)"), *names)
    assert (opaque.status, opaque.promised, opaque.failed) == (HOLDS, True, False)
    assert (single.status, single.promised, single.failed) == (BREAKS, True, True)
    assert (equal.status, equal.promised, equal.failed) == (BREAKS, False, False)
    (fault,) = summary.faults([opaque, single, equal])
    assert fault.startswith("breaks single_layer_exact (error 0.")


@pytest.mark.parametrize(
    ("color", "kind"),
    [
        ("vec4(sqrt(-1.0 - fragment.z))", "nan"),
        ("vec4(1.0 / (fragment.z - fragment.z))", "inf"),
        ("vec4(-0.25)", "negative"),
    ],
)
def test_pixels_that_no_method_may_return_fail(
    device: Device, tmp_path: Path, color: str, kind: str
) -> None:
    (found,) = examine(device, writing(tmp_path, color), "swept layer")
    assert found.failed
    assert getattr(found.nonfinite, kind) == found.nonfinite.total == SWEEP
    (fault,) = summary.faults([found])
    assert fault.startswith(f"swept layer: {SWEEP} ")
    assert kind in fault.lower()


def test_a_shader_that_does_not_compile_is_a_fault(device: Device, tmp_path: Path) -> None:
    names = ("equal_layers_exact", "near opaque")
    found, other = examine(device, writing(tmp_path, "nonsense"), *names)
    assert found.failed
    assert other.failed
    assert "gather.glsl" in found.reason


def test_an_image_that_changes_between_runs_fails(device: Device, tmp_path: Path) -> None:
    write_method(
        tmp_path / "counting",
        '(Gather("gather.glsl", writes={"color": REPLACE}, buffers=("seen",)),)',
        buffers='{"seen": Buffer({"count": "uint"}, Items.PIXELS)}',
        members=COVERAGE,
        gather="""void gather(Fragment fragment) {
            color = vec4(float(add_seen_count(pixel_index(), 1u) % 7u) / 8.0);
        }""",
    )
    (found,) = examine(device, foreign_method(tmp_path / "counting"), "swept layer")
    assert (found.repeatable, found.failed) == (False, True)
    assert summary.faults([found]) == ["swept layer: the image changes between runs"]


@pytest.mark.parametrize(
    ("buffers", "promises", "repeatable"),
    [
        ("Items.PIXELS", "", False),
        ("Items.FRAGMENTS", "", True),
        ("Items.FRAGMENTS", "order_independent", False),
    ],
)
def test_on_gpus_lists_may_change_what_depends_on_the_order(
    device: Device,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    buffers: str,
    promises: str,
    repeatable: bool,
) -> None:
    monkeypatch.setattr(device, "software", False)
    write_method(
        tmp_path / "counting",
        '(Gather("gather.glsl", writes={"color": REPLACE}, buffers=("seen", "kept")),)',
        buffers=f"""{{
            "seen": Buffer({{"count": "uint"}}, Items.PIXELS),
            "kept": Buffer({{"z": "float"}}, {buffers}),
        }}""",
        members=f"{COVERAGE}\npromises = promise('{promises}')",
        gather="""void gather(Fragment fragment) {
            color = vec4(float(add_seen_count(pixel_index(), 1u) % 7u) / 8.0);
        }""",
    )
    (found,) = examine(device, foreign_method(tmp_path / "counting"), "swept layer")
    assert found.repeatable == repeatable


def test_a_check_that_exceeds_a_capability_does_not_apply(device: Device) -> None:
    if device.loop_limit is None:
        pytest.skip(f"{device.renderer} has loops of any length")
    layers = [Layer(z, 0.5) for z in np.linspace(1, 2, 2500)]
    shot = Shot(scene_of(columns([layers]), WHITE))
    deep = Check("deep", "", (shot,), lambda renderings: [], repeat=False)
    (found,) = examine(device, "a_buffer[resolve=iterative]", deep)
    assert (found.status, found.failed) == (DOES_NOT_APPLY, False)
    assert "2500 fragments" in found.reason


def test_random_methods_are_judged_in_the_mean(device: Device) -> None:
    (found,) = examine(device, "stochastic[correction=none]", "single_layer_exact")
    assert (found.status, found.in_mean) == (HOLDS, True)
    assert found.error is not None
    assert 0 < found.error < 0.02


def test_a_wrong_mean_breaks_for_random_methods_too(device: Device) -> None:
    wrong = replace(
        CHECKS["two masks"],
        expect=lambda renderings: [Expectation(renderings[0].image, np.full((1, 1, 3), 0.2))],
    )
    (found,) = examine(device, "stochastic[correction=none]", wrong)
    assert (found.status, found.in_mean) == (BREAKS, True)
    assert found.error == pytest.approx(0.05, abs=0.02)
