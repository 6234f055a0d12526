"""Regressions: what a run came to, held against a baseline or another run.

Quality metrics may differ by what one table allows. Counts follow from a declaration and from what
was drawn, so the same renderer must repeat them exactly; another may rasterize the edge of a
triangle otherwise. Times are told where both sides have them from the same renderer, and never
decide.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from oitbench.image import metrics
from oitbench.results import baseline as baselines
from oitbench.results.baseline import Row, Snapshot, Value
from oitbench.results.records import FINISHED

MISSING, ORPHANED, CHANGED, LOST, WORSE = "missing", "orphaned", "changed", "lost", "worse"
BETTER, SLOWER, FASTER = "better", "slower", "faster"
REGRESSIONS = frozenset({MISSING, ORPHANED, CHANGED, LOST, WORSE})
"""Verdicts that fail a comparison; the others are only told."""


@dataclass(frozen=True)
class Tolerance:
    """How far a value may move from the baseline: `absolute + relative * |baseline|`.

    Parameters
    ----------
    absolute : float
        In the metric's own unit.
    relative : float
    higher_is_better : bool
    ceiling : float
        Values above it show no difference, and count as it.
    """

    absolute: float
    relative: float = 0.0
    higher_is_better: bool = False
    ceiling: float = math.inf

    def judge(self, before: float, now: float) -> str | None:
        """Return "worse", "better", or None where the values agree."""
        before, now = min(before, self.ceiling), min(now, self.ceiling)
        change = before - now if self.higher_is_better else now - before
        if abs(change) <= self.absolute + self.relative * abs(before):
            return None
        return WORSE if change > 0 else BETTER


TOLERANCES: Mapping[str, Tolerance] = {
    metrics.FLIP_LDR: Tolerance(2e-3, 1e-2),
    metrics.FLIP_HDR: Tolerance(2e-3, 1e-2),
    metrics.SSIM: Tolerance(1e-3, higher_is_better=True),
    # At 50 dB the error is below a step of 8 bits, and another rounding moves it by decibels.
    metrics.PSNR: Tolerance(0.2, higher_is_better=True, ceiling=50.0),
    metrics.RMSE: Tolerance(5e-4, 1e-2),
    metrics.RELMSE: Tolerance(1e-4, 2e-2),
    metrics.TRANSMITTANCE: Tolerance(5e-4, 1e-2),
    metrics.ORDER_SPREAD_MAX: Tolerance(1e-2, 5e-2),
    metrics.ORDER_SPREAD_MEAN: Tolerance(5e-4, 1e-2),
}
"""What each quality metric may move by, on any renderer. Half a step of a half float near 1 is
2.4e-4; the absolute parts let the rounding of a few such steps pass, and nothing that shows."""

SAME_COUNTS = Tolerance(0.0)
OTHER_COUNTS = Tolerance(1.0, 2e-3)
"""Counts of one renderer, and of two that may disagree about pixels on an edge."""


@dataclass(frozen=True)
class Finding:
    """One difference.

    Parameters
    ----------
    cell : str
        Scene, method, size and variant.
    field : str
        What differs; empty if the whole cell does.
    before, now : int, float, str or None
        The baseline's value and the run's.
    verdict : str
        "missing" (in the baseline alone), "orphaned" (in the run alone), "changed" (what must stay
        as it is), "lost" (a value there is no more), "worse"; or, no regressions, "better",
        "slower", "faster".
    """

    cell: str
    field: str
    before: Value
    now: Value
    verdict: str

    @property
    def regression(self) -> bool:
        """Whether this fails the comparison."""
        return self.verdict in REGRESSIONS


@dataclass(frozen=True)
class Comparison:
    """How a run compares to a baseline.

    Parameters
    ----------
    before, now : str
        The renderers of the baseline and of the run.
    cells : int
        Cells that both have.
    findings : tuple of Finding
        Regressions first.
    """

    before: str
    now: str
    cells: int
    findings: tuple[Finding, ...]

    @property
    def regressions(self) -> tuple[Finding, ...]:
        """Findings that fail the comparison."""
        return tuple(finding for finding in self.findings if finding.regression)

    @property
    def improvements(self) -> tuple[Finding, ...]:
        """Metrics that became better by more than their tolerance."""
        return tuple(finding for finding in self.findings if finding.verdict == BETTER)

    @property
    def passed(self) -> bool:
        """Whether nothing regressed."""
        return not self.regressions

    def facts(self) -> dict[str, Any]:
        """Return the comparison in JSON's own types."""
        return {
            "passed": self.passed,
            "cells": self.cells,
            "renderer": {"before": self.before, "now": self.now},
            "findings": [
                {**asdict(finding), "regression": finding.regression} for finding in self.findings
            ],
        }

    def __str__(self) -> str:
        told = f"{self.cells} cells compared, {_count(self.regressions, 'regression')}"
        told += f", {_count(self.improvements, 'improvement')}"
        if self.before != self.now:
            told += f"; the baseline is of '{self.before}', this run of '{self.now}'"
        return told


