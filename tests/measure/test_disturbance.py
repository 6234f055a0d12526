"""The CPU time of other processes."""

from __future__ import annotations

import pytest

from oitbench.measure.disturbance import Usage, foreign_share, usage
from oitbench.workers.cores import usable_cores


@pytest.mark.parametrize(
    ("everything", "own", "share"),
    [(2.0, 2.0, 0.0), (2.02, 1.0, 0.25), (4.02, 0.0, 1.0), (1.0, 1.25, 0.0), (9.0, 0.0, 1.0)],
    ids=["alone", "half of a core", "both cores", "own time is precise", "more than there is"],
)
def test_the_share_is_of_all_time_of_all_cores(everything: float, own: float, share: float) -> None:
    before = Usage(100.0, 10.0, 50.0, cores=2)
    after = Usage(100.0 + everything, 10.0 + own, 52.0, cores=2)
    assert foreign_share(before, after) == pytest.approx(share)


@pytest.mark.parametrize(("everything", "share"), [(0.12, 0.0), (0.14, 0.1)])
def test_ticks_of_a_short_block_are_not_foreign(everything: float, share: float) -> None:
    before, after = Usage(0.0, 0.0, 0.0, cores=2), Usage(everything, 0.1, 0.1, cores=2)
    assert foreign_share(before, after) == pytest.approx(share)


def test_an_unknown_share_is_none() -> None:
    moment = Usage(1.0, 1.0, 1.0, 2)
    assert foreign_share(None, moment) is None
    assert foreign_share(moment, None) is None
    assert foreign_share(moment, moment) is None


def test_the_accounts_of_this_machine_rise() -> None:
    before = usage()
    total = sum(number * number for number in range(2_000_000))
    after = usage()
    assert total > 0
    assert before is not None
    assert after is not None
    assert after.cores == len(usable_cores()) >= 1
    assert after.own > before.own
    assert after.all > before.all
    assert after.wall > before.wall
