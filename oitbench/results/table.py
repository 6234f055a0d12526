"""A record as one flat row, for data frames and CSV files."""

from __future__ import annotations

from typing import Any

from oitbench import parameters
from oitbench.image import metrics
from oitbench.results.schema import Record
from oitbench.results.statistics import SceneStatistics
from oitbench.results.times import Interval, Time
from oitbench.truths import EXACT, TRACED, TRUTHS

MEBIBYTE = 2**20
_FORMULA = ("=", "+", "-", "−", "@")
_EXACT_ONLY = (metrics.TRANSMITTANCE, metrics.ORDER_SPREAD_MAX, metrics.ORDER_SPREAD_MEAN)
PARAMETERS = ("scene.", "method.")
"""How the columns of parameters begin in a row of `plain`."""
_PLAIN = {
    metrics.FLIP_LDR: "flip",
    metrics.FLIP_HDR: "flip_hdr",
    metrics.SSIM: "ssim",
    metrics.PSNR: "psnr",
    metrics.RMSE: "rmse",
    metrics.RELMSE: "relmse",
    metrics.ORDER_SPREAD_MAX: "order_spread_max",
    metrics.ORDER_SPREAD_MEAN: "order_spread_mean",
}
"""Names of metrics without their parameters."""
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
        "traffic_mib": outcome.traffic.bytes / MEBIBYTE if outcome else None,
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


def plain(record: Record) -> dict[str, Any]:
    """Return a cell as one row whose names are words, for data frames.

    The columns are those of `flat`, with `flip_exact` for a metric against a truth, `flip` for the
    same against the ranking truth, and `method.NAME` and `scene.NAME` for parameters; of a scene's
    parameters, those that differ from their defaults.
    """
    row: dict[str, Any] = {}
    for name, value in flat(record).items():
        row[_plain_name(name)] = value
        if name == "reason":
            row |= _parameters(record)
        if name == "ranking_truth":
            custom = record.outcome.custom if record.outcome else ()
            for metric in (*metrics.NAMES, *custom):
                row[_PLAIN.get(metric, metric)] = record.metric(record.ranking_truth, metric)
    return row


def _plain_name(name: str) -> str:
    """Return `flip_transparent_exact` for `exact.transparent.flip_ldr@67ppd`."""
    truth, dot, rest = name.partition(".")
    if not dot or truth not in TRUTHS:
        return name
    group, dot, metric = rest.partition(".")
    if dot and group in ("transparent", "opaque", "noise_floor"):
        return f"{_PLAIN.get(metric, metric)}_{group}_{truth}"
    if dot and group == "reference":
        return f"reference_{metric}_{truth}"
    return f"{_PLAIN.get(rest, rest)}_{truth}"


def _parameters(record: Record) -> dict[str, Any]:
    scene = parameters.parse(record.scene).grid
    method = record.outcome.parameters if record.outcome else {}
    of_scene, of_method = PARAMETERS
    found: dict[str, Any] = {f"{of_scene}{name}": text for name, (text,) in scene.items()}
    return found | {f"{of_method}{name}": value for name, value in method.items()}


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
