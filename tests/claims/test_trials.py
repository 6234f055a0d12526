"""Every kind of trial confirms evidence that fits, and refutes evidence that does not."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from oitbench.claims.evidence import Evidence
from oitbench.claims.trial import Bounds
from oitbench.image import files, stored
from oitbench.motion.record import FIXED, PER_FRAME
from oitbench.results.records import Results
from oitbench.results.schema import Record, ReferenceFacts, Scores, TrafficTerm
from oitbench.stability.result import BREAKS, DOES_NOT_APPLY, HOLDS
from oitbench.truths import MATCHED
from tests.claims.made_up import SOFTWARE, cell, evidence, held, trial
from tests.made_up import timed
from tests.motion import made_up as films
from tests.stability import helpers as checks

FLIP = {"kind": "ratio", "quantity": "flip", "of": ["calm"], "to": ["wild"]}


def test_values_lie_within_bounds() -> None:
    small = trial(kind="value", quantity="flip", of=["calm"], bounds={"most": 0.1})
    assert held(small.tried(evidence(cell("calm", flip=0.1)))) == [True]
    assert held(small.tried(evidence(cell("calm", flip=0.11)))) == [False]


@pytest.mark.parametrize(
    ("bounds", "inside", "outside"),
    [
        ({"least": 2}, 2, 1.99),
        ({"most": 2}, 2, 2.01),
        ({"above": 2}, 2.01, 2),
        ({"below": 2}, 1.99, 2),
        ({"equal": 2}, 2, 2.01),
        ({"equal": 2, "tolerance": 0.1}, 2.2, 2.21),
        ({"equal": -2, "tolerance": 0.1}, -2.2, -2.21),
        ({"least": 2, "tolerance": 0.1}, 1.8, 1.79),
    ],
)
def test_bounds(bounds: dict[str, float], inside: float, outside: float) -> None:
    made = msgspec.convert(bounds, Bounds)
    assert made.admit(inside)
    assert not made.admit(outside)


def test_bounds_need_a_number() -> None:
    with pytest.raises(msgspec.ValidationError, match="give one of least"):
        trial(kind="value", quantity="flip", of=["calm"], bounds={})


def test_quantities_need_a_known_name() -> None:
    with pytest.raises(msgspec.ValidationError, match=r"quantity.*'flop'.*flip"):
        trial(kind="value", quantity="flop", of=["calm"], bounds={"most": 1})


@pytest.mark.parametrize(("calm", "expected"), [(0.1, True), (0.3, False)])
def test_ratios_compare_methods_in_the_same_picture(calm: float, expected: bool) -> None:
    found = evidence(cell("calm", flip=calm), cell("wild", flip=0.2), cell("wild", "smoke"))
    tried = trial(**FLIP, scenes=["fog", "smoke"], bounds={"below": 1}).tried(found)
    assert held(tried) == [expected]
    assert tried.lacking == ["calm over wild on smoke"]


def test_errors_that_no_display_shows_are_equal() -> None:
    found = evidence(cell("calm", flip=1e-6), cell("wild", flip=1e-5))
    assert held(trial(**FLIP, bounds={"equal": 1}).tried(found)) == [True]


def test_errors_that_tie_have_the_quotient_one() -> None:
    def traced(method: str, flip: float, spread: float) -> Record:
        rests = [flip + spread * sign for sign in (1, -1) * 4]
        name = "flip_ldr@67ppd"
        return cell(method, outcome__scores={MATCHED: Scores({name: flip}, {}, {name: rests})})

    below = trial(**{**FLIP, "quantity": "flip:matched"}, bounds={"below": 1})
    for spread, expected in ((1e-5, True), (0.02, False)):
        found = evidence(traced("calm", 0.10, spread), traced("wild", 0.11, 0.0))
        (case,) = below.tried(found).cases
        assert case.holds is expected
        assert ("tied" in case.text) is not expected


@pytest.mark.parametrize(("ms", "expected"), [(10.0, True), (1.0, False)])
def test_times_are_compared_round_by_round(ms: float, expected: bool) -> None:
    found = evidence(cell("calm", ms=ms), cell("wild", ms=2.0))
    least = trial(**{**FLIP, "quantity": "ms"}, bounds={"least": 4})
    assert held(least.tried(found)) == [expected]


def test_times_that_no_interval_separates_from_a_bound_decide_nothing() -> None:
    wide = cell("calm", time=timed(8.0, 4.0))
    tried = trial(**{**FLIP, "quantity": "ms"}, bounds={"least": 4}).tried(
        evidence(wide, cell("wild"))
    )
    assert not tried.cases
    assert "undecided" in tried.lacking[0]


def test_disturbed_times_have_their_sign() -> None:
    disturbed = cell("calm", time=timed(10.0, foreign=0.5))
    tried = trial(**{**FLIP, "quantity": "ms"}, bounds={"least": 4}).tried(
        evidence(disturbed, cell("wild"))
    )
    assert tried.cases[0].text.endswith("†")


def test_ratios_can_compare_two_quantities_of_a_method() -> None:
    share = trial(
        kind="ratio", quantity="ms:peel", to_quantity="frame_ms", of=["calm"], to=["calm"],
        bounds={"equal": 2 / 3, "tolerance": 0.05},
    )  # fmt: skip
    assert held(share.tried(evidence(cell("calm")))) == [True]


def test_ratios_compare_effects_and_shading() -> None:
    fewer = {"method": "calm", "effects": "-volume"}
    gain = trial(**{**FLIP, "to": [fewer]}, bounds={"below": 1})
    reduced = cell("calm", flip=0.2, effects="-volume")
    assert held(gain.tried(evidence(cell("calm"), reduced))) == [True]
    assert gain.tried(evidence(cell("calm"))).lacking == ["calm over calm, -volume"]
    (whole, left_out) = gain.commands(Path("my results"), "64x64")
    assert "--effects" not in whole
    assert left_out == (
        "oitbench run --method calm --size 64x64 --effects=-volume --truth exact --out 'my results'"
    )


@pytest.mark.parametrize(("calm", "expected"), [(0.102, True), (0.12, False)])
def test_differences(calm: float, expected: bool) -> None:
    near = trial(**{**FLIP, "kind": "difference"}, bounds={"most": 0.005})
    found = evidence(cell("calm", flip=calm), cell("wild", flip=0.1))
    assert held(near.tried(found)) == [expected]


@pytest.mark.parametrize(("last", "expected"), [(0.025, True), (0.4, False)])
def test_slopes_over_methods(last: float, expected: bool) -> None:
    falls = trial(
        kind="slope", quantity="flip", of=["a[k=1]", "a[k=2]", "a[k=4]"], x=[1, 2, 4],
        bounds={"equal": -1, "tolerance": 0.01},
    )  # fmt: skip
    flips = {"a[k=1]": 0.1, "a[k=2]": 0.05, "a[k=4]": last}
    found = evidence(*(cell(method, flip=flip) for method, flip in flips.items()))
    assert held(falls.tried(found)) == [expected]


@pytest.mark.parametrize(("deep", "expected"), [(0.2, True), (0.05, False)])
def test_slopes_over_scenes(deep: float, expected: bool) -> None:
    grows = trial(
        kind="slope", quantity="rmse", of=["calm"], over="scenes", x=[1, 2],
        scenes=["thin", "deep"], bounds={"above": 0},
    )  # fmt: skip
    found = evidence(cell("calm", "thin", flip=0.1), cell("calm", "deep", flip=deep))
    assert held(grows.tried(found)) == [expected]
    assert not grows.tried(evidence(cell("calm", "thin"))).cases


def test_slopes_need_a_number_for_each_step() -> None:
    with pytest.raises(msgspec.ValidationError, match="for each of the methods"):
        trial(kind="slope", quantity="flip", of=["a", "b"], x=[1], bounds={"below": 0})


@pytest.mark.parametrize(("count", "expected"), [(48 * 4 + 12 * 10_000, True), (120_000, False)])
def test_storage_follows_a_formula(count: int, expected: bool) -> None:
    lists = trial(kind="storage", of=["calm"], per_pixel=4, per_fragment=12)
    found = evidence(cell("calm", outcome__memory__bytes=count))
    assert held(lists.tried(found)) == [expected]


def test_traffic_of_one_pass() -> None:
    terms = [TrafficTerm(name, "a", "write", 1, 4, 4) for name in ("gather n=2", "resolve")]
    found = evidence(cell("calm", outcome__traffic__terms=terms))
    for quantity, expected in (("traffic", 8), ("traffic:gather", 4)):
        value = trial(kind="value", quantity=quantity, of=["calm"], bounds={"equal": expected})
        assert held(value.tried(found)) == [True]


@pytest.mark.parametrize(("radiometric", "expected"), [(0.3, True), (0.1, False)])
def test_disagreements_of_two_metrics(radiometric: float, expected: bool) -> None:
    differ = trial(
        kind="disagreement", first="flip", second="relmse", of=["calm", "wild"],
        bounds={"above": 0},
    )  # fmt: skip
    calm = cell("calm", flip=0.1)
    assert calm.outcome is not None
    calm.outcome.scores["exact"].metrics["relmse_lin(eps=1e-2)"] = radiometric
    assert held(differ.tried(evidence(calm, cell("wild", flip=0.2)))) == [expected]


@pytest.mark.parametrize(("expected", "holds"), [(HOLDS, True), (BREAKS, False)])
def test_identities(expected: str, holds: bool) -> None:
    wanted = trial(kind="identity", of=["some[k=2]"], checks=["swept layer"], expected=expected)
    passes = checks.made_up(status=HOLDS, error=1e-3, allowed=1e-2)
    assert held(wanted.tried(evidence(checks=[passes]))) == [holds]
    fails = msgspec.structs.replace(passes, status=BREAKS)
    assert held(wanted.tried(evidence(checks=[fails]))) == [not holds]
    unfit = msgspec.structs.replace(passes, status=DOES_NOT_APPLY)
    assert wanted.tried(evidence(checks=[unfit])).lacking == ["some[k=2]: swept layer"]
    (command,) = wanted.commands(Path("out"), "")
    assert command == "oitbench stability --method 'some[k=2]' --out out/stability"


@pytest.mark.parametrize(("step", "expected"), [(0.0, True), (0.2, False)])
@pytest.mark.parametrize("metric", ["flip", "steps"])
def test_pictures_are_alike(tmp_path: Path, metric: str, step: float, expected: bool) -> None:
    def shown(method: str, level: float) -> Record:
        picture = np.full((16, 16, 3), level, np.float32)
        image = stored.store(tmp_path, f"images/{method}", files.image_channels(picture))
        return cell(method, outcome__images={"color": image})

    alike = trial(kind="alike", of="calm", to="wild", metric=metric, bounds={"most": 0.01})
    cells = shown("calm", 0.5), shown("wild", 0.5 + step)
    assert held(alike.tried(Evidence(Results(tmp_path, cells, SOFTWARE)))) == [expected]


@pytest.mark.parametrize(("method", "expected"), [("calm", True), ("leaping[sort=object]", False)])
def test_films(tmp_path: Path, method: str, expected: bool) -> None:
    film = films.write(tmp_path / "motion")
    wanted: dict[str, Any] = {"kind": "value", "quantity": "popping", "of": [method]}
    steady = trial(**wanted, scenes=[film.title], bounds={"most": 0})
    assert held(steady.tried(evidence(films=[film]))) == [expected]
    (command,) = steady.commands(Path("out"), "64x64")
    assert command.startswith(f"oitbench motion {film.title} --method ")
    assert command.endswith(f"--size 64x64 --out out/motion/{film.title}")


def test_a_path_tracer_needs_the_square_of_the_error() -> None:
    name = "flip_ldr@67ppd"
    facts = ReferenceFacts(8, 4, 8, True, 10.0)
    scores = {MATCHED: Scores({name: 0.2}, {name: 0.02}, reference=facts)}
    found = evidence(cell("calm", outcome__scores=scores))
    value = trial(kind="value", quantity="traced_ms", of=["calm"], bounds={"equal": 100})
    (case,) = value.tried(found).cases
    assert case.value == pytest.approx(100)


def test_evidence_is_read_from_a_folder(tmp_path: Path) -> None:
    films.write(tmp_path / "motion" / "fog")
    (tmp_path / "stability").mkdir()
    (tmp_path / "stability" / "stability.json").write_text("{}")
    found = Evidence.load(Results(tmp_path, (), SOFTWARE))
    assert len(found.films) == 1
    (fault,) = found.faults
    assert "stability.json" in fault


def test_jumps_that_exact_compositing_shares_do_not_pop(tmp_path: Path) -> None:
    film = films.write(tmp_path)
    tracks = [films.track(tmp_path, "calm", popping=0.009)]
    film = msgspec.structs.replace(film, tracks=tracks)
    steady = trial(kind="value", quantity="popping", of=["calm"], bounds={"most": 0})
    assert held(steady.tried(evidence(films=[film]))) == [True]


def test_films_with_the_same_random_numbers_in_all_frames_count(tmp_path: Path) -> None:
    film = films.write(tmp_path)
    tracks = [
        films.track(tmp_path, "noisy", FIXED, flicker=0.01),
        films.track(tmp_path, "noisy", PER_FRAME, flicker=0.5),
    ]
    film = msgspec.structs.replace(film, tracks=tracks)
    steady = trial(kind="value", quantity="flicker", of=["noisy"], bounds={"equal": 0.01})
    assert held(steady.tried(evidence(films=[film]))) == [True]
