"""Baselines: the metrics and counts of a run in one small file for version control.

A baseline holds one flat row per cell: the quality metrics, rounded; the counts that a renderer
repeats exactly; status, effects and passes. It holds no times, and nothing about the machine except
the name of its renderer. A run with cells that have no numbers is no baseline: a comparison with
nothing always passes.

The project's own baseline, which guards every change, is written anew with

    .venv/bin/python -m tests.guard

after a change that is meant to affect a metric or a count, or that adds a method. The difference in
tests/baseline.json shows the effect of the change; read it before committing.
"""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec

from oitbench import json_text
from oitbench.atomic import replacing
from oitbench.errors import UsageError
from oitbench.image import metrics
from oitbench.results.custom import CustomMetric
from oitbench.results.records import Results
from oitbench.results.schema import FINISHED, WHOLE, PassRuns, Record
from oitbench.results.times import Interval
from oitbench.truths import EXACT, TRUTHS

Entry = int | float | str | None
Row = Mapping[str, Entry]
"""A cell as flat fields: `exact.rmse_lin`, `traffic.bytes`, `effects.missing`, …"""

FORMAT = 4
METRICS = (
    *metrics.NAMES,
    metrics.TRANSMITTANCE,
    metrics.ORDER_SPREAD_MAX,
    metrics.ORDER_SPREAD_MEAN,
)
_DIGITS = 5
_DECIMALS = 6


@dataclass(frozen=True)
class Snapshot:
    """The cells of a results folder, or of a baseline file.

    Parameters
    ----------
    renderer : str
        Name that OpenGL reports.
    rows : mapping of str to Row
        By the cell's label: scene, method, size and settings.
    times : mapping of str to Interval
        Method times that nothing disturbed; a baseline file has none.
    custom : mapping of str to CustomMetric
        The metrics of users' files by name.
    """

    renderer: str
    rows: Mapping[str, Row]
    times: Mapping[str, Interval] = field(default_factory=dict)
    custom: Mapping[str, CustomMetric] = field(default_factory=dict)


def label(record: Record) -> str:
    """Return a cell's name: scene, method, size and settings, separated by blanks."""
    width, height = record.size
    settings = f"effects={record.effects} ssaa={record.ssaa}"
    settings += f" shading={record.shading}" if record.shading else ""
    return f"{record.seen} {record.method} {width}x{height} {settings}"


def row(record: Record) -> Row:
    """Return the fields of a record that are compared; fields that it lacks are left out."""
    fields: dict[str, Entry] = {"status": record.status}
    outcome = record.outcome
    if outcome is None:
        return fields
    fields["fragments"] = outcome.statistics.fragments
    fields["max_depth_complexity"] = outcome.statistics.complexity.worst
    fields["memory.bytes"] = outcome.memory.bytes
    fields["traffic.bytes"] = outcome.traffic.bytes
    for kind in ("nan", "inf", "negative"):
        fields[f"nonfinite.{kind}"] = getattr(outcome.nonfinite, kind)
    for kind in ("requested", "expressed", "missing"):
        fields[f"effects.{kind}"] = ", ".join(getattr(outcome.effects, kind))
    fields["passes"] = _passes(outcome.passes)
    fields["ranking_truth"] = record.ranking_truth
    for truth, scores in outcome.scores.items():
        for name in (*METRICS, *outcome.custom):
            if name in scores.metrics:
                fields[f"{truth}.{name}"] = _rounded(scores.metrics[name])
    return fields


def read(path: Path | str) -> Snapshot:
    """Read a results folder, or a baseline file.

    Raises
    ------
    UsageError
        If it is neither.
    """
    path = Path(path)
    return _read_folder(path) if path.is_dir() else _read_file(path)


