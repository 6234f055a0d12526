"""Which method to use, and at what price: choices derived from results, by the subjects of scenes.

Over several scenes, errors are averaged arithmetically, and method times geometrically, so that
scenes of different sizes count alike. A method's *cost* is its mean time relative to the least mean
time. Only methods with an error in all of these scenes are compared, by the times of those scenes
that were timed.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from oitbench.effects import SHADING, effects_of, names
from oitbench.report.artifacts import decimal
from oitbench.report.cells import effect_label
from oitbench.report.families import UNSEEN
from oitbench.results.ranking import ranking
from oitbench.results.records import Panel
from oitbench.results.times import SIGN

CHEAP = 2.0
"""A cheap method takes at most that many times the time of the fastest."""
NEAR = 0.01
"""A FLIP error this far above the least is hard to see."""
ELSEWHERE = "other scenes"
"""The subject of scenes that state none."""
_FEW = 3


@dataclass(frozen=True)
class Price:
    """A method over some scenes.

    Parameters
    ----------
    method : str
    error : float
        Mean FLIP error against the truths that rank the scenes.
    ms : float, optional
        Geometric mean of its method time, in ms; None if it was not timed in each scene in which
        another method was.
    cost : float, optional
        That time relative to the least one.
    disturbed : bool
        Whether other processes disturbed one of its times.
    """

    method: str
    error: float
    ms: float | None
    cost: float | None
    disturbed: bool = False


@dataclass(frozen=True)
class Choice:
    """A method that one criterion chooses, and others that are as good by it."""

    price: Price
    equal: tuple[str, ...] = ()


@dataclass(frozen=True)
class Answer:
    """The choices for one subject.

    Parameters
    ----------
    subject : str
    scenes : tuple of str
        Titles of the panels.
    timed : int
        Scenes that give the times: less than all where no method was timed in one of them.
    least, cheap, near, fastest : Choice, optional
        The least error, whatever the time; the least error of methods that are cheap; the cheapest
        of the methods near the least error; and the fastest. Only the first does without times.
    """

    subject: str
    scenes: tuple[str, ...]
    timed: int
    least: Choice
    cheap: Choice | None
    near: Choice | None
    fastest: Choice | None


@dataclass(frozen=True)
class Subject:
    """Scenes that show the same thing."""

    name: str
    panels: tuple[Panel, ...]
    metric: str

    @cached_property
    def prices(self) -> list[Price]:
        """All methods that have an error in each scene, the least error first."""
        errors = [ranking(panel, self.metric).errors for panel in self.panels]
        shared = set.intersection(*(set(found) for found in errors))
        ms = {
            method: _mean([found[method] for found in self._times])
            for method in shared
            if self._times and all(method in found for found in self._times)
        }
        least = min(ms.values(), default=math.nan)
        prices = [
            Price(
                method,
                sum(found[method].error for found in errors) / len(errors),
                ms.get(method),
                ms[method] / least if method in ms else None,
                self._disturbed(method),
            )
            for method in sorted(shared)
        ]
        return sorted(prices, key=lambda price: (price.error, price.cost or math.inf))

    @cached_property
    def _best(self) -> list[set[str]]:
        """The methods that tie for the least error, of each scene."""
        return [set(ranking(panel, self.metric).best) for panel in self.panels]

    @cached_property
    def _times(self) -> list[Mapping[str, float]]:
        """Median method times by method, of each scene that was timed."""
        return [found for panel in self.panels if (found := _times(panel))]

    def _disturbed(self, method: str) -> bool:
        cells = [cell for panel in self.panels for cell in panel.finished if cell.method == method]
        return any(cell.time is not None and cell.time.block.disturbed for cell in cells)

    @cached_property
    def answer(self) -> Answer | None:
        """The choices; None if no method has an error in each scene."""
        if not self.prices:
            return None
        timed = [price for price in self.prices if price.cost is not None]
        least = self._least(self.prices)
        cheap = [price for price in timed if price.cost is not None and price.cost <= CHEAP]
        near = [price for price in timed if price.error <= self.prices[0].error + NEAR]
        titles = tuple(panel.title for panel in self.panels)
        return Answer(
            self.name,
            titles,
            len(self._times),
            least,
            self._least(cheap) if cheap else None,
            Choice(min(near, key=_cost)) if near else None,
            Choice(min(timed, key=_cost)) if timed else None,
        )

    def _least(self, prices: Sequence[Price]) -> Choice:
        """Return the method of least error; of those that tie with it, the cheapest."""
        best = min(prices, key=lambda price: price.error)
        tied = [price for price in prices if self._tie(price, best)]
        chosen = min(tied, key=_cost)
        return Choice(chosen, tuple(price.method for price in tied if price is not chosen))

    def _tie(self, price: Price, best: Price) -> bool:
        """Whether no display shows the difference, or the noise of each reference hides it."""
        if price.error - best.error <= UNSEEN:
            return True
        pair = {price.method, best.method}
        return all(pair <= best for best in self._best)


def subjects(panels: Iterable[Panel], metric: str) -> list[Subject]:
    """Return the finished panels by subject; those of most scenes come first, others last."""
    groups: dict[str, list[Panel]] = {}
    for panel in panels:
        found = [cell.outcome.subject for cell in panel.finished if cell.outcome]
        if found:
            groups.setdefault(found[0] or ELSEWHERE, []).append(panel)
    ordered = sorted(groups, key=lambda name: (name == ELSEWHERE, -len(groups[name]), name))
    return [Subject(name, tuple(groups[name]), metric) for name in ordered]


def sentences(found: Sequence[Answer], panels: Sequence[Panel], metric: str) -> list[str]:
    """Return the answer in sentences, the most general first."""
    alone = [one.answer for panel in panels for one in subjects([panel], metric)]
    each = [answer for answer in alone if answer is not None]
    said = []
    cheap = _counted(answer.cheap for answer in each)
    if cheap:
        said.append(
            f"Within {CHEAP:g} times the time of the fastest method, the least error comes from"
            f" {cheap}."
        )
    near = _counted(answer.near for answer in each)
    if near:
        said.append(f"The cheapest method within {NEAR:g} FLIP of the least error is {near}.")
    least = _counted(answer.least for answer in each)
    if least:
        said.append(f"Whatever it takes, the least error comes from {least}.")
    return [*said, *_only(panels)]


def _counted(choices: Iterable[Choice | None]) -> str:
    """Return "A in 5 of 9 scenes, B in 3 and C in 1"."""
    counts: dict[str, int] = {}
    total = 0
    for choice in choices:
        total += 1
        if choice is not None:
            method = choice.price.method
            counts[method] = counts.get(method, 0) + 1
    if not counts:
        return ""
    ordered = sorted(counts, key=lambda method: (-counts[method], method))
    scenes = "scene" if total == 1 else "scenes"
    first, *rest = (f"{method} in {counts[method]}" for method in ordered[:_FEW])
    left = len(ordered) - _FEW
    others = f" and {left} other{'s' if left > 1 else ''} in the rest" if left > 0 else ""
    return ", ".join([f"{first} of {total} {scenes}", *rest]) + others


def _only(panels: Sequence[Panel]) -> list[str]:
    """Return sentences about effects that scenes request and few methods show."""
    shown: dict[str, set[str]] = {}
    known: set[str] = set()
    for panel in panels:
        for cell in panel.finished:
            known.add(cell.name)
            wanted = effects_of(cell.requested_effects) & ~SHADING
            missing = set(cell.missing_effects)
            for effect in names(wanted):
                able = shown.setdefault(effect, set())
                if effect not in missing:
                    able.add(cell.name)
    groups: dict[tuple[str, ...], list[str]] = {}
    for effect, able in shown.items():
        if len(able) <= _FEW < len(known):
            groups.setdefault(tuple(sorted(able)), []).append(effect_label(effect))
    return [_said_only(able, effects) for able, effects in groups.items()]


def _said_only(able: Sequence[str], effects: Sequence[str]) -> str:
    if not able:
        return f"No method here shows {_listed(effects)}."
    verb = "shows" if len(able) == 1 else "show"
    return f"Only {_listed(able)} {verb} {_listed(effects)}."


def _listed(words: Sequence[str]) -> str:
    return " and ".join(filter(None, [", ".join(words[:-1]), words[-1]]))


def described(choice: Choice | None, *, cost: bool = True) -> str:
    """Return the numbers of a choice: its error, its time, and its cost if that is asked for."""
    if choice is None:
        return ""
    price = choice.price
    parts = [f"FLIP {price.error:.3f}" if price.error >= 5e-4 else "FLIP below 0.0005"]
    if price.ms is not None and price.cost is not None:
        sign = f" {SIGN}" if price.disturbed else ""
        ratio = decimal(price.cost, 2)
        least = f" ({f'{ratio}× ' if price.cost > 1 else ''}the least time)" if cost else ""
        parts.append(f"{decimal(price.ms)} ms{sign}{least}")
    return ", ".join(parts)


def _times(panel: Panel) -> Mapping[str, float]:
    """Return the median method time of each method in ms."""
    return {
        cell.method: cell.time.method_ms.median for cell in panel.finished if cell.time is not None
    }


def _mean(values: Sequence[float]) -> float:
    """Return the geometric mean."""
    return math.exp(sum(map(math.log, values)) / len(values))


def _cost(price: Price) -> float:
    return math.inf if price.cost is None else price.cost
