"""Values of cells that several reports show: noise floors, totals of bytes, names of effects."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from oitbench.parameters import natural
from oitbench.results.records import Panel
from oitbench.results.schema import Outcome, Record


def outcomes(panel: Panel) -> list[tuple[Record, Outcome]]:
    """Return the finished cells of a panel with their outcomes."""
    return [(cell, cell.outcome) for cell in panel.finished if cell.outcome is not None]


def most_complete(cells: Iterable[Record], metric: str) -> Record | None:
    """Return the cell that misses the fewest effects; None if there are no cells.

    Among equals, it is the one with the lowest error against the truth that ranks them.
    """

    def shortcomings(cell: Record) -> tuple[int, float, Any]:
        error = cell.metric(cell.ranking_truth, metric)
        count = len(cell.missing_effects)
        return count, math.inf if error is None else error, natural(cell.method)

    return min(cells, key=shortcomings, default=None)


def total_memory(outcome: Outcome) -> int:
    """Return the bytes of a method and of the shading stages that all methods share."""
    return outcome.memory.bytes + outcome.shading.memory.bytes


def total_traffic(outcome: Outcome) -> int:
    """Return the bytes per frame of a method and of the shading stages that all methods share."""
    return outcome.traffic.bytes + outcome.shading.traffic.bytes


def listed_fragments(outcome: Outcome) -> int | None:
    """Return the fragments that lists hold; None if the method has no lists."""
    # One link is written for each.
    terms = outcome.traffic.terms
    found = (t.items for t in terms if t.resource.endswith(".next") and t.kind == "write")
    return next(found, None)


def effect_label(name: str) -> str:
    """Return the name of an effect as readers see it, such as "colored shadows"."""
    words = name.lower().split("_")
    return " ".join("AO" if word == "ao" else word for word in words)


def effect_labels(names: Iterable[str]) -> str:
    """Return the labels of several effects, separated by commas."""
    return ", ".join(map(effect_label, names))
