"""Results as Markdown tables: those in the README."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from oitbench.image import metrics
from oitbench.report.artifacts import decimal
from oitbench.report.times import EXPLANATION, is_disturbed, signed
from oitbench.results.ranking import largest_noise_floor, ranking
from oitbench.results.records import Panel, Results
from oitbench.truths import COMPOSITING_ONLY, EXACT, FULL, MATCHED, TRUTHS

_MISSING = "–"
_OTHERS = {
    EXACT: f"FLIP against {TRUTHS[EXACT]}: {COMPOSITING_ONLY}, no ranking",
    MATCHED: f"FLIP against {TRUTHS[MATCHED]}, all scenes",
    FULL: f"FLIP against {TRUTHS[FULL]}, for context; it ranks nothing",
}
"""Further tables, one for each truth, and their titles."""


def tables(results: Results) -> str:
    """Return FLIP by scene and method: against the ranking truth with times, then against each.

    Each panel of the results is a row: a scene at one size with one set of effects. Cells that
    leave out effects are not shown. In the first table, methods with the lowest error of a row,
    ties included, are bold.
    """
    ranked = [
        [panel.title, panel.truth, *_ranked(panel, results.methods)] for panel in results.panels()
    ]
    parts = [
        "FLIP against the ranking truth, median method time\n\n"
        + _table(["scene", "truth", "noise floor"], results.methods, ranked)
    ]
    if any(map(is_disturbed, results.records)):
        parts.append(f"{EXPLANATION}\n")
    for truth, title in _OTHERS.items():
        rows = [
            [panel.title, *found]
            for panel in results.panels()
            if (truth, panel.truth) != (EXACT, EXACT)
            and (found := _errors(panel, results.methods, truth))
        ]
        floors = [] if truth == EXACT else ["noise floor"]
        if rows:
            parts.append(f"{title}\n\n{_table(['scene', *floors], results.methods, rows)}")
    return "\n".join(parts)


def _table(heading: Sequence[str], methods: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    first = [*heading, *(f"`{method}`" for method in methods)]
    lines = [first, ["---"] * len(first), *rows]
    escaped = ([text.replace("|", r"\|") for text in line] for line in lines)
    return "".join(f"| {' | '.join(line)} |\n" for line in escaped)


def _ranked(panel: Panel, methods: Sequence[str]) -> Iterator[str]:
    """Yield the noise floor, and each method's error and method time."""
    found = ranking(panel, metrics.FLIP_LDR)
    best = found.best if len(found.errors) > 1 else []
    cells = {cell.method: cell for cell in panel.cells}
    yield _floor(found.noise_floor)
    for method in methods:
        cell, errors = cells.get(method), found.errors.get(method)
        if cell is None:
            yield _MISSING
            continue
        error = _MISSING if errors is None else f"{errors.error:.4f}"
        error = f"**{error}**" if method in best else error
        time = f"{decimal(cell.time.method_ms.median)} ms" if cell.time else _MISSING
        yield f"{error}, {signed(time, is_disturbed(cell))}"


def _errors(panel: Panel, methods: Sequence[str], truth: str) -> list[str]:
    """Return the noise floor of a traced truth, and each method's error; nothing without errors."""
    cells = {cell.method: cell for cell in panel.cells}
    values = {method: cell.metric(truth, metrics.FLIP_LDR) for method, cell in cells.items()}
    if all(value is None for value in values.values()):
        return []
    shown = (values.get(method) for method in methods)
    texts = [_MISSING if value is None else f"{value:.4f}" for value in shown]
    floor = largest_noise_floor(panel.cells, truth, metrics.FLIP_LDR)
    return texts if truth == EXACT else [_floor(floor), *texts]


def _floor(value: float | None) -> str:
    return _MISSING if value is None else f"{value:.4f}"
