"""A record as one flat row, for data frames and CSV files."""

from __future__ import annotations

from typing import Any

from oitbench.image import metrics
from oitbench.results.schema import Record
from oitbench.results.statistics import SceneStatistics
from oitbench.results.times import Interval, Time
from oitbench.truths import EXACT, TRACED, TRUTHS

MEBIBYTE = 2**20
MEGABYTE = 10**6
_FORMULA = ("=", "+", "-", "−", "@")
_EXACT_ONLY = (metrics.TRANSMITTANCE, metrics.ORDER_SPREAD_MAX, metrics.ORDER_SPREAD_MEAN)
_FLOORS = (metrics.FLIP_LDR, metrics.FLIP_HDR, metrics.RMSE)


def flat(record: Record) -> dict[str, Any]:
    """Return a cell as one row; numbers that do not exist are None."""
    outcome = record.outcome
    row: dict[str, Any] = {
        "scene": record.seen,
        "view": record.view,
        "method": record.method,
        "name": record.name,
        "width": record.size[0],
        "height": record.size[1],
        "ssaa": record.ssaa,
        "effects": record.effects,
        "shading": record.shading,
        "status": record.status,
        "reason": record.reason,
        **flat_times(record.time),
        "memory_mib": outcome.memory.bytes / MEBIBYTE if outcome else None,
        "bits_per_pixel": outcome.memory.bits_per_pixel if outcome else None,
        "traffic_mb": outcome.traffic.bytes / MEGABYTE if outcome else None,
        **flat_statistics(outcome.statistics if outcome else None),
        "missing_effects": ", ".join(record.missing_effects),
        "unstable_pixels": outcome.nonfinite.total if outcome else 0,
    }
    row["ranking_truth"] = record.ranking_truth if outcome else None
    for truth in TRUTHS:
        scores = outcome.scores.get(truth) if outcome else None
        row |= {f"{truth}.{name}": record.metric(truth, name) for name in metrics.NAMES}
        for name in (metrics.FLIP_LDR, metrics.FLIP_HDR):
            row[f"{truth}.transparent.{name}"] = scores.transparent.get(name) if scores else None
            row[f"{truth}.opaque.{name}"] = scores.opaque.get(name) if scores else None
        custom = outcome.custom if outcome else ()
        row |= {f"{truth}.{name}": record.metric(truth, name) for name in custom}
    row |= {f"{EXACT}.{name}": record.metric(EXACT, name) for name in _EXACT_ONLY}
    for truth in TRACED:
        scores = outcome.scores.get(truth) if outcome else None
        facts = scores.reference if scores else None
        row |= {f"{truth}.noise_floor.{name}": record.noise_floor(truth, name) for name in _FLOORS}
        for name in ("ssaa", "spp", "parts", "seconds"):
            row[f"{truth}.reference.{name}"] = getattr(facts, name, None)
    return row


def flat_statistics(found: SceneStatistics | None) -> dict[str, float | None]:
    """Return the statistics of a scene."""
    complexity = found.complexity if found else None
    return {
        "objects": found.objects if found else None,
        "transparent_objects": found.transparent_objects if found else None,
        "triangles": found.triangles if found else None,
        "transparent_triangles": found.transparent_triangles if found else None,
        "draws": found.draws if found else None,
        "fragments": found.fragments if found else None,
        "covered_pixels": found.covered_pixels if found else None,
        "mean_depth_complexity": complexity.mean if complexity else None,
        "median_depth_complexity": complexity.median if complexity else None,
        "max_depth_complexity": complexity.worst if complexity else None,
    }


def flat_times(time: Time | None) -> dict[str, float | None]:
    """Return the times with their intervals, and the share of other processes in percent."""
    parts = ("method_ms", "sort_ms", "shading_ms", "frame_ms")
    found: dict[str, float | None] = {}
    for name in parts:
        part: Interval | None = getattr(time, name, None)
        found[name] = part.median if part else None
        found[f"{name}_low"] = part.low if part else None
        found[f"{name}_high"] = part.high if part else None
    foreign = time.block.foreign if time else None
    return {**found, "foreign_percent": None if foreign is None else 100 * foreign}


def shielded(value: object) -> object:
    """Return a field of a CSV file that no spreadsheet runs as a formula.

    Text that begins like a formula gets an apostrophe in front, as OWASP advises ("CSV injection").
    """
    begins = isinstance(value, str) and value.lstrip().startswith(_FORMULA)
    return f"'{value}" if begins else value
