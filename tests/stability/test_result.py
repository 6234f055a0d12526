"""Results that count as failures."""

from __future__ import annotations

from typing import Any

import pytest

from oitbench.results.schema import Nonfinite
from oitbench.stability.result import BREAKS, DOES_NOT_APPLY, HOLDS, Status
from tests.stability.helpers import made_up


@pytest.mark.parametrize(
    ("status", "facts", "failed"),
    [
        (HOLDS, {"promised": True}, False),
        (BREAKS, {}, False),
        (BREAKS, {"promised": True}, True),
        (BREAKS, {"reason": "a shader does not compile"}, True),
        (DOES_NOT_APPLY, {"promised": True, "reason": "no such capability"}, False),
        (HOLDS, {"nonfinite": Nonfinite(nan=1)}, True),
        (HOLDS, {"nonfinite": Nonfinite(inf=1)}, True),
        (HOLDS, {"nonfinite": Nonfinite(negative=1)}, True),
        (HOLDS, {"nonfinite": Nonfinite(negative=1), "may_be_negative": True}, False),
        (BREAKS, {"nonfinite": Nonfinite(nan=1), "may_be_negative": True}, True),
        (HOLDS, {"repeatable": False}, True),
    ],
)
def test_results_that_count_as_failures(
    status: Status, facts: dict[str, Any], failed: bool
) -> None:
    assert made_up(status=status, **facts).failed == failed