def save(folder: Path | str, path: Path | str) -> Snapshot:
    """Write the baseline of a results folder to the file `path`, and return its content.

    Raises
    ------
    UsageError
        The folder holds no results, a cell failed or has no numbers, or the file cannot be written.
    """
    snapshot = _read_folder(Path(folder))
    _check_each(f"{folder}", snapshot.rows)
    custom = msgspec.to_builtins(snapshot.custom)
    content: dict[str, Any] = {
        "cells": snapshot.rows,
        "checksum": _checksum(snapshot.renderer, snapshot.rows, custom),
        "format": FORMAT,
        "renderer": snapshot.renderer,
    }
    if custom:
        content["custom"] = custom
    text = json.dumps(content, indent=1, sort_keys=True, ensure_ascii=False, allow_nan=False)
    with replacing(Path(path)) as partial:
        partial.write_text(text + "\n", encoding="utf-8")
    return snapshot


def check(owner: str, rows: Mapping[str, Row]) -> None:
    """Raise `UsageError` if there is no cell with numbers, so that every comparison would pass."""
    if not any(_has_numbers(fields) for fields in rows.values()):
        raise UsageError(f"{owner} has no cell with numbers; compare with another run")


def _check_each(owner: str, rows: Mapping[str, Row]) -> None:
    """Raise `UsageError` if a cell has no numbers, so that no change of it could be a regression.

    Skipped cells may have none: the machine lacked a capability, which another may have.
    """
    check(owner, rows)
    for name, fields in rows.items():
        if fields["status"] != "skipped" and not _has_numbers(fields):
            raise UsageError(
                f"{owner}: the cell {name} is {fields['status']} and has no numbers;"
                " repair it, or leave it out"
            )


def _has_numbers(fields: Row) -> bool:
    return fields["status"] in FINISHED and fields.get(f"{EXACT}.{metrics.RMSE}") is not None


def _checksum(renderer: str, rows: Mapping[str, Row], custom: Mapping[str, Any]) -> str:
    # Without metrics of users, there is nothing to protect.
    content = [renderer, rows, custom] if custom else [renderer, rows]
    text = json.dumps(content, sort_keys=True, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _read_folder(folder: Path) -> Snapshot:
    loaded = Results.load(folder)
    rows = {label(record): row(record) for record in loaded.records}
    timed = [(item, item.time) for item in loaded.records if item.time is not None]
    times = {label(item): time.method_ms for item, time in timed if not time.block.disturbed}
    return Snapshot(loaded.renderer, rows, times, loaded.custom)


def _read_file(path: Path) -> Snapshot:
    try:
        content = json_text.loads(path.read_bytes())
    except OSError as error:
        raise UsageError(f"{path} cannot be read ({error.strerror})") from error
    except ValueError as error:
        raise UsageError(f"{path} is no baseline ({error}); save a new one") from error
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise UsageError(f"{path} is no baseline of format {FORMAT}; save a new one")
    renderer, rows = content.get("renderer"), content.get("cells")
    if not isinstance(renderer, str) or not isinstance(rows, dict):
        raise UsageError(f"{path} lacks its renderer or its cells; save a new baseline")
    for name, fields in rows.items():
        if not _is_row(fields):
            raise UsageError(f"{path}: the cell {name} is damaged; save a new baseline")
    custom = content.get("custom", {})
    if content.get("checksum") != _checksum(renderer, rows, custom):
        raise UsageError(f"{path} is damaged or was edited by hand; save a new baseline")
    _check_each(f"{path}", rows)
    return Snapshot(renderer, rows, custom=msgspec.convert(custom, dict[str, CustomMetric]))


def _is_row(fields: Any) -> bool:
    if not isinstance(fields, dict) or "status" not in fields:
        return False
    truths = tuple(f"{truth}." for truth in (*TRUTHS, WHOLE))
    for name, value in fields.items():
        allowed = int | float | None if name.startswith(truths) else int | float | str | None
        if isinstance(value, bool) or not isinstance(value, allowed):
            return False
    return True


def _passes(passes: Sequence[PassRuns]) -> str:
    """Return the names in order of first appearance, with the number of runs unless it is one."""
    runs: Counter[str] = Counter()
    for item in passes:
        runs[item.name] += item.runs
    return ", ".join(name if count == 1 else f"{name} × {count}" for name, count in runs.items())


def _rounded(value: float | None) -> float | None:
    """Return a metric with enough digits to show a change; rounding is far below any tolerance."""
    return None if value is None else float(f"{round(value, _DECIMALS):.{_DIGITS}g}")
