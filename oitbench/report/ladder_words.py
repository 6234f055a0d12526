"""Ladders in words: the parts of the errors of the methods of a scene."""

from __future__ import annotations

from collections.abc import Mapping

from oitbench.effects import effects_of
from oitbench.report.ladder import COMPOSITING, CROSS, EFFECTS, SHADING, TERMS, Ladder, Split
from oitbench.results.ranking import ranking
from oitbench.results.schema import Record
from oitbench.truths import EXACT, FULL, TRUTHS, ranking_truth

_NOTHING = 0.005
"""A share that is rounded to 0 %."""


def words(ladder: Ladder) -> str:
    """Return sentences on the method of least error and on the range of all; "" without parts."""
    splits = ladder.splits
    ranked = [m for m in ranking(ladder.panel, ladder.context.flip).errors if m in splits]
    if not ranked:
        return ""
    best, truth = ranked[0], TRUTHS[ladder.last]
    if splits[best].shares:
        said = _consists(best, truth, splits[best], ladder.last == FULL)
        (cell,) = (cell for cell in ladder.panel.finished if cell.method == best)
        said += _departs(cell) if splits[best].parts[CROSS] < 0 else ""
    elif splits[best].total > splits[best].noise:
        said = f"{best} differs from {truth} by less than half a step of 8 bits."
    else:
        said = f"{best} differs from {truth} by less than the noise."
    return f"{said} {_range(splits)}".strip()


def _consists(method: str, truth: str, split: Split, full: bool) -> str:
    names = [COMPOSITING, EFFECTS, *([SHADING] if full else [])]
    shares = [f"{_percent(split.shares[name])} is {TERMS[name]}" for name in names]
    shares[1:] = [text.replace(" is ", " ") for text in shares[1:]]
    cross = split.shares[CROSS]
    if abs(cross) < _NOTHING:
        rest = f"and cross terms are {_percent(0.0)}"
    elif cross > 0:
        rest = f"and {_percent(cross)} cross terms of errors that add up"
    else:
        rest = f"and cross terms take {_percent(-cross)} off, where errors cancel"
    return f"Of the squared error of {method} to {truth}, {', '.join(shares)}, {rest}."


def _departs(cell: Record) -> str:
    """Return a sentence if a method draws effects that exact compositing lacks."""
    drawn = cell.outcome.effects.expressed if cell.outcome else []
    if ranking_truth(effects_of(drawn)) == EXACT:
        return ""
    return (
        " It draws effects that exact compositing lacks, so that its distance from that is no error"
        " alone."
    )


def _range(splits: Mapping[str, Split]) -> str:
    """Return a sentence on the least and the largest share of compositing."""
    shares = {m: split.shares[COMPOSITING] for m, split in splits.items() if split.shares}
    if len(shares) < 2:
        return ""
    least, most = min(shares, key=shares.__getitem__), max(shares, key=shares.__getitem__)
    low, high = _percent(shares[least]), _percent(shares[most])
    if low == high:
        return f"Compositing is {low} of it for all {len(shares)} methods with a visible error."
    return f"Compositing alone is from {low} ({least}) to {high} ({most})."


def _percent(share: float) -> str:
    """Return a share without a sign of what noise has left over."""
    return f"{100 * max(0.0, share):.0f}\N{NO-BREAK SPACE}%"
