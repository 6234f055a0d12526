"""The differences of two runs as tables: metrics, counts, facts, times, and cells of one side."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from oitbench.parameters import natural
from oitbench.report.artifacts import Column, Row, Table, write_table
from oitbench.results.comparison import ADDED, MISSING, Comparison, Difference
from oitbench.results.schema import WHOLE, Record
from oitbench.truths import TRUTHS

TIME = "method_ms"
_CELL = (Column("scene", "Scene", kind="text"), Column("method", "Method", kind="text"))
_FIELD = Column("field", "Field", kind="text", help="with the truth that a metric is against")
_VERDICT = Column("verdict", "Verdict", kind="status")
_NUMBERS = (
    *_CELL,
    _FIELD,
    Column("before", "Before", digits=5),
    Column("after", "After", digits=5),
    Column("change", "Change"),
    Column("allowed", "Tolerance", help="the largest change that counts as none"),
    _VERDICT,
)
_TEXTS = (
    *_CELL,
    _FIELD,
    Column("before", "Before", kind="prose"),
    Column("after", "After", kind="prose"),
    _VERDICT,
)
_LONE = (
    Column("method", "Method", kind="text"),
    Column("cells", "Cells"),
    Column("scenes", "Scenes", kind="prose"),
)
_CAPTIONS = {
    "metrics": ("Metrics", "Metrics that moved by more than their tolerance."),
    "counts": (
        "Counts",
        "Counts follow from declarations and rasterized samples: the same renderer repeats them.",
    ),
    "facts": ("Other facts", "Statuses, effects and passes that are not the same."),
    "times": (
        "Times",
        "Median method times, in ms, whose intervals do not overlap; they fail no comparison.",
    ),
}


def changes(comparison: Comparison, records: Mapping[str, Record], out: Path) -> dict[str, Table]:
    """Write tables of everything that differs in cells of both sides, and return them by kind.

    Parameters
    ----------
    comparison : Comparison
    records : mapping of str to Record
        Cells by their labels.
    out : Path
    """
    kinds: dict[str, list[Difference]] = {kind: [] for kind in _CAPTIONS}
    for item in comparison.differences:
        if item.field:
            kinds[_kind(item)].append(item)
    tables: dict[str, Table] = {}
    for kind, items in kinds.items():
        title, caption = _CAPTIONS[kind]
        columns, row = (_TEXTS, _texts) if kind == "facts" else (_NUMBERS, _numbers)
        rows = [row(item, records.get(item.cell)) for item in items]
        if rows:
            path = out / f"changes-{kind}.csv"
            tables[kind] = write_table(path, columns, rows, title=title, caption=caption)
    return tables


def lone(comparison: Comparison, records: Mapping[str, Record], out: Path) -> list[Table]:
    """Write tables of the methods with cells that only one side has: added and removed ones."""
    tables = []
    for verdict, word in ((ADDED, "added"), (MISSING, "removed")):
        cells = [item.cell for item in comparison.differences if item.verdict == verdict]
        rows = _by_method(cells, records)
        if rows:
            side = "after" if verdict == ADDED else "before"
            caption = f"Cells that only the run {side} has."
            path = out / f"changes-{word}.csv"
            title = word.capitalize()
            tables.append(write_table(path, _LONE, rows, title=title, caption=caption))
    return tables


def _by_method(cells: Iterable[str], records: Mapping[str, Record]) -> list[Row]:
    scenes: dict[str, list[str]] = {}
    for cell in cells:
        record = records.get(cell)
        scenes.setdefault(record.method if record else cell, []).append(
            record.seen if record else ""
        )
    return [
        (method, len(found), ", ".join(dict.fromkeys(found)))
        for method, found in sorted(scenes.items(), key=lambda item: natural(item[0]))
    ]


def _kind(item: Difference) -> str:
    if item.field == TIME:
        return "times"
    if item.field.partition(".")[0] in (*TRUTHS, WHOLE):
        return "metrics"
    return "facts" if isinstance(item.before, str) or isinstance(item.now, str) else "counts"


def _place(item: Difference, record: Record | None) -> tuple[str, str]:
    return (record.seen, record.method) if record else (item.cell, "")


def _numbers(item: Difference, record: Record | None) -> Row:
    change = None
    if isinstance(item.before, int | float) and isinstance(item.now, int | float):
        change = item.now - item.before
    values = (item.before, item.now, change, item.allowed)
    return (*_place(item, record), item.field, *values, item.verdict)


def _texts(item: Difference, record: Record | None) -> Row:
    return (*_place(item, record), item.field, item.before, item.now, item.verdict)
