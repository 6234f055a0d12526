"""Verdicts follow from the cases: evidence that is broken changes them."""

from __future__ import annotations

import pytest

from oitbench.claims.verdicts import (
    CONDITIONAL,
    NO_EVIDENCE,
    NOT_TESTABLE,
    REFUTED,
    REPRODUCED,
    judge,
)
from oitbench.results.schema import Record
from tests.claims.made_up import cell, claim, evidence

BETTER = {
    "kind": "ratio", "quantity": "flip", "of": ["calm"], "to": ["wild"],
    "scenes": ["fog", "smoke"], "bounds": {"below": 1},
}  # fmt: skip
FASTER = BETTER | {"quantity": "ms"}


def pair(scene: str, flip: float) -> list[Record]:
    return [cell("calm", scene, flip), cell("wild", scene, 0.2)]


@pytest.mark.parametrize(
    ("flips", "word"),
    [((0.1, 0.1), REPRODUCED), ((0.3, 0.3), REFUTED), ((0.1, 0.3), CONDITIONAL)],
)
def test_a_verdict_follows_from_all_cases(flips: tuple[float, float], word: str) -> None:
    found = evidence(*pair("fog", flips[0]), *pair("smoke", flips[1]))
    assert judge(claim(BETTER), found).word == word


def test_a_condition_names_where_the_claim_holds_and_where_not() -> None:
    found = evidence(*pair("fog", 0.1), *pair("smoke", 0.3))
    assert judge(claim(BETTER), found).reason == "holds: fog; does not: smoke"
    both = BETTER | {"of": ["calm", "mild"], "scenes": ["fog"]}
    found = evidence(*pair("fog", 0.1), cell("mild", flip=0.3))
    reason = judge(claim(both), found).reason
    assert reason == "holds: calm over wild; does not: mild over wild"


def test_a_condition_names_the_quantity_if_that_decides() -> None:
    found = evidence(cell("calm", flip=0.1, ms=5.0), cell("wild", flip=0.2, ms=2.0))
    reason = judge(claim(BETTER, FASTER), found).reason
    assert reason == "holds: FLIP; does not: method time, ms"


def test_anywhere_needs_one_case() -> None:
    found = evidence(*pair("fog", 0.3), *pair("smoke", 0.1))
    verdict = judge(claim(BETTER, anywhere=True), found)
    assert verdict.word == REPRODUCED
    assert verdict.numbers.startswith("smoke")
    found = evidence(*pair("fog", 0.3), *pair("smoke", 0.3))
    assert judge(claim(BETTER, anywhere=True), found).word == REFUTED
    found = evidence(*pair("fog", 0.3))
    assert judge(claim(BETTER, anywhere=True), found).word == NO_EVIDENCE


def test_results_that_lack_a_trial_give_no_verdict_but_a_command() -> None:
    verdict = judge(claim(BETTER, FASTER), evidence(cell("calm"), cell("wild", time=None)))
    assert verdict.word == NO_EVIDENCE
    assert "calm over wild on smoke" in verdict.lacking
    assert verdict.commands[0].startswith("oitbench run --scene fog --scene smoke --method calm")


def test_a_claim_about_gpus_needs_one() -> None:
    verdict = judge(claim(FASTER, gpu=True), evidence(*pair("fog", 0.1)))
    assert (verdict.word, verdict.cases) == (NOT_TESTABLE, ())
    assert verdict.reason == "needs a GPU; these results are of llvmpipe (test)"


def test_a_claim_that_nothing_tests_has_a_reason() -> None:
    verdict = judge(claim({"kind": "untestable", "reason": "no splats"}), evidence())
    assert (verdict.word, verdict.reason) == (NOT_TESTABLE, "no splats")


def test_numbers_of_a_conditional_claim_show_both_kinds() -> None:
    scenes = [f"s{k}" for k in range(9)]
    cells = [c for k, scene in enumerate(scenes) for c in pair(scene, 0.1 if k < 7 else 0.3)]
    found = evidence(*cells)
    verdict = judge(claim(BETTER | {"scenes": scenes}), found)
    assert verdict.numbers.startswith("s0, calm over wild: FLIP ×0.500 (0.100 / 0.200); s1")
    assert "s7" in verdict.numbers
    assert verdict.numbers.endswith("and 5 more")
    assert verdict.counts == "7 of 9"
