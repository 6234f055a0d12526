"""The answer: choices, ties and sentences, from made-up results."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import msgspec
import pytest

from oitbench.image import metrics
from oitbench.image.ties import Errors
from oitbench.plugins import Collection
from oitbench.report import ReportContext, answers, multiples
from oitbench.report.answers import ELSEWHERE, Answer
from oitbench.report.artifacts import Choices, HeatTable, Statement
from oitbench.report.multiples import Point
from oitbench.results.records import Panel
from oitbench.results.schema import EffectNames, Record, Scores
from oitbench.truths import EXACT
from tests.made_up import outcome_of, record, timed
from tests.report.made_up import context, finished

FLIP = metrics.FLIP_LDR


def cell(
    scene: str, method: str, error: float, ms: float | None, subject: str = "smoke",
    missing: Sequence[str] = (), values: Mapping[str, int] | None = None,
) -> Record:  # fmt: skip
    """Return a cell with an error against exact compositing and a method time."""
    scores = {EXACT: Scores({FLIP: error})}
    wanted = ["COVERAGE", "DIFFUSION"] if missing else ["COVERAGE"]
    outcome = msgspec.structs.replace(
        outcome_of(scores, {}),
        subject=subject,
        effects=EffectNames(wanted, wanted, list(missing)),
        parameters=dict(values or {}),
    )
    time = None if ms is None else timed(ms)
    return record(method, scene, name=method.partition("[")[0], outcome=outcome, time=time)


def panels(tmp_path: Path, *cells: Record) -> list[Panel]:
    return list(context(tmp_path, cells, tmp_path).results.panels())


def only_answer(found: Sequence[Panel]) -> Answer:
    (subject,) = answers.subjects(found, FLIP)
    assert subject.answer is not None
    return subject.answer


def test_each_criterion_chooses_its_method(tmp_path: Path) -> None:
    found = panels(
        tmp_path,
        cell("a", "fast", 0.3, 10.0),
        cell("a", "cheap", 0.1, 19.0),
        cell("a", "near", 0.025, 30.0),
        cell("a", "slow", 0.02, 80.0),
    )
    answer = only_answer(found)
    names = [answer.least, answer.cheap, answer.near, answer.fastest]
    assert [one.price.method if one else None for one in names] == ["slow", "cheap", "near", "fast"]
    assert answer.least.price.cost == pytest.approx(8.0)
    assert answers.described(answer.least) == "FLIP 0.020, 80.0 ms (8.0× the least time)"
    assert answers.described(answer.fastest) == "FLIP 0.300, 10.0 ms (the least time)"
    assert answers.described(answer.fastest, cost=False) == "FLIP 0.300, 10.0 ms"


def test_of_methods_that_tie_the_fastest_is_chosen(tmp_path: Path) -> None:
    found = panels(
        tmp_path,
        cell("a", "slow", 0.02, 50.0),
        cell("a", "quick", 0.02004, 10.0),
        cell("a", "other", 0.0203, 5.0),
    )
    least = only_answer(found).least
    assert (least.price.method, least.equal) == ("quick", ("slow",))


def test_errors_and_costs_are_averaged_over_the_scenes_of_a_subject(tmp_path: Path) -> None:
    found = panels(
        tmp_path,
        cell("a", "x", 0.1, 10.0),
        cell("a", "y", 0.2, 40.0),
        cell("b", "x", 0.3, 800.0),
        cell("b", "y", 0.1, 100.0),
        cell("b", "absent from a", 0.0, 1.0),
    )
    answer = only_answer(found)
    assert (answer.least.price.method, answer.scenes) == ("y", ("a", "b"))
    assert answer.least.price.error == pytest.approx(0.15)
    assert answer.least.price.ms == pytest.approx(4000**0.5)
    # The numbers of a row divide: the least time is that of one method over all scenes.
    (subject,) = answers.subjects(found, FLIP)
    assert {price.method: price.cost for price in subject.prices} == {
        "x": pytest.approx(2**0.5), "y": pytest.approx(1.0),
    }  # fmt: skip


def test_without_times_only_the_least_error_is_known(tmp_path: Path) -> None:
    answer = only_answer(panels(tmp_path, cell("a", "x", 0.1, None), cell("a", "y", 0.2, None)))
    assert answer.least.price.method == "x"
    assert (answer.cheap, answer.near, answer.fastest) == (None, None, None)
    assert answers.described(answer.least) == "FLIP 0.100"


def half_timed(tmp_path: Path, last: float | None) -> list[Panel]:
    """Return two scenes, of which the second one has the time of one method, or none."""
    return panels(
        tmp_path,
        cell("a", "x", 0.1, 10.0),
        cell("a", "y", 0.2, 40.0),
        cell("b", "x", 0.3, None),
        cell("b", "y", 0.1, last),
    )


def test_times_come_from_the_scenes_that_were_timed(tmp_path: Path) -> None:
    answer = only_answer(half_timed(tmp_path, None))
    assert (answer.least.price.method, answer.least.price.ms) == ("y", 40.0)
    assert answer.fastest is not None
    assert (answer.fastest.price.method, answer.timed) == ("x", 1)


def test_a_method_that_lacks_one_time_has_none(tmp_path: Path) -> None:
    (subject,) = answers.subjects(half_timed(tmp_path, 50.0), FLIP)
    assert {price.method: price.cost for price in subject.prices} == {"x": None, "y": 1.0}


def test_the_table_says_how_many_scenes_were_timed(tmp_path: Path) -> None:
    timed, untimed = (finished(tmp_path, scene, "glow", 0.1) for scene in ("a", "b"))
    untimed = msgspec.structs.replace(untimed, time=None)
    shown: ReportContext = context(tmp_path, [timed, untimed], tmp_path)
    table = Collection.load().reports["answer"].build(shown)[0]
    assert isinstance(table, Choices)
    assert [row.remark for row in table.rows] == ["mean of 2 scenes, times of 1"]


def test_subjects_of_many_scenes_come_first_and_others_last(tmp_path: Path) -> None:
    found = panels(
        tmp_path,
        cell("a", "x", 0.1, 1.0, subject=""),
        cell("b", "x", 0.1, 1.0, subject=""),
        cell("c", "x", 0.1, 1.0, subject="glass"),
        cell("d", "x", 0.1, 1.0, subject="smoke"),
        cell("e", "x", 0.1, 1.0, subject="smoke"),
    )
    assert [one.name for one in answers.subjects(found, FLIP)] == ["smoke", "glass", ELSEWHERE]


def test_sentences_count_scenes_and_name_effects_that_few_methods_show(tmp_path: Path) -> None:
    cells = [
        cell(scene, method, error, ms, missing=() if method == "rich" else ("DIFFUSION",))
        for scene in "abc"
        for method, error, ms in (
            ("rich", 0.01 if scene == "a" else 0.5, 10.0),
            ("plain", 0.2, 10.0),
            ("poor", 0.3, 10.0),
            ("bare", 0.4, 10.0),
            ("last", 0.6, 90.0),
        )
    ]
    # A method that shows an effect is known by a scene that requests it.
    for place, one in enumerate(cells):
        if one.method == "rich" and one.outcome is not None:
            wanted = EffectNames(["COVERAGE", "DIFFUSION"], ["COVERAGE", "DIFFUSION"], [])
            outcome = msgspec.structs.replace(one.outcome, effects=wanted)
            cells[place] = msgspec.structs.replace(one, outcome=outcome)
    for one in cells:
        assert one.outcome is not None
        one.outcome.scores["matched"] = one.outcome.scores[EXACT]
    found = panels(tmp_path, *cells)
    listed = [answer for one in answers.subjects(found, FLIP) if (answer := one.answer)]
    said = answers.sentences(listed, found, FLIP)
    assert said[0].endswith("the least error comes from plain in 2 of 3 scenes, rich in 1.")
    assert said[-1] == "Only rich shows diffusion."


def test_sweeps_join_three_values_of_one_parameter_in_their_order() -> None:
    pairs = []
    for n, k in ((8, 1), (2, 1), (4, 1), (4, 2)):
        made = cell("a", f"m[n={n},k={k}]", 0.1, 1.0, values={"n": n, "k": k})
        pairs.append((made, Point(f"{n} {k}", "lists", n, Errors(0.1))))
    (curve,) = multiples.sweeps(pairs)
    assert [point.method for point in curve] == ["2 1", "4 1", "8 1"]


def test_the_section_has_an_answer_two_figures_and_all_errors(tmp_path: Path) -> None:
    cells = [
        finished(tmp_path, scene, method, error)
        for scene in ("glass", "smoke")
        for method, error in (("murk", 0.3), ("glow", 0.1))
    ]
    shown: ReportContext = context(tmp_path, cells, tmp_path)
    parts = Collection.load().reports["answer"].build(shown)
    assert [type(part) for part in parts if not hasattr(part, "png")] == [
        Choices, Statement, HeatTable,
    ]  # fmt: skip
    table = parts[0]
    assert isinstance(table, Choices)
    for row in table.rows:
        use, *others = row.chosen
        assert use is not None
        assert use.method == "glow"
        # Numbers that stand in the first column already are not repeated.
        assert {one.numbers for one in others if one and one.method == "glow"} == {"as recommended"}
    heat = parts[-1]
    assert isinstance(heat, HeatTable)
    assert heat.columns == ("glow", "murk")
    assert [[shade.best for shade in row] for _, _, row in heat.rows] == [[True, False]] * 2
    text = (tmp_path / "answer.csv").read_text(encoding="utf-8")
    assert text.startswith("subject,criterion,method,")


def test_only_the_least_time_is_called_so() -> None:
    first, next_ = (answers.Price("m", 0.1, 10.0 * cost, cost) for cost in (1.0, 1.04))
    assert answers.described(answers.Choice(first)).endswith("10.0 ms (the least time)")
    assert answers.described(answers.Choice(next_)).endswith("10.4 ms (1.0× the least time)")


def test_large_numbers_have_no_exponent() -> None:
    price = answers.Price("fog", 0.089, 1445.667, 214.49)
    assert answers.described(answers.Choice(price)) == (
        "FLIP 0.089, 1,446 ms (214× the least time)"
    )
