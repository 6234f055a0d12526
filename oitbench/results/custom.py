"""What a record holds of a metric of a user's file."""

from __future__ import annotations

from msgspec import Struct


class CustomMetric(Struct, frozen=True, forbid_unknown_fields=True):
    """A metric of a user's file: its direction, and the changes that a comparison ignores.

    `tolerance` is in the unit of the metric, and `relative_tolerance` a share of the value.
    `digest` is that of the file's code.
    """

    higher_is_better: bool
    tolerance: float
    relative_tolerance: float
    digest: str
