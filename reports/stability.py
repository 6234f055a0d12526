"""Identities that must hold, and hard cases with known correct answers.

The findings are those that 'oitbench stability' wrote to the folder of the results or to its folder
'stability'.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from oitbench.report import Artifact, Column, Note, ReportContext, decimal, write_table
from oitbench.report.artifacts import Row
from oitbench.stability import files
from oitbench.stability.finding import BREAKS, DOES_NOT_APPLY, HOLDS, Finding

title = "Stability"
order = 60

_WORDS = {HOLDS: "✓", DOES_NOT_APPLY: "–"}
_COLUMNS = (
    Column("method", "Method", kind="text"),
    Column("check", "Check", kind="text"),
    Column("sentence", "Requirement", kind="text"),
    Column("result", "Result", kind="text"),
    Column("promised", "Promised", kind="text"),
    Column("error", "Error", help="largest in any pixel, or of the mean"),
    Column("allowed", "Allowed", help="largest error with which the check holds"),
    Column("in_mean", "In the mean", kind="text", help="the mean of random pixels is checked"),
    Column("unstable_pixels", "Unstable", "px", help="NaN, infinite or negative pixels"),
    Column("reason", "Reason", kind="text"),
)


def build(context: ReportContext) -> list[Artifact]:
    """Write a table of identities, one of hard cases, and one of every finding."""
    folder = context.results.folder
    places = (folder / "stability" / files.JSON, folder / files.JSON)
    path = next((place for place in places if place.is_file()), None)
    if path is None:
        return [Note(f"Not run yet; 'oitbench stability --out {places[0].parent}' adds it.")]
    findings = files.read(path)
    by_method = files.by_method(findings)
    return [
        _matrix(
            context,
            "stability-identities.csv",
            "Identities",
            {method: [f for f in own if f.identity] for method, own in by_method.items()},
            "✓: holds within the rounding of the method's formats. A number: the error of a check "
            "that does not hold. !: the method promises the identity. –: does not apply.",
        ),
        _matrix(
            context,
            "stability-cases.csv",
            "Hard cases",
            {method: [f for f in own if not f.identity] for method, own in by_method.items()},
            "✓: within one step of an 8-bit display of the correct answer. A number: the error of "
            "a check that does not hold. Methods promise no hard cases.",
        ),
        _list(context, findings),
    ]


def _matrix(
    context: ReportContext,
    file: str,
    name: str,
    findings: Mapping[str, Sequence[Finding]],
    caption: str,
) -> Artifact:
    """Return a table with one row per method and one column per check."""
    rows: list[Row] = []
    columns: tuple[Column, ...] = ()
    for method, own in findings.items():
        columns = tuple(Column(f.check, f.check, kind="text", help=f.sentence) for f in own)
        rows.append((method, *map(_mark, own), "; ".join(files.told_faults(own))))
    heading = (
        Column("method", "Method", kind="text"),
        *columns,
        Column("faults", "Faults", kind="text"),
    )
    return write_table(context.out / file, heading, rows, title=name, caption=caption)


def _mark(finding: Finding) -> str:
    if finding.result != BREAKS:
        return _WORDS[finding.result]
    error = "∞" if finding.error is None else decimal(finding.error, 2)
    return f"{error}!" if finding.failed else error


def _list(context: ReportContext, findings: Sequence[Finding]) -> Artifact:
    rows = [
        (
            finding.method,
            finding.check,
            finding.sentence,
            finding.result,
            "yes" if finding.promised else "",
            finding.error,
            finding.allowed,
            "yes" if finding.in_mean else "",
            finding.nan + finding.inf + finding.negative,
            finding.reason,
        )
        for finding in findings
    ]
    return write_table(
        context.out / "stability.csv",
        _COLUMNS,
        rows,
        title="All findings",
        caption="Every check of every method.",
        collapsed=True,
    )
