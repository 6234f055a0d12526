"""A page for each method: how it works, what a frame declares, promises, results and sources.

The text and the declaration are those of the method's file, if a collection has it when the report
is written; else the page shows what the results have. Promises were checked by the command
stability, if its results are in the folder.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from oitbench.catalog.messages import Portrait
from oitbench.method.demand_table import FACTS
from oitbench.method.demands import CLASSES
from oitbench.method.promises import PROMISES
from oitbench.parameters import natural
from oitbench.report import Artifact, Column, ReportContext, bibliography, columns, write_table
from oitbench.report.artifacts import Parts, Row, Table
from oitbench.report.bibliography import Source
from oitbench.report.cells import effect_labels
from oitbench.report.method_pages import diagram, docstring, page, scores
from oitbench.report.method_pages.page import MethodPage
from oitbench.report.method_pages.scores import Standing
from oitbench.results.schema import Record
from oitbench.stability import files
from oitbench.stability.result import BREAKS, CheckResult

title = "Methods"
order = 20.5

_LIST = (
    columns.METHOD,
    Column("title", "Title", kind="prose"),
    Column("family", "Family", kind="text"),
    Column("class", "Capability class", kind="text", help="that its declaration demands"),
    Column("sources", "Sources", kind="prose"),
)
_PARAMETERS = (
    Column("parameter", "Parameter", kind="text"),
    Column("default", "Default", kind="text"),
    Column("choices", "Choices", kind="text"),
    Column("meaning", "Meaning", kind="prose"),
)
_CHECK = Column("check", "Check", kind="text")
_REQUIREMENT = Column("requirement", "Requirement", kind="prose")
_ERROR = Column("error", "Error", help="largest in any pixel, or of the mean")
_ALLOWED = Column("allowed", "Allowed", help="largest error with which the check holds")
_PROMISES = (_CHECK, _REQUIREMENT, Column("result", "Result", kind="text"), _ERROR, _ALLOWED)
_BREAKS = (
    _CHECK,
    _REQUIREMENT,
    _ERROR,
    _ALLOWED,
    Column("expected", "Expected"),
    Column("found", "Found"),
)


@dataclass(frozen=True)
class _Known:
    """The facts that all pages share.

    Parameters
    ----------
    context : ReportContext
    labels : mapping of str to str
        The variant that stands for each method, by bare name.
    checks : mapping of str to list of CheckResult
        By variant.
    sources : mapping of str to Source
        By key.
    ranked : list of Standing
    """

    context: ReportContext
    labels: Mapping[str, str]
    checks: Mapping[str, Sequence[CheckResult]]
    sources: Mapping[str, Source]
    ranked: Sequence[Standing]


def build(context: ReportContext) -> list[Artifact]:
    """Write the pages, and a table that links to them."""
    own: dict[str, list[Record]] = {}
    for record in sorted(context.results.records, key=lambda record: natural(record.name)):
        own.setdefault(record.name, []).append(record)
    if not own:
        return []
    known = _Known(
        context,
        {name: scores.main_label(name, cells) for name, cells in own.items()},
        _checks(context),
        bibliography.read(context.bibliographies),
        scores.standings(context),
    )
    pages = [_page(known, name, cells) for name, cells in own.items()]
    rows = [_row(found) for found in pages]
    caption = "The name of a method opens its page."
    table = write_table(context.out / "methods.csv", _LIST, rows, title="Pages", caption=caption)
    parts = page.write(context, pages)
    return [table, Parts(tuple(parts))] if parts else [table]


def _row(found: MethodPage) -> Row:
    classes = (value for name, value in found.facts if name == "capability class")
    sources = ", ".join(f"{source.authors} {source.year}" for source in found.sources)
    return found.label, found.title, found.family, next(classes, ""), sources


def _checks(context: ReportContext) -> Mapping[str, Sequence[CheckResult]]:
    """Return the results of checks by the label of a method."""
    path = files.find(context.results.folder)
    found: dict[str, list[CheckResult]] = {}
    for result in files.read(path) if path is not None else ():
        found.setdefault(result.method, []).append(result)
    return found


def _page(known: _Known, name: str, cells: Sequence[Record]) -> MethodPage:
    context, label = known.context, known.labels[name]
    checks = known.checks.get(label, ())
    portrait = context.portraits.get(name, "the report was written without its file")
    described = portrait if isinstance(portrait, Portrait) else None
    doc = described.doc if described else ""
    outcome = next((cell.outcome for cell in cells if cell.outcome), None)
    drawn = diagram.diagram(described.outline) if described else None
    declared = "With default parameters, in a scene that requests all effects that it shows."
    if drawn is None and outcome is not None:
        cell, outcome = max(
            ((cell, cell.outcome) for cell in cells if cell.outcome is not None),
            key=lambda item: (len(item[1].passes), len(item[1].memory.terms)),
        )
        drawn = diagram.diagram(diagram.of_outcome(outcome, cell.size))
        declared = f"As {cell.method} was counted in {cell.seen}; formats are not known."
    promised = described.promises if described else [c.check for c in checks if c.promised]
    return MethodPage(
        name,
        docstring.title(doc) or name,
        described.family if described else (outcome.family if outcome else "unknown"),
        tuple(_remarks(portrait, cells)),
        tuple(docstring.blocks(doc)) if doc else (),
        tuple(_facts(described, cells)),
        drawn,
        declared,
        _parameters(context, name, described),
        _promises(context, name, promised, checks),
        _breaks(context, name, checks),
        scores.table(context, name, known.ranked),
        scores.extremes(context, label, known.ranked),
        tuple(known.sources[key] for key in bibliography.keys(doc) if key in known.sources),
        tuple(other for bare, other in known.labels.items() if bare != name),
        label,
    )


def _remarks(portrait: Portrait | str, cells: Sequence[Record]) -> Iterable[str]:
    if isinstance(portrait, str):
        yield f"The method's file was not found or cannot be used: {portrait}."
        return
    prints = {
        cell.fingerprints.method
        for cell in cells
        if cell.fingerprints is not None and cell.method == portrait.label
    }
    if prints and portrait.fingerprint not in prints:
        yield "The method's file has changed since these results: text and declaration are newer."


def _facts(portrait: Portrait | None, cells: Sequence[Record]) -> Iterable[tuple[str, str]]:
    """Yield what the method demands and shows, by its file or else by the results."""
    outcomes = [cell.outcome for cell in cells if cell.outcome is not None]
    if portrait is not None:
        demands, effects = portrait.demands, portrait.expresses
    elif outcomes:
        demands = max(
            (o.demands for o in outcomes), key=lambda it: [*CLASSES].index(it.capability_class)
        )
        effects = []
    else:
        return
    yield from ((fact.heading, str(fact.value(demands))) for fact in FACTS)
    if effects:
        yield "expresses", effect_labels(effects)


def _parameters(context: ReportContext, name: str, portrait: Portrait | None) -> Table | None:
    if portrait is None or not portrait.parameters:
        return None
    path = context.method_table(name, "parameters")
    rows = [
        (key, value, choices, meaning.replace("`", ""))
        for key, (value, choices, meaning) in portrait.parameters.items()
    ]
    return write_table(path, _PARAMETERS, rows, title="Parameters", caption="")


def _promises(
    context: ReportContext, name: str, promised: Sequence[str], checks: Sequence[CheckResult]
) -> Table | None:
    results = {check.check: check for check in checks}
    rows: list[Row] = []
    for promise in promised:
        check = results.get(promise)
        sentence = PROMISES.get(promise, check.sentence if check else "")
        numbers = (
            (check.status, check.error, check.allowed) if check else ("not checked", None, None)
        )
        rows.append((promise, sentence, *numbers))
    if not rows:
        return None
    how = "" if checks else f" The command oitbench stability --method {name} checks them."
    caption = f"Identities that the method keeps, within the rounding of its formats.{how}"
    path = context.method_table(name, "promises")
    return write_table(path, _PROMISES, rows, title="Promises", caption=caption)


def _breaks(context: ReportContext, name: str, checks: Sequence[CheckResult]) -> Table | None:
    rows = [
        (it.check, it.sentence, it.error, it.allowed, it.expected, it.found)
        for it in checks
        if it.status == BREAKS and not it.promised
    ]
    if not rows:
        return None
    caption = "Identities that the method does not promise, and hard cases, where they break."
    path = context.method_table(name, "limits")
    return write_table(path, _BREAKS, rows, title="Checks that break", caption=caption)
