"""The suite's findings as files, and as a table for a terminal."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from oitbench.errors import UsageError
from oitbench.stability.finding import BREAKS, DOES_NOT_APPLY, HOLDS, Finding

if TYPE_CHECKING:
    from rich.table import Table
    from rich.text import Text

JSON, CSV = "stability.json", "stability.csv"


def write(folder: Path, findings: Sequence[Finding], facts: Mapping[str, Any]) -> None:
    """Write `stability.json` and `stability.csv` into `folder`.

    Raises
    ------
    UsageError
        If the folder cannot be written to.
    """
    rows = [finding.facts() for finding in findings]
    columns = [*(field.name for field in fields(Finding)), "failed"]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        text = json.dumps(
            {**facts, "findings": rows}, indent=1, allow_nan=False, ensure_ascii=False
        )
        (folder / JSON).write_text(text + "\n", encoding="utf-8")
        with (folder / CSV).open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, columns)
            writer.writeheader()
            writer.writerows(rows)
    except OSError as error:
        raise UsageError(f"{folder} cannot be written to ({error.strerror}); give --out") from error


def read(path: Path) -> list[Finding]:
    """Read the findings of a `stability.json`.

    Raises
    ------
    UsageError
        If the file is none.
    """
    try:
        rows = json.loads(path.read_text(encoding="utf-8"))["findings"]
        return [Finding(**{k: v for k, v in row.items() if k != "failed"}) for row in rows]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UsageError(f"{path} holds no findings of `oitbench stability`: {error}") from error


def by_method(findings: Sequence[Finding]) -> dict[str, list[Finding]]:
    """Return the findings of each method's variant, in order of first appearance."""
    found: dict[str, list[Finding]] = {}
    for finding in findings:
        found.setdefault(finding.method, []).append(finding)
    return found


MARKS = {HOLDS: "+", BREAKS: "x", DOES_NOT_APPLY: "·"}
"""One letter a result, in tables."""


def table(findings: Sequence[Finding]) -> Table:
    """Return one row a variant, with one mark for each check: + holds, x breaks, · not applicable.

    A broken promise is an X.
    """
    from rich.table import Table
    from rich.text import Text

    shown = Table("Method", "Identities", "Hard cases", "Faults", title="Stability")
    shown.columns[0].no_wrap = shown.columns[1].no_wrap = shown.columns[2].no_wrap = True
    for method, own in by_method(findings).items():
        faults = told_faults(own)
        shown.add_row(
            Text(method),
            _marks([finding for finding in own if finding.identity]),
            _marks([finding for finding in own if not finding.identity]),
            Text("; ".join(faults) or "–", style="red" if faults else ""),
        )
    shown.caption = legend(findings)
    shown.caption_justify = "left"
    return shown


def legend(findings: Sequence[Finding]) -> str:
    """Return the order of the marks in words."""
    first = next(iter(by_method(findings).values()), [])
    identities = ", ".join(finding.check for finding in first if finding.identity)
    cases = ", ".join(finding.check for finding in first if not finding.identity)
    return (
        "+ holds, x breaks, X breaks a promise, · does not apply. "
        f"Identities: {identities}. Hard cases: {cases}."
    )


def _marks(findings: Sequence[Finding]) -> Text:
    from rich.text import Text

    styles = {HOLDS: "green", BREAKS: "yellow", DOES_NOT_APPLY: "dim"}
    told = Text()
    for finding in findings:
        broken = finding.promised and finding.result == BREAKS
        mark = "X" if broken else MARKS[finding.result]
        told.append(mark, style="bold red" if finding.failed else styles[finding.result])
    return told


def told_faults(findings: Sequence[Finding]) -> list[str]:
    """Return in words what must not be: broken promises, and unstable pixels by kind."""
    broken = [f.check for f in findings if f.promised and f.result == BREAKS]
    told = [f"promises broken: {', '.join(broken)}"] if broken else []
    counts = {
        "NaN": sum(f.nan for f in findings),
        "infinite": sum(f.inf for f in findings),
        "negative": sum(f.negative for f in findings if not f.signed),
    }
    told += [f"{count} {kind} pixels" for kind, count in counts.items() if count]
    told += sorted({f.reason for f in findings if f.result == BREAKS and f.reason})
    changing = [f.check for f in findings if not f.repeatable]
    return told + ([f"changes between runs: {', '.join(changing)}"] if changing else [])
