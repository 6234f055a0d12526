"""Hard cases: scenes on which transparency methods fail, each with the right image.

No method promises them; a method that fails one is reported with its error. What no method may do
is to return NaN, infinite or negative pixels, or another image in a second run.
"""

from __future__ import annotations

from functools import cache

from oitbench.stability.cases import (
    bounded,
    extremes,
    limits,
    randomness,
    sums,
    ties,
    weights,
)
from oitbench.stability.check import Check


@cache
def cases() -> tuple[Check, ...]:
    """Return all hard cases."""
    return (
        *weights.cases(),
        *sums.cases(),
        *extremes.cases(),
        *bounded.cases(),
        *ties.cases(),
        *randomness.cases(),
        *limits.cases(),
    )
