"""Every cell with what it cost, how far it is from both truths, and what it could not do.

Rank: within a scene, cells whose path-traced FLIP differs by less than the noise floor are tied.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from oitbench.image import metrics
from oitbench.report import Artifact, Column, Note, write_table
from oitbench.report.artifacts import Value
from oitbench.results import records as read
from oitbench.results.records import EXACT, PATH_TRACED, Panel, Results
from oitbench.results.store import Record

title = "All results"
order = 20


def build(results: Results, out: Path) -> list[Artifact]:
    """Write one table of all cells."""
    panels = results.panels()
    if not panels:
        return [Note("There is no cell yet.")]
    rows = []
    for panel in panels:
        ranks = _ranks(panel, results.flip)
        rows += [_row(results, panel, cell, ranks) for cell in panel.cells]
        for ablation in panel.ablations:
            rows.append(_row(results, panel, ablation.without, {}, ", ".join(ablation.named)))
    caption = (
        "Click a heading to sort. Unstable cells hold pixels that are NaN, infinite or negative; "
        "no metric is given where a pixel is not finite. Equal ranks are ties: those cells differ "
        "by less than the noise floor of the path-traced reference. Without a rank are cells that "
        "leave effects out."
    )
    return [
        write_table(
            out / "table.csv", _columns(results.flip), rows, title="All cells", caption=caption
        )
    ]


def ties(errors: Sequence[tuple[str, float]], floor: float) -> dict[str, str]:
    """Rank by error; "2=" marks those that share a rank, within `floor` of its best."""
    groups: list[list[str]] = []
    best = 0.0
    for name, error in sorted(errors, key=lambda item: item[1]):
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
    errors = []
    floors = [0.0]
    for cell in panel.finished:
        value = read.metric(cell, PATH_TRACED, metric)
        if value is not None:
            errors.append((cell["method"], value))
            floors.append(read.noise_floor(cell, metric) or 0.0)
    return ties(errors, max(floors))


def _columns(flip: str) -> tuple[Column, ...]:
    rank_help = "place within the scene by path-traced FLIP; = marks ties within the noise floor"
    spread_help = "of a channel between random orders of the draws, linear; 0 is order independent"
    return (
        Column("scene", "Scene", kind="text"),
        Column("method", "Method", kind="method"),
        Column("left_out", "Left out", kind="text", help="effects that the scene calls for"),
        Column("status", "Status", kind="status"),
        Column(f"exact.{flip}", "FLIP exact", decimals=4, help=f"{flip} against exact compositing"),
        Column(
            f"path_traced.{flip}", "FLIP traced", decimals=4, help=f"{flip} against the path tracer"
        ),
        Column(f"noise_floor.{flip}", "noise floor", decimals=4, help="between two halves of it"),
        Column("path_traced.rank", "Rank", kind="rank", help=rank_help),
        Column(
            f"exact.{metrics.SSIM}",
            "SSIM",
            decimals=4,
            help=f"{metrics.SSIM} against exact; 1 is equal",
        ),
        Column(f"exact.{metrics.RMSE}", "RMSE", decimals=5, help=f"{metrics.RMSE} against exact"),
        Column(
            f"exact.{metrics.TRANSMITTANCE}",
            "T error",
            decimals=5,
            help="RMSE of the total transmittance",
        ),
        Column(
            f"exact.{metrics.ORDER_SPREAD_MAX}",
            "Order spread",
            decimals=5,
            help=f"largest difference {spread_help}",
        ),
        Column(
            f"exact.{metrics.ORDER_SPREAD_MEAN}",
            "mean spread",
            decimals=5,
            help=f"mean difference {spread_help}",
        ),
        Column("frame_ms", "Frame", "ms", help="median frame time"),
        Column("frame_ms_low", "low", "ms", help="lower end of the 95 % interval"),
        Column("frame_ms_high", "high", "ms", help="upper end of the 95 % interval"),
        Column("memory_mib", "Memory", "MiB"),
        Column("traffic_mb", "Traffic", "MB", help="bytes read and written per frame, 10^6"),
        Column("fragments", "Fragments"),
        Column("unstable_pixels", "Unstable", "px", help="NaN, infinite or negative pixels"),
        Column("missing_effects", "Missing effects", kind="text"),
        Column("reason", "Reason", kind="text"),
    )


def _row(
    results: Results, panel: Panel, cell: Record, ranks: dict[str, str], left_out: str = ""
) -> tuple[Value, ...]:
    finished = cell["status"] in read.FINISHED
    time = read.frame_time(cell) or (None, None, None)
    fragments = cell.get("fragments")
    return (
        panel.title,
        cell["method"],
        left_out,
        cell["status"],
        read.metric(cell, EXACT, results.flip),
        read.metric(cell, PATH_TRACED, results.flip),
        read.noise_floor(cell, results.flip),
        ranks.get(cell["method"]) if finished else None,
        read.metric(cell, EXACT, metrics.SSIM),
        read.metric(cell, EXACT, metrics.RMSE),
        read.metric(cell, EXACT, metrics.TRANSMITTANCE),
        read.metric(cell, EXACT, metrics.ORDER_SPREAD_MAX),
        read.metric(cell, EXACT, metrics.ORDER_SPREAD_MEAN),
        *time,
        read.total(cell, "memory", read.MEBIBYTE),
        read.total(cell, "traffic", read.MEGABYTE),
        None if fragments is None else int(fragments),
        read.unstable_pixels(cell) if finished else None,
        ", ".join(read.missing_effects(cell)),
        cell.get("reason") or "",
    )
