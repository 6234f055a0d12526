"""Identities that must hold, and hard cases with known correct answers.

Needs the results of `oitbench stability`, in the results folder or its folder `stability`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from oitbench.report import Artifact, Column, Note, ReportContext, decimal, write_table
from oitbench.report.artifacts import Row
from oitbench.stability import files, summary
from oitbench.stability.result import BREAKS, DOES_NOT_APPLY, HOLDS, CheckResult

title = "Stability"
order = 60

_WORDS = {HOLDS: "✓", DOES_NOT_APPLY: "–"}
_COLUMNS = (
    Column("method", "Method", kind="text"),
    Column("check", "Check", kind="text"),
    Column("sentence", "Requirement", kind="text"),
    Column("status", "Result", kind="text"),
    Column("promised", "Promised", kind="text"),
    Column("error", "Error", help="largest in any pixel, or of the mean"),
    Column("allowed", "Allowed", help="largest error with which the check holds"),
    Column("in_mean", "In the mean", kind="text", help="the mean of random pixels is checked"),
    Column("unstable_pixels", "Unstable", "px", help="NaN, infinite or negative pixels"),
    Column("reason", "Reason", kind="text"),
)


def build(context: ReportContext) -> list[Artifact]:
    """Write a table of identities, one of hard cases, and one of every result."""
    folder = context.results.folder
    path = files.find(folder)
    if path is None:
        return [Note(f"Not run yet; 'oitbench stability --out {folder / 'stability'}' adds it.")]
    results = files.read(path)
    by_method = summary.by_method(results)
    return [
        _matrix(
            context,
            "stability-identities.csv",
            "Identities",
            {method: [r for r in own if r.identity] for method, own in by_method.items()},
            "✓: holds within the rounding of the method's formats. A number: the error of a check "
            "that does not hold. !: the method promises the identity. –: does not apply.",
        ),
        _matrix(
            context,
            "stability-cases.csv",
            "Hard cases",
            {method: [r for r in own if not r.identity] for method, own in by_method.items()},
            "✓: within one step of an 8-bit display of the correct answer. A number: the error of "
            "a check that does not hold. Methods promise no hard cases.",
        ),
        _list(context, results),
    ]


def _matrix(
    context: ReportContext,
    file: str,
    name: str,
    results: Mapping[str, Sequence[CheckResult]],
    caption: str,
) -> Artifact:
    """Return a table with one row per method and one column per check."""
    rows: list[Row] = []
    columns: tuple[Column, ...] = ()
    for method, own in results.items():
        columns = tuple(Column(r.check, r.check, kind="text", help=r.sentence) for r in own)
        rows.append((method, *map(_mark, own), "; ".join(summary.faults(own))))
    heading = (
        Column("method", "Method", kind="text"),
        *columns,
        Column("faults", "Faults", kind="text"),
    )
    return write_table(context.out / file, heading, rows, title=name, caption=caption)


def _mark(result: CheckResult) -> str:
    if result.status != BREAKS:
        return _WORDS[result.status]
    error = "∞" if result.error is None else decimal(result.error, 2)
    return f"{error}!" if result.failed else error


def _list(context: ReportContext, results: Sequence[CheckResult]) -> Artifact:
    rows = [
        (
            result.method,
            result.check,
            result.sentence,
            result.status,
            "yes" if result.promised else "",
            result.error,
            result.allowed,
            "yes" if result.in_mean else "",
            result.nonfinite.total,
            result.reason,
        )
        for result in results
    ]
    return write_table(
        context.out / "stability.csv",
        _COLUMNS,
        rows,
        title="All results",
        caption="Every check of every method.",
        collapsed=True,
    )
