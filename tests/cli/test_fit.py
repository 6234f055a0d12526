"""`oitbench fit`: what it prints, and what it refuses."""

from __future__ import annotations

import re

import pytest

from tests.cli.helpers import Call
from tests.helpers import method

METHOD = "weighted_blended[weight=fitted,far_range=1000,far_power=6]"
SET = "weighted_blended[weight=fitted,near_range=1.7,near_power=2,far_range=1000,far_power=6]"


def test_the_best_label_and_the_errors_of_each_scene_are_printed(call: Call) -> None:
    options = ("--size", "16x16", "--views", "2", "--evaluations", "5")
    answer = call("fit", METHOD, "layer_stack[count=4,6]", *options)
    assert answer.code == 0, answer
    label, count, *errors = answer.out.splitlines()
    best = method(label)
    assert (best.values["weight"], best.values["far_range"]) == ("fitted", 1000)
    assert re.match(r"[1-5] evaluations; mean squared errors", count)
    assert len(errors) == 2
    assert errors[0].startswith("layer_stack[count=4]")
    for line in errors:
        numbers = re.search(r"training (\S+) -> (\S+)  held out (\S+) -> (\S+)$", line)
        assert numbers is not None
        assert all(float(number) > 0 for number in numbers.groups())


@pytest.mark.parametrize(
    ("chosen", "scene", "message"),
    [
        ("alpha_blend", "layer_stack", "alpha_blend has no parameter to fit"),
        (SET, "layer_stack", "weighted_blended has no parameter to fit"),
        ("weighted_blended[weight=7,8]", "layer_stack", "selects 2 methods; name one"),
        (METHOD, "fragment_lists", "fragment_lists has no views to hold out"),
        (METHOD, "no_such_scene", "no_such_scene"),
    ],
)
def test_fits_that_are_impossible_are_refused(
    call: Call, chosen: str, scene: str, message: str
) -> None:
    call("fit", chosen, scene, "--size", "16x16").assert_refused(message)
