"""Made-up cells of methods with known errors, demands and times."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import msgspec

from oitbench.choosing.choice import METRIC
from oitbench.method.demands import NOTHING, Demands
from oitbench.results.schema import Record
from oitbench.results.times import Time
from oitbench.truths import EXACT
from tests.made_up import changed, record, timed


def cell(
    method: str,
    error: float | None = 0.1,
    scene: str = "panes",
    *,
    demands: Demands = NOTHING,
    time: Time | None = None,
    jackknife: Sequence[float] = (),
    **fields: Any,
) -> Record:
    """Return a finished cell whose scene is ranked by exact compositing.

    Parameters
    ----------
    method : str
    error : float, optional
        FLIP against exact compositing.
    scene : str
    demands : Demands
    time : Time, optional
        Default: 2 ms.
    jackknife : sequence of float
        The same error without each part of a truth.
    **fields
        Further fields of `Record`.
    """
    made = record(method, scene, **({"time": time or timed(2.0)} | fields))
    made = changed(made, "outcome.demands", demands)
    made = changed(made, f"outcome.scores.{EXACT}.jackknife", {METRIC: list(jackknife)})
    found: Record = changed(made, f"outcome.scores.{EXACT}.metrics.{METRIC}", error)
    return found


def demanding(**fields: Any) -> Demands:
    """Return the demands of an empty plan with other values for some facts."""
    return msgspec.structs.replace(NOTHING, **fields)
