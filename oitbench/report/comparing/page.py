"""The page of a comparison, in one folder that opens from disk."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from oitbench.report import latex, previews
from oitbench.report.artifacts import writing_to
from oitbench.report.comparing import pictures, tables
from oitbench.report.context import ReportContext
from oitbench.report.page import VIEWER, facts_of
from oitbench.report.templates import environment
from oitbench.results import baseline
from oitbench.results.comparison import ADDED, MISSING, Comparison
from oitbench.results.records import Results

_TILES = 4


def write(comparison: Comparison, after: Path, before: Path, out: Path) -> Path:
    """Write the page of a comparison, and return it.

    Parameters
    ----------
    comparison : Comparison
        Of both.
    after : Path
        A results folder.
    before : Path
        Another one, or a baseline file, which has no pictures.
    out : Path
        The folder of the page.

    Raises
    ------
    UsageError
        `after` is no results folder, or `out` cannot be written to.
    """
    new = Results.load(after)
    old = Results.load(before) if before.is_dir() else None
    context = ReportContext(new, out)
    labels = {baseline.label(record): record for record in new.records}
    former = {baseline.label(record): record for record in old.records} if old else {}
    notes: list[str] = []
    common = [(former[label], record) for label, record in labels.items() if label in former]
    page = out / "index.html"
    with writing_to(out):
        found = list(pictures.pairs(old, new, common, notes)) if old else []
        found.sort(key=lambda pair: (-pair.mean, baseline.label(pair.record)))
        room = previews.room(_TILES * len(found))
        shown = [
            pictures.show(pair, number, _title(pair), out, room)
            for number, pair in enumerate(found, start=1)
        ]
        records = {**former, **labels}
        changed = tables.changes(comparison, records, out)
        lone = tables.lone(comparison, records, out)
        latex.write_all([*changed.values(), *lone])
        text = (
            environment(context)
            .get_template("comparing/page.html")
            .render(
                names=(str(before), str(after)),
                comparison=comparison,
                sentence=_sentence(comparison),
                pictures=shown,
                compared=len(common) if old else 0,
                tables=changed.values(),
                kinds=changed,
                lone=lone,
                notes=notes,
                machines=[
                    (word, facts_of(results.facts))
                    for word, results in (("Before", old), ("After", new))
                    if results is not None
                ],
                viewer=VIEWER,
            )
        )
        page.write_text(text, encoding="utf-8", errors="backslashreplace", newline="")
    return page


def _title(pair: pictures.Pair) -> str:
    return f"{pair.record.seen}, {pair.record.method}"


def _sentence(comparison: Comparison) -> str:
    """Return how many values changed by verdict, and how many cells one side has alone."""
    counts = Counter(item.verdict for item in comparison.differences)
    added, removed = counts.pop(ADDED, 0), counts.pop(MISSING, 0)
    values = ", ".join(f"{count} {verdict}" for verdict, count in counts.items()) or "none changed"
    cells = f"{comparison.cells} cell{'' if comparison.cells == 1 else 's'} compared"
    return f"{cells}; values: {values}; cells added: {added}, removed: {removed}."
