"""Columns that several tables share."""

from __future__ import annotations

from oitbench.report.artifacts import Column

SCENE = Column("scene", "Scene", kind="text")
METHOD = Column("method", "Method", kind="method")
_END = "of the interval that holds the true median with a probability of at least 95 %"
TIMES = (
    Column("method_ms", "Method time", "ms", help="median; sorting, uploads and all passes"),
    Column("method_ms_low", "Low", "ms", help=f"lower end {_END}"),
    Column("method_ms_high", "High", "ms", help=f"upper end {_END}"),
    Column("sort_ms", "Sorting", "ms", help="part of the method time; with the upload"),
    Column("shading_ms", "Shading", "ms", help="shadow maps, occlusion and opaque picture; shared"),
    Column("frame_ms", "Frame", "ms", help="median of method time plus shading"),
)
"""Median method time with its interval, its part of sorting, shading, and frame time."""


def path_traced_error(metric: str) -> Column:
    """Return the column of a FLIP metric against path tracing."""
    return Column(
        f"path_traced.{metric}",
        "FLIP traced",
        decimals=4,
        help=f"mean {metric} against path tracing",
    )


def noise_floor(metric: str) -> Column:
    """Return the column of the noise floor of a FLIP metric."""
    return Column(
        f"noise_floor.{metric}",
        "Noise floor",
        decimals=4,
        help=f"{metric} between two halves of the samples of the path-traced reference",
    )
