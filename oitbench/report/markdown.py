"""Results as Markdown tables: those in the README."""

from __future__ import annotations

from collections.abc import Callable

from oitbench.image import metrics
from oitbench.report.cells import largest_noise_floor
from oitbench.report.times import EXPLANATION, is_disturbed, signed
from oitbench.results.records import Results
from oitbench.results.schema import EXACT, PATH_TRACED, Record

_MISSING = "–"


def tables(results: Results) -> str:
    """Return FLIP and method time by scene and method, one table for each truth with results.

    Each panel of the results is a row: a scene at one size with one set of effects. Cells that
    leave out effects are not shown.
    """
    parts = [f"FLIP against exact compositing, median method time\n\n{_table(results, _cost)}"]
    if any(map(is_disturbed, results.records)):
        parts.append(f"{EXPLANATION}\n")
    traced = _table(results, _distance, noise_floor=True)
    if traced:
        parts.append(f"FLIP against path tracing\n\n{traced}")
    return "\n".join(parts)


def _table(results: Results, text: Callable[[Record], str], noise_floor: bool = False) -> str:
    """Return a table with one row per scene and one column per method; "" without cells."""
    rows = []
    for panel in results.panels():
        cells = {cell.method: cell for cell in panel.cells}
        found = [cells.get(method) for method in results.methods]
        texts = [text(record) if record else _MISSING for record in found]
        if noise_floor:
            floor = largest_noise_floor(panel.cells, metrics.FLIP_LDR)
            if floor is None:
                continue
            texts.insert(0, f"{floor:.3f}")
        rows.append([panel.title, *texts])
    if not rows:
        return ""
    floors = ["noise floor"] if noise_floor else []
    heading = ["scene", *floors, *(f"`{method}`" for method in results.methods)]
    lines = [heading, ["---"] * len(heading), *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def _cost(record: Record) -> str:
    """Return the error against exact compositing and the method time."""
    error = record.metric(EXACT, metrics.FLIP_LDR)
    time = f"{record.time.method_ms.median:.3g} ms" if record.time else _MISSING
    time = signed(time, is_disturbed(record))
    return f"{_MISSING if error is None else f'{error:.4f}'}, {time}"


def _distance(record: Record) -> str:
    """Return the error against path tracing."""
    error = record.metric(PATH_TRACED, metrics.FLIP_LDR)
    return _MISSING if error is None else f"{error:.3f}"
