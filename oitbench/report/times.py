"""Times as reports show them: with a sign where other processes disturbed the measurement."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from oitbench.report.artifacts import Marked
from oitbench.results.schema import Record
from oitbench.results.times import DISTURBED, SIGN

EXPLANATION = (
    f"{SIGN} disturbed: other processes took more than {DISTURBED:.0%} of the CPU time while the "
    "scene was timed, also when it was timed again."
)
SHORT_EXPLANATION = f"{SIGN} disturbed by other processes"


def is_disturbed(record: Record) -> bool:
    """Return whether other processes disturbed the times of a cell."""
    return record.time is not None and record.time.block.disturbed


def signed(label: str, disturbed: bool) -> str:
    """Return a label with the sign of disturbed times, if it needs it."""
    return f"{label} {SIGN}" if disturbed else label


def marked(values: Mapping[str, Any], disturbed: bool) -> dict[str, Any]:
    """Return the values of a row by column, and whether its times are disturbed.

    Disturbed times get the sign. A CSV file shows numbers without it, but has the column.
    """
    if not disturbed:
        return {**values, "disturbed": ""}
    times = {
        key: Marked(value)
        for key, value in values.items()
        if value is not None and ("_ms" in key or key == "ms")
    }
    return {**values, **times, "disturbed": "yes"}


def explain(records: Iterable[Record]) -> str:
    """Return a blank and the meaning of the sign, or "" if no cell has it."""
    return f" {EXPLANATION}" if any(map(is_disturbed, records)) else ""


def disturbed_scenes(records: Iterable[Record]) -> dict[str, float]:
    """Return the largest share of the CPU time that other processes took, by disturbed scene."""
    shares: dict[str, float] = {}
    for record in records:
        if record.time is not None and record.time.block.disturbed:
            share = record.time.block.foreign or 0.0
            shares[record.seen] = max(share, shares.get(record.seen, 0.0))
    return shares
