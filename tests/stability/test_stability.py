"""The stability suite: checks are right for the truth, and failures of every kind are told."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from oitbench.cli import main
from oitbench.gl.device import Device
from oitbench.method.declaration import Method
from oitbench.plugins import Collection
from oitbench.report import Note, ReportContext, Table
from oitbench.results.records import Results
from oitbench.results.schema import RunFacts
from oitbench.scene import WHITE
from oitbench.stability import files, suite
from oitbench.stability.check import Bound, Check, Comparison, Picture
from oitbench.stability.finding import BREAKS, DOES_NOT_APPLY, HOLDS, Finding
from oitbench.stability.layers import Layer, columns, scene_of, stack
from oitbench.stability.tolerance import allowed
from tests.helpers import collection, method, write_method

CHECKS = {check.id: check for check in suite.checks()}
SOLID = "void gather(Fragment fragment) {{ color = {}; }}"
BLEND = """
class Broken(Method):
    expresses = Effect.COVERAGE
    holds = frozenset({"U1", "U2"})
    passes = (Pass("gather.glsl", Draws.FRAGMENTS, writes={"color": %s}),)
"""


def examine(device: Device, chosen: Method | str, *names: str) -> list[Finding]:
    chosen = method(chosen) if isinstance(chosen, str) else chosen
    return suite.run(device, collection(), [chosen], [CHECKS[name] for name in names])


def broken(folder: Path, color: str, blend: str = "REPLACE") -> Method:
    """Return a method that promises U1 and U2 and writes `color`, an expression of GLSL."""
    plugins = Collection.load()
    write_method(folder / "broken", BLEND % blend, gather=SOLID.format(color))
    return plugins.add_method(folder / "broken")()


SHIFTING = """
class Shifting(Method):
    expresses = Effect.COVERAGE | Effect.REFRACTION
    holds = frozenset({"U12"})
    passes = (
        Pass("shift.glsl", Draws.PIXELS, reads=("opaque_color",), writes={"color": REPLACE}),
    )
"""
SHIFT = """void resolve() {{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    pixel.x = min(pixel.x + {}, int(frame_size.x) - 1);
    color = read_opaque_color(pixel);
}}"""


def test_the_exact_truth_holds_everything_that_applies(device: Device) -> None:
    truth = collection().truth()
    chosen = [check for check in CHECKS.values() if check.repeat]
    found = suite.run(device, collection(), [truth], chosen)
    assert [finding.check for finding in found if finding.result == BREAKS] == []
    left = {finding.check for finding in found if finding.result == DOES_NOT_APPLY}
    assert left == {"U12", "scatter"}
    assert not any(finding.failed for finding in found)


def test_identities_are_those_that_methods_may_promise() -> None:
    identities = [check.id for check in CHECKS.values() if check.identity]
    assert identities == [f"U{i}" for i in (1, 2, "2c", *range(3, 13))]
    promised = {name for m in collection().methods.values() for name in m().holds}
    assert promised <= set(identities)


@pytest.mark.parametrize(
    ("pixels", "result"), [("6", BREAKS), ("int(frame_size.x) / 10", HOLDS), ("0", HOLDS)]
)
def test_offsets_that_are_fixed_in_pixels_break_u12(
    device: Device, tmp_path: Path, pixels: str, result: str
) -> None:
    write_method(tmp_path / "shifting", SHIFTING, shift=SHIFT.format(pixels))
    chosen = Collection.load().add_method(tmp_path / "shifting")()
    (found,) = examine(device, chosen, "U12")
    assert (found.result, found.failed) == (result, result == BREAKS)


def test_u12_is_for_methods_that_bend_or_blur(device: Device) -> None:
    (found,) = examine(device, "weighted_blended", "U12")
    assert found.result == DOES_NOT_APPLY
    assert "neither refraction nor diffusion" in found.reason
    (found,) = examine(device, "phenomenological", "U12")
    assert (found.result, found.promised) == (HOLDS, True)
    assert found.error is not None
    assert found.error > 0


@pytest.mark.parametrize("name", ["perfect diffuser", "camera in glass", "light in glass"])
def test_pixels_that_are_not_finite_fail_at_every_limit(
    device: Device, tmp_path: Path, name: str
) -> None:
    chosen = broken(tmp_path, "vec4(1.0 / (fragment.z - fragment.z))")
    (found,) = examine(device, chosen, name)
    assert found.failed
    assert found.inf > 0


def test_what_breaks_is_told_with_its_error(device: Device) -> None:
    (found,) = examine(device, "alpha_blend", "U9")
    assert (found.result, found.promised, found.failed) == (BREAKS, False, False)
    assert found.error == pytest.approx(0.25, abs=1e-3)


def test_precision_shows(device: Device) -> None:
    half, single = (
        examine(device, f"alpha_blend[precision={name}]", "200 faint layers")[0]
        for name in ("half", "float")
    )
    assert (half.result, single.result) == (BREAKS, HOLDS)
    assert half.error is not None
    assert half.error > 0.01


def test_all_choices_of_precision_are_variants() -> None:
    labels = [m.label for m in suite.variants(collection(), ["weighted_blended"])]
    assert "weighted_blended[precision=float]" in labels
    assert "weighted_blended[weight=7]" in labels
    assert len(labels) == len(set(labels))


def test_random_methods_are_judged_in_the_mean(device: Device) -> None:
    (found,) = examine(device, "stochastic[correction=none]", "U2")
    assert (found.result, found.in_mean) == (HOLDS, True)
    assert found.error is not None
    assert 0 < found.error < 0.02


def test_a_wrong_mean_breaks_for_random_methods_too(device: Device) -> None:
    dimmer = CHECKS["two masks"]
    picture = dimmer.pictures[0]
    wrong = replace(
        dimmer, compare=lambda photos: [Comparison(photos[0].image, np.full((1, 1, 3), 0.2))]
    )
    chosen = method("stochastic[correction=none]")
    (found,) = suite.run(device, collection(), [chosen], [replace(wrong, pictures=(picture,))])
    assert (found.result, found.in_mean) == (BREAKS, True)
    assert found.error == pytest.approx(0.05, abs=0.02)


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
    chosen = broken(tmp_path, color)
    (found,) = examine(device, chosen, "swept layer")
    assert found.failed
    assert getattr(found, kind) == 2001
    assert kind in " ".join(files.told_faults([found])).lower()


def test_a_broken_promise_fails_and_a_sound_one_does_not(device: Device, tmp_path: Path) -> None:
    opaque, two = examine(device, broken(tmp_path, "vec4(0.5)"), "U1", "U2")
    assert (opaque.result, opaque.failed) == (HOLDS, False)
    assert (two.result, two.promised, two.failed) == (BREAKS, True, True)
    assert files.told_faults([opaque, two]) == ["promises broken: U2"]


def test_a_shader_that_does_not_compile_is_a_fault(device: Device, tmp_path: Path) -> None:
    found, other = examine(device, broken(tmp_path, "nonsense"), "U3", "near opaque")
    assert found.failed
    assert other.failed
    assert "gather.glsl" in found.reason


def test_a_picture_that_changes_between_runs_fails(device: Device, tmp_path: Path) -> None:
    body = """
