"""Each constraint refuses the cells that exceed it, with a reason, and no others."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest

from oitbench.choosing.constraints import Constraints
from oitbench.results.times import Interval
from tests.choosing.made_up import cell, demanding
from tests.made_up import failed, timed

LISTS = demanding(atomics=True, unbounded=True, dual_source=True)


@pytest.mark.parametrize(
    ("limit", "demands", "reason"),
    [
        ({"bits": 128}, {"tile_bits": 129}, "needs 129 bits of tile memory"),
        ({"bits": 128}, {"tile_bits": 128}, ""),
        ({"passes": 1}, {"geometry_passes": 2}, "needs 2 geometry passes"),
        ({"passes": 2}, {"geometry_passes": 2}, ""),
        ({"passes": 99}, {"geometry_passes": None}, "geometry passes grow with the layers"),
        ({"targets": 4}, {"targets": 5}, "writes 5 targets in a pass"),
        ({"dual_source": False}, {"dual_source": True}, "needs dual-source blending"),
        ({"interlock": False}, {"programmable": True}, "needs framebuffer fetch or interlock"),
        ({"interlock": False}, {"atomics": True}, ""),
        ({"atomics": False}, {"atomics": True}, "needs buffers with atomics"),
        ({"atomics": False}, {"programmable": True}, ""),
        ({"capability_class": "targets"}, {"targets": 3}, ""),
        ({"capability_class": "blending"}, {"targets": 3}, "needs multiple targets"),
        ({"capability_class": "dual-source"}, {"programmable": True}, "needs framebuffer fetch or"),
        ({"capability_class": "interlock"}, {"dual_source": True}, ""),
        ({"msaa": 4}, {"samples": 4, "offered": (1, 4)}, ""),
        ({"msaa": 4}, {"offered": (1, 4)}, "has 1 sample per pixel; run it with msaa=4"),
        ({"msaa": 4}, {"samples": 8, "offered": (8,)}, "has 8 samples per pixel"),
        ({}, {"tile_bits": 10**6, "geometry_passes": None, "programmable": True}, ""),
    ],
)
def test_demands_meet_a_limit_or_not(
    limit: dict[str, Any], demands: dict[str, Any], reason: str
) -> None:
    found = Constraints(**limit).unmet(cell("mean", demands=demanding(**demands)))
    assert len(found) == bool(reason)
    assert all(text.startswith(reason) for text in found)


def test_one_need_is_one_reason() -> None:
    limits = Constraints(capability_class="targets", interlock=False)
    assert len(limits.unmet(cell("mean", demands=demanding(programmable=True)))) == 1
    assert len(Constraints(atomics=False, dual_source=False).unmet(cell("m", demands=LISTS))) == 2


@pytest.mark.parametrize(
    ("status", "reason"),
    [("unstable", "pixels: 3 nan"), ("suspect", "nothing was drawn"), ("failed", "no shader")],
)
def test_cells_without_trustworthy_pictures_fit_nothing(status: str, reason: str) -> None:
    make = failed if status == "failed" else cell
    assert Constraints().unmet(make("mean", status=status, reason=reason)) == [
        f"{status}: {reason}"
    ]


# The interval of a made-up time of 2 ms with a swing of 0.4 is 1.7 to 2.3 ms.
@pytest.mark.parametrize(
    ("limit", "slow", "tie"),
    [(1.69, True, False), (1.7, False, True), (2.29, False, True), (2.3, False, False)],
)
def test_a_time_fits_unless_its_whole_interval_is_above_the_limit(
    limit: float, slow: bool, tie: bool
) -> None:
    time = timed(2.0, swing=0.4)
    assert (time.method_ms.ends) == pytest.approx((1.7, 2.3))
    limits = Constraints(milliseconds=limit)
    assert limits.unmet(cell("mean", time=time)) == (["takes 2 ms"] if slow else [])
    assert limits.ties(time) is tie


def test_times_that_cannot_be_trusted_do_not_fit() -> None:
    limits = Constraints(milliseconds=100.0)
    (reason,) = limits.unmet(cell("mean", time=timed(2.0, foreign=0.2)))
    assert "disturbed" in reason
    few = msgspec.structs.replace(timed(2.0), method_ms=Interval(2.0, None, None, None, [2.0]))
    (reason,) = limits.unmet(cell("mean", time=few))
    assert "too few samples" in reason
    untimed = msgspec.structs.replace(cell("mean"), time=None)
    assert limits.unmet(untimed) == ["was not timed"]
    assert Constraints().unmet(untimed) == []


def test_constraints_are_stated_in_words() -> None:
    assert str(Constraints()) == "no constraint"
    found = str(Constraints("targets", 128, 1, 1, False, False, False, 4, 5.0))
    assert found == (
        "class multiple targets, at most 128 bits of tile memory, at most 1 geometry pass,"
        " at most 1 target in a pass, no dual-source blending, no framebuffer fetch or interlock,"
        " no buffers with atomics, 4 samples per pixel, method time up to 5 ms"
    )
