"""What methods promise and survive: identities that must hold, and hard cases with right answers.

Needs the results of `oitbench stability`, in the results folder or its folder `stability`.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from oitbench.report import Artifact, Column, Note, decimal, write_table
from oitbench.report.artifacts import Value
from oitbench.results.records import Results
from oitbench.stability import files, summary
from oitbench.stability.result import BREAKS, DOES_NOT_APPLY, HOLDS, CheckResult

title = "Stability"
order = 60

_WORDS = {HOLDS: "✓", DOES_NOT_APPLY: "–"}


def build(results: Results, out: Path) -> list[Artifact]:
    """Write a table of identities, one of hard cases, and one of every result."""
    places = (results.folder / "stability", results.folder)
    found = [place / files.JSON for place in places if (place / files.JSON).is_file()]
    if not found:
        told = results.folder / "stability"
        return [Note(f"Not run yet: oitbench stability --out {told} adds it.")]
    checked = files.read(found[0])
    by_method = summary.by_method(checked)
    return [
        _matrix(
            by_method,
            out / "stability-identities.csv",
            "Identities",
            "✓ holds within the rounding of the method's formats, a number is the error where it "
            "breaks, ! marks a broken promise, – does not apply.",
            identity=True,
        ),
        _matrix(
            by_method,
            out / "stability-cases.csv",
            "Hard cases",
            "✓ is within one step of an 8-bit display of the right answer; a number is the error. "
            "No method promises these.",
            identity=False,
        ),
        _list(checked, out),
    ]


def _matrix(
    by_method: dict[str, list[CheckResult]], path: Path, name: str, caption: str, *, identity: bool
) -> Artifact:
    rows: list[tuple[Value, ...]] = []
    columns: tuple[Column, ...] = ()
    for method, own in by_method.items():
        chosen = [result for result in own if result.identity == identity]
        columns = tuple(Column(f.check, f.check, kind="text", help=f.sentence) for f in chosen)
        faults = "; ".join(summary.faults(chosen))
        rows.append((method, *map(_mark, chosen), faults))
    heading = (Column("method", "Method", kind="text"), *columns, Column("faults", "Faults"))
    return write_table(path, heading, rows, title=name, caption=caption)


def _mark(result: CheckResult) -> str:
    if result.status != BREAKS:
        return _WORDS[result.status]
    error = "∞" if result.error is None else decimal(result.error, 2)
    return f"{error}!" if result.failed else error


def _list(checked: Sequence[CheckResult], out: Path) -> Artifact:
    columns = (
        Column("method", "Method", kind="text"),
        Column("check", "Check", kind="text"),
        Column("sentence", "What must hold", kind="text"),
        Column("status", "Result", kind="text"),
        Column("promised", "Promised", kind="text"),
        Column("error", "Error"),
        Column("allowed", "allowed"),
        Column("in_mean", "In the mean", kind="text"),
        Column("unstable_pixels", "NaN, inf, negative"),
        Column("reason", "Reason", kind="text"),
    )
    rows = [
        (
            f.method,
            f.check,
            f.sentence,
            f.status,
            "yes" if f.promised else "",
            f.error,
            f.allowed,
            "yes" if f.in_mean else "",
            f.nonfinite.total,
            f.reason,
        )
        for f in checked
    ]
    caption = "Every check of every variant; errors are the largest in any pixel, or of the mean."
    return write_table(
        out / "stability.csv", columns, rows, title="All results", caption=caption, collapsed=True
    )
