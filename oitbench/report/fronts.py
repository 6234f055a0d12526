"""The Pareto front of a cost and an error, which the noise of a truth does not decide."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol, TypeVar

from oitbench.image.ties import Errors, clear_difference
from oitbench.report.error_axis import FLOOR


class Priced(Protocol):
    """An item with a cost and an error."""

    @property
    def cost(self) -> float:
        """Time or bytes."""

    @property
    def errors(self) -> Errors:
        """The error, with the parts that its uncertainty follows from."""


Item = TypeVar("Item", bound=Priced)


def front(items: Iterable[Item]) -> list[Item]:
    """Return the items that clearly have less error than all cheaper ones, cheapest first.

    An item that ties with a cheaper one, within the noise of their truth, is not on the front.
    Errors that share the last place of the axis count as equal.
    """
    kept: list[Item] = []
    for item in sorted(items, key=lambda item: (item.cost, item.errors.error)):
        if not kept or _is_better(item.errors, kept[-1].errors):
            kept.append(item)
    return kept


def _is_better(one: Errors, other: Errors) -> bool:
    return other.error > FLOOR and clear_difference(one, other) < 0