class Counting(Method):
    expresses = Effect.COVERAGE
    buffers = {"seen": Buffer({"count": "uint"}, Items.PIXELS)}
    passes = (
        Pass("gather.glsl", Draws.FRAGMENTS, writes={"color": REPLACE}, buffers=("seen",)),
    )
"""
    gather = """void gather(Fragment fragment) {
    color = vec4(float(add_seen_count(pixel_index(), 1u) % 7u) / 8.0);
}"""
    plugins = Collection.load()
    chosen = plugins.add_method(write_method(tmp_path / "counting", body, gather=gather))()
    (found,) = examine(device, chosen, "swept layer")
    assert (found.repeatable, found.failed) == (False, True)
    assert files.told_faults([found]) == ["changes between runs: swept layer"]


def test_capabilities_that_lack_do_not_apply(device: Device) -> None:
    layers = [Layer(z, 0.5) for z in np.linspace(1, 2, 2500)]
    picture = Picture(scene_of(columns([layers]), WHITE))
    deep = Check("deep", "", (picture,), lambda photos: [], repeat=False)
    (found,) = suite.run(device, collection(), [method("a_buffer[resolve=iterative]")], [deep])
    assert found.result == DOES_NOT_APPLY
    assert "2500 fragments" in found.reason


def test_the_bound_follows_from_the_formats() -> None:
    half, single = (method(f"alpha_blend[precision={name}]") for name in ("half", "float"))
    assert allowed(half, 1, 1.0) == pytest.approx(2 * 2.0**-10, rel=0.01)
    assert allowed(half, 4, 1.0) / allowed(single, 4, 1.0) > 2**10
    packed = method("a_buffer[node=compact]")
    assert allowed(packed, 2, 1.0) > 2 / 255


def test_equal_means_equal(device: Device) -> None:
    lists = stack([Layer(2, 0.5)])
    (photo_of,) = (Picture(scene_of(lists)),)
    nearly = Check(
        "nearly",
        "",
        (photo_of,),
        lambda photos: [
            Comparison(photos[0].image, photos[0].image + np.float32(1e-6), bound=Bound.EQUAL)
        ],
    )
    (found,) = suite.run(device, collection(), [method("a_buffer")], [nearly])
    assert (found.result, found.allowed) == (BREAKS, 0.0)


def test_files_and_report(device: Device, tmp_path: Path) -> None:
    names = ("U2", "U2c", "two halves")
    found = examine(device, "weighted_blended", *names) + examine(device, "a_buffer", *names)
    files.write(tmp_path / "stability", found, {"gl": {}})
    assert files.read(tmp_path / "stability" / files.JSON) == found
    text = (tmp_path / "stability" / files.CSV).read_text(encoding="utf-8")
    assert len(text.splitlines()) == 1 + len(found)
    report = collection().reports["stability"]
    results = Results(tmp_path, (), RunFacts(gl=None, seed=1))
    identities, cases, every = report.build(ReportContext(results, tmp_path / "out"))
    assert isinstance(identities, Table)
    assert isinstance(cases, Table)
    assert [row[:3] for row in identities.rows] == [
        ("weighted_blended", "✓", "–"),
        ("a_buffer", "✓", "✓"),
    ]
    assert [row[1] for row in cases.rows] == ["0.17", "✓"]
    assert isinstance(every, Table)
    assert len(every.rows) == len(found)
    elsewhere = replace(results, folder=tmp_path / "out")
    (note,) = report.build(ReportContext(elsewhere, tmp_path / "out"))
    assert isinstance(note, Note)


def test_exit_codes(
    device: Device,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    few = (CHECKS["U1"], CHECKS["U2"])
    monkeypatch.setattr(suite, "checks", lambda: few)
    broken(tmp_path, "vec4(0.5)")
    for name, code in (("a_buffer", 0), (str(tmp_path / "broken"), 1)):
        argv = ["oitbench", "stability", "--method", name, "--out", str(tmp_path), "--json"]
        monkeypatch.setattr("sys.argv", argv)
        with pytest.raises(SystemExit) as stop:
            main()
        assert stop.value.code == code
        told = json.loads(capsys.readouterr().out)
        assert any(finding["failed"] for finding in told["findings"]) == bool(code)
