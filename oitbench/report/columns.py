"""Columns that several tables share."""

from __future__ import annotations

from oitbench.report.artifacts import Column
from oitbench.truths import TRUTHS

SCENE = Column("scene", "Scene", kind="text")
METHOD = Column("method", "Method", kind="method")
_END = "of the interval that holds the true median with a probability of at least 95 %"
_PIXELS = {
    "transparent": "pixels with a transparent fragment",
    "opaque": "pixels without a transparent fragment",
}
DISTURBED = Column(
    "disturbed", "Disturbed", kind="text", help="whether other processes disturbed the times"
)
TIMES = (
    Column("method_ms", "Method time", "ms", help="median; sort and all passes"),
    Column("frame_ms", "Frame", "ms", help="median of method time plus shading"),
    Column("method_ms_low", "Low", "ms", help=f"lower end {_END}"),
    Column("method_ms_high", "High", "ms", help=f"upper end {_END}"),
    Column("sort_ms", "Sort", "ms", help="part of the method time, on the CPU; with the upload"),
    Column("shading_ms", "Shading", "ms", help="shadow maps, occlusion and opaque picture; shared"),
    DISTURBED,
)
"""Median method time and frame time, the interval of the former, its sort, and shading."""


RANKING_TRUTH = Column(
    "ranking_truth", "Ranked by", kind="text", help="the truth that ranks the methods of the scene"
)


def error(truth: str, metric: str) -> Column:
    """Return the column of a FLIP metric against a traced truth."""
    return Column(
        f"{truth}.{metric}",
        f"FLIP {truth}",
        decimals=4,
        help=f"mean {metric} against {TRUTHS[truth]}",
    )


def split_error(truth: str, pixels: str, metric: str) -> Column:
    """Return the column of a FLIP metric over the pixels that are "transparent" or "opaque"."""
    return Column(
        f"{truth}.{pixels}.{metric}",
        f"{truth.capitalize()}, {pixels}",
        decimals=4,
        help=f"mean {metric} against {TRUTHS[truth]} over the {_PIXELS[pixels]}",
    )


def noise_floor(truth: str, metric: str) -> Column:
    """Return the column of the noise floor of a FLIP metric against a traced truth."""
    return Column(
        f"{truth}.noise_floor.{metric}",
        f"{truth.capitalize()} floor",
        decimals=4,
        help=f"{metric} that the noise of {TRUTHS[truth]} alone causes",
    )
