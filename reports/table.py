"""Each cell with its cost, errors against all truths, and missing effects.

Ranks compare the cells of one scene by FLIP against the truth that ranks it: exact compositing if
all effects that the scene requests are compositing or shared shading, else matched tracing. Cells
that do not clearly differ from the best cell of a rank share that rank. Full path tracing is
context, and ranks nothing. Errors against exact compositing in a scene that it does not rank are
marked "compositing only".
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from oitbench.image import metrics
from oitbench.report import Artifact, Column, ReportContext, columns, times, write_table
from oitbench.report.artifacts import Row
from oitbench.report.cells import effect_labels
from oitbench.results.ranking import EXPLANATION, ranking
from oitbench.results.records import Panel, Results
from oitbench.results.schema import Record
from oitbench.results.table import flat
from oitbench.truths import COMPOSITING_ONLY, EXACT, FULL, MATCHED, TRUTHS

title = "All results"
order = 20


def build(context: ReportContext) -> list[Artifact]:
    """Write one table of all cells."""
    custom = _custom_columns(context.results)
    heading = (*_columns(context.flip), *custom)
    rows: list[Row] = []
    for panel in context.results.panels():
        ranks = ranking(panel, context.flip).ranks
        rows += [_row(heading, panel, cell, rank=ranks.get(cell.method)) for cell in panel.cells]
        for ablation in panel.ablations:
            left_out = effect_labels(ablation.named)
            rows.append(_row(heading, panel, ablation.reduced, left_out=left_out))
    if not rows:
        return []
    caption = (
        "Click on a heading to sort. The status is unstable if pixels are NaN, infinite or "
        "negative; there are no metrics if a pixel is not finite. Equal ranks, marked with =, are "
        f"ties. {EXPLANATION} Cells with effects left out have no rank; their traced truths leave "
        "out the same effects. Full path tracing is context. Method time is everything that a "
        "method adds to a frame, its sort included. Shading is the same for all methods of a "
        "scene, and frame time is the median sum of both." + times.explain(context.results.records)
    )
    return [
        write_table(context.out / "table.csv", heading, rows, title="All cells", caption=caption)
    ]


def _row(
    heading: Sequence[Column],
    panel: Panel,
    cell: Record,
    *,
    rank: str | None = None,
    left_out: str = "",
) -> Row:
    # A cell may lack a metric that others have.
    values: dict[str, Any] = {column.key: None for column in heading}
    values |= times.marked(flat(cell), times.is_disturbed(cell)) | {
        "scene": panel.title,
        "left_out": left_out,
        "rank": rank,
        "exact.remark": "" if cell.ranking_truth == EXACT else COMPOSITING_ONLY,
        "missing_effects": effect_labels(cell.missing_effects),
    }
    if not cell.finished:
        values["unstable_pixels"] = None
    return tuple(values[column.key] for column in heading)


def _columns(flip: str) -> tuple[Column, ...]:
    return (
        columns.SCENE,
        columns.METHOD,
        Column("left_out", "Left out", kind="text", help="requested effects that are left out"),
        Column("status", "Status", kind="status"),
        columns.RANKING_TRUTH,
        Column("rank", "Rank", kind="rank", help="by the ranking truth; = marks ties"),
        _error(flip, "FLIP exact", 4, "mean against exact compositing"),
        columns.error(MATCHED, flip),
        columns.error(FULL, flip),
        *columns.TIMES,
        Column("exact.remark", "Exact is", kind="text", help="it may ignore requested effects"),
        columns.noise_floor(MATCHED, flip),
        columns.split_error(MATCHED, "transparent", flip),
        columns.split_error(MATCHED, "opaque", flip),
        columns.noise_floor(FULL, flip),
        columns.split_error(FULL, "transparent", flip),
        columns.split_error(FULL, "opaque", flip),
        Column(f"{MATCHED}.reference.ssaa", "Matched ssaa", help="sub-pixel grid of the reference"),
        Column("ssaa", "ssaa", help="sub-pixel grid of the method's picture"),
        _error(metrics.SSIM, "SSIM", 4, "SSIM against exact compositing; 1 if equal"),
        _error(metrics.RMSE, "RMSE", 5, "linear RMSE against exact compositing"),
        _error(metrics.TRANSMITTANCE, "T error", 5, "RMSE of the total transmittance"),
        _error(
            metrics.ORDER_SPREAD_MAX,
            "Order spread",
            5,
            "largest linear difference between random orders of the draws; 0: order independent",
        ),
        _error(
            metrics.ORDER_SPREAD_MEAN,
            "Mean spread",
            5,
            "mean linear difference between random orders of the draws",
        ),
        Column("foreign_percent", "Others", "%", help="CPU time of other processes meanwhile"),
        Column("memory_mib", "Memory", "MiB", help="2^20 bytes"),
        Column("traffic_mib", "Traffic", "MiB", help="read and written per frame, 2^20 bytes"),
        Column("fragments", "Fragments", help="transparent fragments per frame"),
        Column("unstable_pixels", "Unstable", "px", help="NaN, infinite or negative pixels"),
        Column("missing_effects", "Missing effects", kind="text"),
        Column("reason", "Reason", kind="text"),
    )


def _custom_columns(results: Results) -> tuple[Column, ...]:
    """Return the columns of users' metrics, against each truth for which there are values."""
    return tuple(
        Column(
            f"{truth}.{name}",
            f"{name} {truth}",
            decimals=4,
            help=f"against {TRUTHS[truth]}; {'higher' if facts.higher_is_better else 'lower'} is"
            " better",
        )
        for name, facts in results.custom.items()
        for truth in TRUTHS
        if any(record.metric(truth, name) is not None for record in results.records)
    )


def _error(metric: str, heading: str, decimals: int, text: str) -> Column:
    """Return the column of a metric against exact compositing; the tooltip has its full name."""
    return Column(f"{EXACT}.{metric}", heading, decimals=decimals, help=f"{metric}: {text}")
