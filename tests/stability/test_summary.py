"""Tables of counts, and descriptions of faults."""

from __future__ import annotations

from dataclasses import dataclass
from io import StringIO
from typing import Any

import msgspec
import pytest
from rich.console import Console

from oitbench.results.schema import Nonfinite
from oitbench.stability import summary
from oitbench.stability.result import BREAKS, DOES_NOT_APPLY, HOLDS, CheckResult, Status
from tests.stability.helpers import made_up

ERROR = {"identity": True, "promised": True, "error": 0.51234, "allowed": 0.00198}


def cells(results: list[CheckResult]) -> list[list[str]]:
    """Return the printed cells of each row."""
    out = StringIO()
    Console(file=out, width=120).print(summary.table(results))
    rows = [line.split("│") for line in out.getvalue().splitlines() if line.startswith("│")]
    return [[cell.strip() for cell in row[1:-1]] for row in rows]


def test_a_row_counts_the_checks_that_hold_of_those_that_apply() -> None:
    results = [
        made_up("opaque_unchanged", identity=True, promised=True),
        made_up("single_layer_exact", BREAKS, **ERROR),
        made_up("colored_layer_exact", DOES_NOT_APPLY, identity=True),
        made_up("white_furnace", BREAKS, identity=True),
        made_up("two halves", BREAKS),
        made_up("near opaque"),
        made_up("near black"),
    ]
    other = [msgspec.structs.replace(result, method="other") for result in results[1:3]]
    assert cells(results + other) == [
        ["some[k=2]", "1 of 2", "0 of 1", "2 of 3", "1"],
        ["other", "0 of 1", "–", "–", "1"],
    ]


@dataclass
class Case:
    status: Status
    facts: dict[str, Any]
    faults: list[str]


@pytest.mark.parametrize(
    "case",
    [
        Case(HOLDS, {}, []),
        Case(BREAKS, {}, []),
        Case(BREAKS, ERROR, ["breaks swept layer (error 0.51, allowed 0.002)"]),
        Case(BREAKS, {**ERROR, "error": None}, ["breaks swept layer (the error is not finite)"]),
        Case(BREAKS, {"promised": True, "reason": "x"}, ["no image for swept layer: x"]),
        Case(DOES_NOT_APPLY, {"reason": "x"}, []),
        Case(HOLDS, {"repeatable": False}, ["swept layer: the image changes between runs"]),
        Case(
            HOLDS,
            {"nonfinite": Nonfinite(nan=2, inf=1, negative=3)},
            [
                "swept layer: 2 NaN pixels",
                "swept layer: 1 infinite pixel",
                "swept layer: 3 negative pixels",
            ],
        ),
        Case(HOLDS, {"nonfinite": Nonfinite(negative=3), "may_be_negative": True}, []),
    ],
)
def test_faults_are_described(case: Case) -> None:
    assert summary.faults([made_up(status=case.status, **case.facts)]) == case.faults


def test_a_reason_is_stated_once() -> None:
    results = [made_up(name, BREAKS, reason="does not compile") for name in ("one", "two")]
    assert summary.faults(results) == ["no image for 2 checks: does not compile"]
    other = msgspec.structs.replace(results[0], method="other")
    idle = made_up("scatter", DOES_NOT_APPLY, reason="not random")
    assert summary.without_image([*results, other, idle, made_up("three", BREAKS, **ERROR)]) == [
        "some[k=2]: no image for 2 checks: does not compile",
        "other: no image for one: does not compile",
    ]
    assert summary.broken(results) == []


def test_variants_that_did_not_run_are_listed() -> None:
    idle = [made_up(str(i), DOES_NOT_APPLY, reason="some[k=2]: no memory") for i in range(3)]
    idle = [made_up("scatter", DOES_NOT_APPLY, reason="not random"), *idle]
    faulty = msgspec.structs.replace(made_up("swept layer", BREAKS, **ERROR), method="other")
    assert summary.idle([*idle, faulty]) == ["some[k=2]: not run: no memory"]


VALUES = {"error": 0.5, "allowed": 0.01, "expected": 0.25, "found": 0.75}


@pytest.mark.parametrize(
    ("facts", "row"),
    [
        (
            {"identity": True, "promised": True, **VALUES},
            ("0.25", "0.75", "0.01", "promise broken"),
        ),
        ({"identity": True, **VALUES}, ("0.25", "0.75", "0.01", "not promised")),
        (VALUES, ("0.25", "0.75", "0.01", "hard case")),
        ({**VALUES, "in_mean": True}, ("0.25", "0.75 in the mean", "0.01", "hard case")),
        (
            {**VALUES, "error": None, "found": None},
            ("0.25", "not finite", "0.01", "hard case"),
        ),
        ({**VALUES, "nonfinite": Nonfinite(nan=2)}, ("", "2 NaN pixels", "", "fault")),
    ],
)
def test_what_breaks_is_a_row_with_both_values(facts: dict[str, Any], row: tuple[str, ...]) -> None:
    (found,) = summary.broken([made_up("case", BREAKS, **facts), made_up("well")])
    assert found == ("some[k=2]", "case", *row)


def test_a_picture_that_changes_is_a_fault_though_the_check_holds() -> None:
    (found,) = summary.broken([made_up("case", HOLDS, repeatable=False)])
    assert (found.measured, found.verdict) == ("the image changes between runs", "fault")


def test_variants_that_break_the_same_are_one_row_and_failures_come_first() -> None:
    mild = made_up("case", BREAKS, **VALUES)
    severe = msgspec.structs.replace(mild, method="some[k=4]", error=5.0, found=5.25)
    promise = made_up("other", BREAKS, identity=True, promised=True, **VALUES)
    first, second = summary.broken([mild, severe, mild, promise])
    assert first.verdict == "promise broken"
    assert (second.method, second.measured) == ("some[k=4] +2", "5.25")