def compare(results: Path | str, baseline: Path | str) -> Comparison:
    """Hold a results folder against a baseline.

    Parameters
    ----------
    results : path
        The folder of a run.
    baseline : path
        A baseline file, or the folder of another run.

    Raises
    ------
    UsageError
        If one of the two cannot be read.
    """
    return compare_snapshots(baselines.read(results), baselines.read(baseline))


def compare_snapshots(now: Snapshot, before: Snapshot) -> Comparison:
    """Hold what was read of a run against what was read of a baseline."""
    findings = [Finding(cell, "", None, None, MISSING) for cell in before.rows.keys() - now.rows]
    findings += [Finding(cell, "", None, None, ORPHANED) for cell in now.rows.keys() - before.rows]
    counts = SAME_COUNTS if now.renderer == before.renderer else OTHER_COUNTS
    common = before.rows.keys() & now.rows.keys()
    for cell in common:
        for name, verdict in _judge_row(before.rows[cell], now.rows[cell], counts):
            values = (before.rows[cell].get(name), now.rows[cell].get(name))
            findings.append(Finding(cell, name, *values, verdict))
    if now.renderer == before.renderer:
        findings += _times(now, before)
    findings.sort(key=lambda finding: (not finding.regression, finding.cell, finding.field))
    return Comparison(before.renderer, now.renderer, len(common), tuple(findings))


def _judge_row(before: Row, now: Row, counts: Tolerance) -> Iterator[tuple[str, str]]:
    """Yield the fields of a cell that differ, with a verdict each.

    What the baseline does not hold is not judged: nothing says what it should be.
    """
    for name in before:
        if name in now:
            verdict = _judge(name, before, now, counts)
        else:
            # A cell without an image has no numbers; its status says so once.
            verdict = LOST if now["status"] in FINISHED else None
        if verdict is not None:
            yield name, verdict


def _judge(name: str, before: Row, now: Row, counts: Tolerance) -> str | None:
    truth, _, metric = name.partition(".")
    if truth in baselines.TRUTHS:
        return _judge_metric(metric, _score(truth, metric, before), _score(truth, metric, now))
    value, other = before[name], now[name]
    if isinstance(value, int | float) and isinstance(other, int | float):
        return counts.judge(value, other) and CHANGED
    return None if value == other else CHANGED


def _judge_metric(name: str, before: float | None, now: float | None) -> str | None:
    if before is None or now is None:
        if before is None and now is None:
            return None
        return LOST if now is None else BETTER
    return TOLERANCES[name].judge(before, now)


def _score(truth: str, name: str, row: Row) -> float | None:
    """Return a metric; the ratio of two equal images, which has no finite value, is infinite."""
    value = row[f"{truth}.{name}"]
    equal = name == metrics.PSNR and row.get(f"{truth}.{metrics.RMSE}") is not None
    if value is None:
        return math.inf if equal else None
    return float(value)


def _times(now: Snapshot, before: Snapshot) -> Iterator[Finding]:
    """Yield the cells whose 95 % intervals of frame time do not overlap."""
    for cell in now.times.keys() & before.times.keys():
        (old, old_low, old_high), (new, new_low, new_high) = before.times[cell], now.times[cell]
        if new_low > old_high or new_high < old_low:
            verdict = SLOWER if new > old else FASTER
            yield Finding(cell, "frame_ms", round(old, 3), round(new, 3), verdict)


def _count(findings: tuple[Finding, ...], word: str) -> str:
    return f"{len(findings)} {word}{'' if len(findings) == 1 else 's'}"
