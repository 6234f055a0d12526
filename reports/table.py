"""All cells with cost, errors against both truths, and missing effects.

Ranks compare the cells of one scene by path-traced FLIP. Cells that differ from the best cell of a
rank by no more than the noise floor share that rank.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from oitbench.image import metrics
from oitbench.report import Artifact, Column, ReportContext, columns, times, write_table
from oitbench.report.artifacts import Row
from oitbench.report.cells import effect_labels, largest_noise_floor
from oitbench.results.records import Panel
from oitbench.results.schema import EXACT, PATH_TRACED, Record
from oitbench.results.table import flat

title = "All results"
order = 20


def build(context: ReportContext) -> list[Artifact]:
    """Write one table of all cells."""
    heading = _columns(context.flip)
    rows: list[Row] = []
    for panel in context.results.panels():
        ranks = _ranks(panel, context.flip)
        rows += [_row(heading, panel, cell, rank=ranks.get(cell.method)) for cell in panel.cells]
        for ablation in panel.ablations:
            left_out = effect_labels(ablation.named)
            rows.append(_row(heading, panel, ablation.reduced, left_out=left_out))
    if not rows:
        return []
    caption = (
        "Click on a heading to sort. The status is unstable if pixels are NaN, infinite or "
        "negative; there are no metrics if a pixel is not finite. Equal ranks, marked with =, are "
        "ties: the errors differ by no more than the noise floor of the path-traced reference. "
        "Cells with effects left out have no rank. Method time is everything that a method adds to "
        "a frame, its sorting included. Shading is the same for all methods of a scene, and frame "
        "time is the median sum of both." + times.explain(context.results.records)
    )
    return [
        write_table(context.out / "table.csv", heading, rows, title="All cells", caption=caption)
    ]


def ties(errors: Mapping[str, float], floor: float) -> dict[str, str]:
    """Rank names by error, lowest first.

    Names whose errors exceed the lowest error of a rank by no more than `floor` share that rank,
    which is then marked as in "2=".
    """
    groups: list[list[str]] = []
    best = 0.0
    for name, error in sorted(errors.items(), key=lambda item: item[1]):
        if groups and error - best <= floor:
            groups[-1].append(name)
        else:
            groups.append([name])
            best = error
    ranks: dict[str, str] = {}
    place = 1
    for group in groups:
        mark = "=" if len(group) > 1 else ""
        ranks |= dict.fromkeys(group, f"{place}{mark}")
        place += len(group)
    return ranks


def _ranks(panel: Panel, metric: str) -> dict[str, str]:
    values = {cell.method: cell.metric(PATH_TRACED, metric) for cell in panel.finished}
    errors = {method: value for method, value in values.items() if value is not None}
    return ties(errors, largest_noise_floor(panel.finished, metric) or 0.0)


def _row(
    heading: Sequence[Column],
    panel: Panel,
    cell: Record,
    *,
    rank: str | None = None,
    left_out: str = "",
) -> Row:
    values = times.marked(flat(cell), cell.time) | {
        "scene": panel.title,
        "left_out": left_out,
        "path_traced.rank": rank,
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
        _error(flip, "FLIP exact", 4, "mean against exact compositing"),
        columns.path_traced_error(flip),
        columns.noise_floor(flip),
        Column(
            "path_traced.rank",
            "Rank",
            kind="rank",
            help="in the scene by path-traced FLIP; = marks ties within the noise floor",
        ),
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
        *columns.TIMES,
        Column("foreign_percent", "Others", "%", help="CPU time of other processes meanwhile"),
        Column("memory_mib", "Memory", "MiB", help="2^20 bytes"),
        Column("traffic_mb", "Traffic", "MB", help="bytes read and written per frame, 10^6 bytes"),
        Column("fragments", "Fragments", help="transparent fragments per frame"),
        Column("unstable_pixels", "Unstable", "px", help="NaN, infinite or negative pixels"),
        Column("missing_effects", "Missing effects", kind="text"),
        Column("reason", "Reason", kind="text"),
    )


def _error(metric: str, heading: str, decimals: int, text: str) -> Column:
    """Return the column of a metric against exact compositing; the tooltip has its full name."""
    return Column(f"{EXACT}.{metric}", heading, decimals=decimals, help=f"{metric}: {text}")
