"""Comparison of a run with a baseline or with another run, to find regressions.

One table states how far each quality metric may move. Counts follow from the declaration and from
the rasterized samples, so the same renderer must repeat them exactly; another may rasterize the
edge of a triangle differently. Times are reported where both sides have them from the same
renderer, and never fail a comparison.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from oitbench.image import metrics
from oitbench.results import baseline as baselines
from oitbench.results.baseline import Entry, Row, Snapshot
from oitbench.results.schema import FINISHED, WHOLE
from oitbench.truths import TRUTHS

MISSING, CHANGED, LOST, WORSE = "missing", "changed", "lost", "worse"
ADDED, BETTER, SLOWER, FASTER = "added", "better", "slower", "faster"
REGRESSIONS = frozenset({MISSING, CHANGED, LOST, WORSE})
"""Verdicts that fail a comparison; the others are only reported."""


@dataclass(frozen=True)
class Tolerance:
    """How far a value may move from the baseline: `absolute + relative * |baseline|`.

    Parameters
    ----------
    absolute : float
        In the unit of the metric.
    relative : float
    higher_is_better : bool
    ceiling : float
        Values above it make no visible difference, and are replaced by it.
    """

    absolute: float
    relative: float = 0.0
    higher_is_better: bool = False
    ceiling: float = math.inf

    def judge(self, before: float, now: float) -> str | None:
        """Return "worse" or "better", or None if the values agree."""
        before, now = min(before, self.ceiling), min(now, self.ceiling)
        change = before - now if self.higher_is_better else now - before
        if abs(change) <= self.allowed(before):
            return None
        return WORSE if change > 0 else BETTER

    def allowed(self, before: float) -> float:
        """Return the largest change that counts as none."""
        return self.absolute + self.relative * abs(before)


TOLERANCES: Mapping[str, Tolerance] = {
    metrics.FLIP_LDR: Tolerance(2e-3, 1e-2),
    metrics.FLIP_HDR: Tolerance(2e-3, 1e-2),
    metrics.SSIM: Tolerance(1e-3, higher_is_better=True),
    # At 50 dB the error is below a step of 8 bits, and different rounding moves it by decibels.
    metrics.PSNR: Tolerance(0.2, higher_is_better=True, ceiling=50.0),
    metrics.RMSE: Tolerance(5e-4, 1e-2),
    metrics.RELMSE: Tolerance(1e-4, 2e-2),
    metrics.TRANSMITTANCE: Tolerance(5e-4, 1e-2),
    metrics.ORDER_SPREAD_MAX: Tolerance(1e-2, 5e-2),
    metrics.ORDER_SPREAD_MEAN: Tolerance(5e-4, 1e-2),
}
"""Allowed change of each quality metric, on any renderer. Half a step of a half float near 1 is
2.4e-4; the absolute parts allow the rounding of a few such steps, which is invisible."""

SAME_COUNTS = Tolerance(0.0)
OTHER_COUNTS = Tolerance(1.0, 2e-3)
"""For counts of one renderer, and of two that may rasterize pixels on an edge differently."""


@dataclass(frozen=True)
class Difference:
    """One difference between a run and a baseline.

    Parameters
    ----------
    cell : str
        Scene, method, size and settings.
    field : str
        The field that differs; empty for a whole cell.
    before, now : int, float, str or None
        The values of the baseline and of the run.
    verdict : str
        Regressions are "missing" (only in the baseline), "changed" (a value that must not change),
        "lost" (a value that no longer exists) and "worse"; the others are "added" (only in the
        run), "better", "slower" and "faster".
    allowed : float, optional
        The largest change that counts as none; None for texts, times and whole cells.
    """

    cell: str
    field: str
    before: Entry
    now: Entry
    verdict: str
    allowed: float | None = None

    @property
    def regression(self) -> bool:
        """Whether this fails the comparison."""
        return self.verdict in REGRESSIONS


@dataclass(frozen=True)
class Comparison:
    """All differences between a run and a baseline.

    Parameters
    ----------
    before, now : str
        The renderers of the baseline and of the run.
    cells : int
        Cells that both have.
    differences : tuple of Difference
        Regressions first.
    """

    before: str
    now: str
    cells: int
    differences: tuple[Difference, ...]

    @property
    def regressions(self) -> tuple[Difference, ...]:
        """Differences that fail the comparison."""
        return tuple(item for item in self.differences if item.regression)

    @property
    def improvements(self) -> tuple[Difference, ...]:
        """Metrics that became better by more than their tolerance."""
        return tuple(item for item in self.differences if item.verdict == BETTER)

    @property
    def additions(self) -> tuple[Difference, ...]:
        """Cells that only the run has."""
        return tuple(item for item in self.differences if item.verdict == ADDED)

    @property
    def passed(self) -> bool:
        """Whether nothing regressed."""
        return not self.regressions

    def facts(self) -> dict[str, Any]:
        """Return the comparison in types that JSON can hold."""
        return {
            "passed": self.passed,
            "cells": self.cells,
            "renderer": {"before": self.before, "now": self.now},
            "differences": [
                {**asdict(item), "regression": item.regression} for item in self.differences
            ],
        }

    def __str__(self) -> str:
        text = f"{self.cells} cells compared, {_count(self.regressions, 'regression')}"
        text += f", {_count(self.improvements, 'improvement')}"
        if self.additions:
            text += f", {_count(self.additions, 'new cell')}"
        if self.before != self.now:
            text += f"; the baseline is of '{self.before}', this run of '{self.now}'"
        return text


def compare(results: Path | str, baseline: Path | str) -> Comparison:
    """Compare a results folder with a baseline.

    Parameters
    ----------
    results : path
        The folder of a run.
    baseline : path
        A baseline file, or the folder of another run.

    Raises
    ------
    UsageError
        One of the two cannot be read, or the baseline has no numbers.
    """
    now, before = baselines.read(results), baselines.read(baseline)
    baselines.check(str(baseline), before.rows)
    return compare_snapshots(now, before)


def compare_snapshots(now: Snapshot, before: Snapshot) -> Comparison:
    """Compare the cells of a run with those of a baseline."""
    found = [Difference(cell, "", None, None, MISSING) for cell in before.rows.keys() - now.rows]
    found += [Difference(cell, "", None, None, ADDED) for cell in now.rows.keys() - before.rows]
    counts = SAME_COUNTS if now.renderer == before.renderer else OTHER_COUNTS
    limits = _tolerances(now, before)
    common = before.rows.keys() & now.rows.keys()
    for cell in common:
        for name, verdict in _judge_row(before.rows[cell], now.rows[cell], counts, limits):
            value, limit = before.rows[cell].get(name), _limit(name, counts, limits)
            allowed = None
            if limit is not None and isinstance(value, int | float):
                allowed = limit.allowed(value)
            after = now.rows[cell].get(name)
            found.append(Difference(cell, name, value, after, verdict, allowed))
    if now.renderer == before.renderer:
        found += _times(now, before)
    found.sort(key=lambda item: (not item.regression, item.cell, item.field))
    return Comparison(before.renderer, now.renderer, len(common), tuple(found))


def _tolerances(now: Snapshot, before: Snapshot) -> Mapping[str, Tolerance]:
    """Return the tolerances of the suite's metrics, and of users' that are the same on both sides.

    Values of a metric whose file has changed cannot be compared.
    """
    custom = {
        name: Tolerance(facts.tolerance, facts.relative_tolerance, facts.higher_is_better)
        for name, facts in before.custom.items()
        if now.custom.get(name) == facts
    }
    return {**TOLERANCES, **custom}


def _judge_row(
    before: Row, now: Row, counts: Tolerance, limits: Mapping[str, Tolerance]
) -> Iterator[tuple[str, str]]:
    """Yield the fields of a cell that differ, each with a verdict.

    Fields that the baseline lacks are not judged.
    """
    for name in before:
        if name in now:
            verdict = _judge(name, before, now, counts, limits)
        else:
            # A cell without an image has no numbers; its status already says so.
            verdict = LOST if now["status"] in FINISHED else None
        if verdict is not None:
            yield name, verdict


def _limit(name: str, counts: Tolerance, limits: Mapping[str, Tolerance]) -> Tolerance | None:
    """Return the tolerance of a field; None for metrics that cannot be compared."""
    truth, _, metric = name.partition(".")
    return limits.get(metric) if truth in TRUTHS or truth == WHOLE else counts


def _judge(
    name: str, before: Row, now: Row, counts: Tolerance, limits: Mapping[str, Tolerance]
) -> str | None:
    truth, _, metric = name.partition(".")
    if truth in TRUTHS or truth == WHOLE:
        if metric not in limits:
            return CHANGED
        scores = _score(truth, metric, before), _score(truth, metric, now)
        return _judge_metric(limits[metric], *scores)
    value, other = before[name], now[name]
    if isinstance(value, int | float) and isinstance(other, int | float):
        return counts.judge(value, other) and CHANGED
    return None if value == other else CHANGED


def _judge_metric(limit: Tolerance, before: float | None, now: float | None) -> str | None:
    if before is None or now is None:
        if before is None and now is None:
            return None
        return LOST if now is None else BETTER
    return limit.judge(before, now)


def _score(truth: str, name: str, row: Row) -> float | None:
    """Return a metric; the PSNR of two equal images, which has no finite value, is infinite."""
    value = row[f"{truth}.{name}"]
    equal = name == metrics.PSNR and row.get(f"{truth}.{metrics.RMSE}") is not None
    if value is None:
        return math.inf if equal else None
    return float(value)


def _times(now: Snapshot, before: Snapshot) -> Iterator[Difference]:
    """Yield the cells whose intervals of method time do not overlap."""
    for cell in now.times.keys() & before.times.keys():
        old, new = before.times[cell], now.times[cell]
        if old.ends is None or new.ends is None:
            continue
        if new.ends[0] > old.ends[1] or new.ends[1] < old.ends[0]:
            verdict = SLOWER if new.median > old.median else FASTER
            yield Difference(cell, "method_ms", round(old.median, 3), round(new.median, 3), verdict)


def _count(differences: tuple[Difference, ...], word: str) -> str:
    return f"{len(differences)} {word}{'' if len(differences) == 1 else 's'}"
