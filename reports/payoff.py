"""Where it pays to express more: path-traced FLIP of methods that show all and of those that miss.

Only scenes count that call for colored transmission, refraction, diffusion or colored shadows. A
difference below the noise floor of the path-traced picture is a tie.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from oitbench.report import Artifact, Column, Note, fixed, write_table
from oitbench.report.artifacts import Value
from oitbench.results import records as read
from oitbench.results.records import PATH_TRACED, Panel, Results
from oitbench.results.store import Record

title = "Where expressing more effects pays"
order = 25

_PHENOMENA = frozenset({"COLORED_TRANSMISSION", "REFRACTION", "DIFFUSION", "COLORED_SHADOWS"})
_EVERYTHING = "expresses all"


@dataclass(frozen=True)
class Finding:
    """The best method that misses the fewest effects against the best of all others.

    Parameters
    ----------
    scene : str
    more, less : Record
        The two.
    gain, floor : float
        By how much the first has less error, and the noise floor of the path-traced picture.
    """

    scene: str
    more: Record
    less: Record
    gain: float
    floor: float

    @property
    def tied(self) -> bool:
        """Whether both differ by less than the noise floor."""
        return abs(self.gain) <= self.floor


def build(results: Results, out: Path) -> list[Artifact]:
    """Write the table of all such scenes, and say of each scene whether it pays."""
    rows: list[tuple[Value, ...]] = []
    findings: list[Finding] = []
    for panel in results.panels():
        cells = _scored(panel, results.flip)
        called = {effect for cell in cells for effect in read.called_effects(cell)}
        if called & _PHENOMENA:
            rows += _rows(panel, cells, results.flip)
            finding = find(panel.title, cells, results.flip)
            findings += [] if finding is None else [finding]
    if not rows:
        phenomena = ", ".join(sorted(map(read.effect_label, _PHENOMENA)))
        return [Note(f"No cell with a path-traced error calls for any of {phenomena}.")]
    told = [Note(_sentence(finding, results.flip)) for finding in findings]
    return [_table(rows, results.flip, out), *_summary(findings, results.flip), *told]


def find(scene: str, cells: Sequence[Record], flip: str) -> Finding | None:
    """Hold those cells that miss the fewest effects against all others.

    Parameters
    ----------
    scene : str
    cells : sequence of Record
        With a path-traced error each; at least one.
    flip : str
        The metric.

    Returns
    -------
    Finding or None
        None if all miss the same number.
    """
    fewest = min(len(read.missing_effects(cell)) for cell in cells)
    full = [cell for cell in cells if len(read.missing_effects(cell)) == fewest]
    rest = [cell for cell in cells if cell not in full]
    if not rest:
        return None
    more, less = (min(group, key=lambda cell: _error(cell, flip)) for group in (full, rest))
    floor = read.largest_floor(cells, flip) or 0.0
    return Finding(scene, more, less, _error(less, flip) - _error(more, flip), floor)


def _summary(findings: Sequence[Finding], flip: str) -> list[Note]:
    """Say in which scenes it does not pay."""
    if not findings:
        return [Note("All methods miss the same number of effects, which decides nothing.")]
    lost = [
        f"{finding.scene} (tied)" if finding.tied else finding.scene
        for finding in findings
        if finding.gain <= 0
    ]
    if not lost:
        return [Note(f"Methods that express more effects have the lower {flip} in every scene.")]
    return [
        Note(
            f"Methods that express more effects do not have the lower {flip} in {', '.join(lost)}."
        )
    ]


def _sentence(finding: Finding, flip: str) -> str:
    verdict = "expressing more pays" if finding.gain > 0 else "expressing more does not pay"
    if finding.tied:
        verdict = f"a tie within the noise floor of {fixed(finding.floor, 4)}"
    errors = [fixed(_error(cell, flip), 4) for cell in (finding.more, finding.less)]
    return (
        f"{finding.scene}: {verdict}: {errors[0]} by {finding.more['method']}"
        f" ({_missing(finding.more)}), {errors[1]} by {finding.less['method']}"
        f" ({_missing(finding.less)})."
    )


def _scored(panel: Panel, flip: str) -> list[Record]:
    """Return the cells that have a path-traced error, least first."""
    known = [cell for cell in panel.finished if read.metric(cell, PATH_TRACED, flip) is not None]
    return sorted(known, key=lambda cell: _error(cell, flip))


def _error(cell: Record, flip: str) -> float:
    return read.metric(cell, PATH_TRACED, flip) or 0.0


def _missing(cell: Record) -> str:
    """Return what a method misses, in words."""
    missing = read.missing_effects(cell)
    return f"misses {', '.join(map(read.effect_label, missing))}" if missing else _EVERYTHING


def _rows(panel: Panel, cells: Sequence[Record], flip: str) -> list[tuple[Value, ...]]:
    floor = read.largest_floor(cells, flip)
    best = _error(cells[0], flip)
    rows: list[tuple[Value, ...]] = []
    for cell in cells:
        error = _error(cell, flip)
        tied = error - best <= (floor or 0.0)
        mark = "best" if cell is cells[0] else "tied with the best" if tied else ""
        rows.append((panel.title, cell["method"], _missing(cell), error, floor, mark))
    return rows


def _table(rows: Sequence[tuple[Value, ...]], flip: str, out: Path) -> Artifact:
    columns = (
        Column("scene", "Scene", kind="text"),
        Column("method", "Method", kind="method"),
        Column("effects", "Effects", kind="text", help="of those that the scene calls for"),
        Column(f"path_traced.{flip}", "FLIP traced", decimals=4, help=f"{flip} to path traced"),
        Column(f"noise_floor.{flip}", "noise floor", decimals=4, help="between two halves of it"),
        Column("mark", "Best", kind="text"),
    )
    caption = (
        "Methods of each scene by error against the path-traced picture, least first. Beneath, for "
        "each scene: the best of those that miss the fewest effects against the best of the others."
    )
    return write_table(
        out / "payoff.csv", columns, rows, title="Path-traced error by effects", caption=caption
    )
