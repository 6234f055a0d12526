"""The ranking of the methods of a scene, by the one truth that ranks it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from oitbench.image.ties import LEAST_T, Errors, clear_difference
from oitbench.results.records import Panel
from oitbench.results.schema import Record
from oitbench.truths import COMPOSITING_ONLY, EXACT, TRUTHS

EXPLANATION = (
    "Each scene has one ranking truth: exact compositing if all effects that it requests are "
    "compositing or shared shading, else matched tracing. Two methods tie unless a jackknife of "
    "their paired difference over the eight parts of the reference gives "
    f"|t| > {LEAST_T:g}; without noise, any difference counts. HDR-FLIP has no such test."
)
"""How methods are ranked, in words."""


@dataclass(frozen=True)
class Ranking:
    """The methods of a panel by error.

    Parameters
    ----------
    truth : str
        Key of the truth that ranks them.
    errors : mapping of str to Errors
        By method, lowest first; empty if that truth was left out or could not be made.
    noise_floor : float, optional
        Of the truth; None for exact compositing, and if it is unknown.
    """

    truth: str
    errors: Mapping[str, Errors]
    noise_floor: float | None

    @property
    def best(self) -> list[str]:
        """The method with the lowest error, and those that tie with it."""
        return _tied(self.errors, next(iter(self.errors))) if self.errors else []

    @property
    def ranks(self) -> dict[str, str]:
        """Ranks by method: those that tie with the best one of a rank share it, as in "2="."""
        ranks: dict[str, str] = {}
        left, place = dict(self.errors), 1
        while left:
            group = _tied(left, next(iter(left)))
            mark = "=" if len(group) > 1 else ""
            ranks |= dict.fromkeys(group, f"{place}{mark}")
            place += len(group)
            left = {name: errors for name, errors in left.items() if name not in group}
        return ranks


def ranking(panel: Panel, metric: str) -> Ranking:
    """Return the ranking of a panel by a FLIP metric."""
    truth = panel.truth
    known = {cell.method: cell.errors(truth, metric) for cell in panel.finished}
    errors = {method: found for method, found in known.items() if found is not None}
    ordered = dict(sorted(errors.items(), key=lambda item: item[1].error))
    return Ranking(truth, ordered, largest_noise_floor(panel.finished, truth, metric))


def largest_noise_floor(cells: Iterable[Record], truth: str, metric: str) -> float | None:
    """Return the largest noise floor of a truth of the cells; None if none is known."""
    floors = (cell.noise_floor(truth, metric) for cell in cells)
    return max((floor for floor in floors if floor is not None), default=None)


def truth_label(panel: Panel, truth: str) -> str:
    """Return the name of a truth, and for exact compositing whether it ranks the panel."""
    apart = truth == EXACT and panel.truth != EXACT
    return f"{TRUTHS[truth]} ({COMPOSITING_ONLY})" if apart else TRUTHS[truth]


def _tied(errors: Mapping[str, Errors], name: str) -> list[str]:
    """Return the methods whose difference from `name` is not clear, and itself."""
    best = errors[name]
    return [other for other, found in errors.items() if clear_difference(found, best) == 0]
