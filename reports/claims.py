"""What papers and projects said of methods, and what these results say.

A claim is reproduced if every comparison that tests it holds here, refuted if none does, and
conditional if some do; its condition says which. "No evidence in these results" means that the
command would produce some. Verdicts follow from stored numbers alone; the files have the tests, the
commands and every comparison.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from oitbench.claims import ledger
from oitbench.claims.evidence import Evidence
from oitbench.claims.ledger import Source
from oitbench.claims.verdicts import WORDS, Verdict, judge
from oitbench.report import Artifact, Column, Note, ReportContext, write_table
from oitbench.report.artifacts import Row, Table, write_csv

title = "Claims"
order = 21

DATA = Path(__file__).with_suffix("")
"""The data files; each has sources with their claims."""
_SOURCE = Column("source", "Source", kind="text")
_CLAIM = Column("claim", "Name", kind="text")
_COLUMNS = (
    Column("said", "Claim", kind="prose", help="in other words than the source's"),
    Column("verdict", "Verdict", kind="status"),
    Column("reason", "Condition or reason", kind="prose"),
    Column("numbers", "Numbers", kind="prose", help="of some of the comparisons"),
    Column("held", "Held", kind="text", help="comparisons that hold, of those with results"),
    Column("section", "Section", kind="text", help="of the source"),
    Column(
        "figure",
        "Figure",
        kind="section",
        help="the report that shows them; report --figure NAME draws one that is not here",
    ),
    _CLAIM,
)
_FURTHER = (
    Column("remark", "Remark", kind="prose"),
    Column("machine", "Machine", kind="text"),
    Column("test", "Test", kind="prose"),
    Column("lacking", "Lacking", kind="prose"),
    Column("command", "Command", kind="prose"),
)
_CASES = (
    _CLAIM,
    Column("place", "Place", kind="text"),
    Column("subject", "Subject", kind="text"),
    Column("value", "Value"),
    Column("numbers", "Numbers", kind="prose"),
    Column("holds", "Holds", kind="text"),
)


def build(context: ReportContext) -> list[Artifact]:
    """Write a table for each source, one of how to repeat the tests, and one of all cases."""
    evidence = Evidence.load(context.results)
    judged = [
        (found, [judge(claim, evidence) for claim in found.claim]) for found in ledger.read(DATA)
    ]
    csv = context.out / "claims.csv"
    heading = [column.key for column in (_SOURCE, *_COLUMNS, *_FURTHER)]
    rows = [(found, verdict) for found, verdicts in judged for verdict in verdicts]
    write_csv(csv, heading, [_all(found, verdict) for found, verdict in rows])
    return [
        *map(Note, evidence.faults),
        Note(_summary([verdict for _, verdict in rows])),
        *(_table(place, found, verdicts, csv) for place, (found, verdicts) in enumerate(judged, 1)),
        _repeat(rows, csv),
        _cases([verdict for _, verdict in rows], context.out / "claims-cases.csv"),
    ]


def _summary(verdicts: Sequence[Verdict]) -> str:
    counts = Counter(verdict.word for verdict in verdicts)
    parts = [f"{counts[word]} {word}" for word in WORDS if counts[word]]
    plural = "" if len(verdicts) == 1 else "s"
    return f"Of {len(verdicts)} claim{plural}: {', '.join(parts)}."


def _row(verdict: Verdict) -> Row:
    claim = verdict.claim
    return (
        claim.said,
        verdict.word,
        verdict.reason,
        verdict.numbers,
        verdict.counts,
        claim.section,
        claim.figure,
        claim.id,
    )


def _further(found: Source, verdict: Verdict) -> Row:
    sentences = (trial.sentence for trial in verdict.claim.trials)
    return (
        verdict.claim.remark,
        found.machine,
        "; and ".join(filter(None, sentences)),
        "; ".join(verdict.lacking),
        " && ".join(verdict.commands),
    )


def _all(found: Source, verdict: Verdict) -> Row:
    return (found.cite, *_row(verdict), *_further(found, verdict))


def _table(place: int, found: Source, verdicts: Sequence[Verdict], csv: Path) -> Artifact:
    machine = f" Its numbers: {found.machine}." if found.machine else ""
    caption = f"{_summary(verdicts)}{machine} One line of the CSV file for each claim."
    rows = tuple(_row(verdict) for verdict in verdicts)
    return Table(found.cite, caption, csv, _COLUMNS, rows, stem=f"claims-{place:02d}")


def _repeat(rows: Sequence[tuple[Source, Verdict]], csv: Path) -> Artifact:
    shown = tuple((verdict.claim.id, *_further(found, verdict)) for found, verdict in rows)
    caption = (
        "How each claim is tested, what the results lack for it, and the command that produces or "
        "repeats the evidence; `--force` renders finished cells again."
    )
    heading = (_CLAIM, *_FURTHER)
    return Table(
        "Tests and commands", caption, csv, heading, shown, collapsed=True, stem="claims-tests"
    )


def _cases(verdicts: Sequence[Verdict], path: Path) -> Artifact:
    rows = [
        (verdict.claim.id, case.place, case.subject, case.value, case.text, _held(case.holds))
        for verdict in verdicts
        for case in verdict.cases
    ]
    caption = "Every comparison of every claim, with the number that decides it."
    title = "Comparisons"
    return write_table(path, _CASES, rows, title=title, caption=caption, collapsed=True)


def _held(holds: bool) -> str:
    return "yes" if holds else "no"
