"""What a run came to, in one small file that a version control shows the changes of.

A baseline holds one flat row a cell: the quality metrics, rounded; the counts that a renderer
repeats exactly; status, effects and passes. It holds neither times nor anything of the machine but
the name of its renderer.

The project's own baseline, which its tests hold every change against, is written anew with

    .venv/bin/python -m tests.guard

after a change that is meant to move a metric or a count, or that adds a method. Read the
difference in tests/baseline.json before committing it: it says what the change did.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from oitbench.errors import UsageError
from oitbench.image import metrics
from oitbench.results import records as results
from oitbench.results.records import EXACT, PATH_TRACED, Results
from oitbench.results.store import CellKey

Value = int | float | str | None
Row = Mapping[str, Value]
"""A cell as flat fields: `exact.rmse_lin`, `traffic.bytes`, `effects.missing`, …"""

FORMAT = 1
METRICS = (
    *metrics.NAMES,
    metrics.TRANSMITTANCE,
    metrics.ORDER_SPREAD_MAX,
    metrics.ORDER_SPREAD_MEAN,
)
TRUTHS = (EXACT, PATH_TRACED)
_DIGITS = 5
_DECIMALS = 6


@dataclass(frozen=True)
class Snapshot:
    """What is compared: the cells of a results folder, or of a baseline file.

    Parameters
    ----------
    renderer : str
        As OpenGL names it.
    rows : mapping of str to Row
        By the cell's label: scene, method, size and variant.
    times : mapping of str to (float, float, float)
        Median frame time and its 95 % interval in milliseconds; a baseline file has none.
    """

    renderer: str
    rows: Mapping[str, Row]
    times: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)


def label(record: Mapping[str, Any]) -> str:
    """Return a cell's name: scene, method, size and variant, separated by blanks."""
    key = CellKey.of(record)
    variant = " ".join(f"{name}={value}" for name, value in sorted(record["variant"].items()))
    return f"{key.scene} {key.method} {key.size[0]}x{key.size[1]} {variant}".strip()


def row(record: Mapping[str, Any]) -> Row:
    """Return what is compared of a record; what it does not hold is left out."""
    fields: dict[str, Value] = {"status": record["status"]}
    for count in ("fragments", "max_depth_complexity"):
        if count in record:
            fields[count] = record[count]
    for account in ("memory", "traffic"):
        if account in record:
            fields[f"{account}.bytes"] = record[account]["bytes"]
    for kind, pixels in (record.get("nonfinite") or {}).items():
        fields[f"nonfinite.{kind}"] = pixels
    for kind, names in (record.get("effects") or {}).items():
        fields[f"effects.{kind}"] = ", ".join(names)
    if "passes" in record:
        fields["passes"] = _passes(record["passes"])
    for truth in TRUTHS:
        values = (record.get("metrics") or {}).get(truth) or {}
        for name in METRICS:
            if name in values:
                fields[f"{truth}.{name}"] = _rounded(results.metric(record, truth, name))
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
    """Write the baseline of a results folder to the file `path`, and return what it holds.

    Raises
    ------
    UsageError
        If the folder holds no results, or the file cannot be written.
    """
    snapshot = _read_folder(Path(folder))
    content = {"cells": snapshot.rows, "format": FORMAT, "renderer": snapshot.renderer}
    text = json.dumps(content, indent=1, sort_keys=True, ensure_ascii=False, allow_nan=False)
    try:
        Path(path).write_text(text + "\n", encoding="utf-8")
    except OSError as error:
        raise UsageError(f"{path} cannot be written ({error.strerror})") from error
    return snapshot


def _read_folder(folder: Path) -> Snapshot:
    loaded = Results.load(folder)
    rows, times = {}, {}
    for record in loaded.records:
        try:
            name, rows[name] = label(record), row(record)
            time = results.frame_time(record)
        except (KeyError, TypeError, AttributeError, ValueError) as error:
            told = f"{record['scene']} {record['method']}"
            raise UsageError(f"{folder}: the cell {told} is damaged; run it again") from error
        if time is not None:
            times[name] = time
    return Snapshot(loaded.renderer, rows, times)


def _read_file(path: Path) -> Snapshot:
    try:
        content = json.loads(path.read_bytes(), parse_constant=_refuse)
    except OSError as error:
        raise UsageError(f"{path} cannot be read ({error.strerror})") from error
    except ValueError as error:
        raise UsageError(f"{path} is no baseline ({error}); save one anew") from error
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise UsageError(f"{path} is no baseline of format {FORMAT}; save one anew")
    renderer, rows = content.get("renderer"), content.get("cells")
    if not isinstance(renderer, str) or not isinstance(rows, dict):
        raise UsageError(f"{path} lacks its renderer or its cells; save a baseline anew")
    for name, fields in rows.items():
        if not _is_row(fields):
            raise UsageError(f"{path}: the cell {name} is damaged; save a baseline anew")
    return Snapshot(renderer, rows)


def _refuse(constant: str) -> None:
    raise ValueError(f"{constant} is no number")


def _is_row(fields: Any) -> bool:
    if not isinstance(fields, dict) or "status" not in fields:
        return False
    truths = tuple(f"{truth}." for truth in TRUTHS)
    for name, value in fields.items():
        allowed = int | float | None if name.startswith(truths) else int | float | str | None
        if isinstance(value, bool) or not isinstance(value, allowed):
            return False
    return True


def _passes(passes: list[Mapping[str, Any]]) -> str:
    """Return names in order of first appearance, with the number of runs where it is not one."""
    runs: Counter[str] = Counter()
    for item in passes:
        runs[item["name"]] += item["runs"]
    return ", ".join(name if count == 1 else f"{name} × {count}" for name, count in runs.items())


def _rounded(value: float | None) -> float | None:
    """Return a metric with as many digits as tell a change; far fewer than the table's bounds."""
    return None if value is None else float(f"{round(value, _DECIMALS):.{_DIGITS}g}")
