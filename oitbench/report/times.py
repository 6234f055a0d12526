"""Times as reports show them: with a sign where other processes disturbed the measurement."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from oitbench.report.artifacts import SIGN, Marked
from oitbench.results.schema import Record
from oitbench.results.times import DISTURBED, Time

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


def marked(values: Mapping[str, Any], time: Time | None) -> dict[str, Any]:
    """Return the values of a row by column; disturbed times get the sign."""
    if time is None or not time.block.disturbed:
        return dict(values)
    return {
        key: Marked(value) if "_ms" in key and value is not None else value
        for key, value in values.items()
    }


def explain(records: Iterable[Record]) -> str:
    """Return a blank and the meaning of the sign, or "" if no cell has it."""
    return f" {EXPLANATION}" if any(map(is_disturbed, records)) else ""


def disturbed_scenes(records: Iterable[Record]) -> dict[str, float]:
    """Return the largest share of the CPU time that other processes took, by disturbed scene."""
    shares: dict[str, float] = {}
    for record in records:
        if record.time is not None and record.time.block.disturbed:
            share = record.time.block.foreign or 0.0
            shares[record.scene] = max(share, shares.get(record.scene, 0.0))
    return shares
