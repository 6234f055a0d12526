"""Columns that several tables share."""

from __future__ import annotations

from oitbench.report.artifacts import Column

SCENE = Column("scene", "Scene", kind="text")
METHOD = Column("method", "Method", kind="method")
FRAME_TIME = (
    Column("frame_ms", "Frame", "ms", help="median frame time"),
    Column("frame_ms_low", "Low", "ms", help="lower end of the 95 % interval of the median"),
    Column("frame_ms_high", "High", "ms", help="upper end of the 95 % interval of the median"),
)
"""Median frame time, and its interval."""


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
