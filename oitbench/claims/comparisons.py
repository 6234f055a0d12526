"""Trials that compare one quantity of methods: with bounds, or with that of other methods."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import ClassVar

from oitbench.claims import quantities
from oitbench.claims.evidence import Evidence, Place, Subject
from oitbench.claims.quantities import Measured
from oitbench.claims.trial import (
    Bounds,
    Case,
    Subjects,
    Trial,
    Tried,
    expand,
    names,
    number,
    places_text,
)
from oitbench.image.ties import clear_difference
from oitbench.measure.intervals import interval
from oitbench.results.times import SIGN


class Compared(Trial, frozen=True, kw_only=True):
    """A quantity of the methods `of`, which must lie within `bounds`."""

    of: Subjects
    quantity: str
    bounds: Bounds

    def __post_init__(self) -> None:
        quantities.check(self.quantity_names)

    @property
    def subjects(self) -> list[Subject]:
        """All methods that are needed, with their settings."""
        return expand(self.of)

    @property
    def quantity_names(self) -> Sequence[str]:
        """The quantities of cells or films that are compared."""
        return [self.quantity]


class Value(Compared, frozen=True, kw_only=True, tag="value"):
    """The quantity itself."""

    @property
    def sentence(self) -> str:
        """How the claim is tested, for readers."""
        what = f"{quantities.words(self.quantity)} of {names(self.subjects)}"
        return f"{what} {self.bounds.words}, {places_text(self.scenes)}"

    def tried(self, evidence: Evidence) -> Tried:
        """Return a case for each method at each place."""
        tried = Tried()
        for subject in self.subjects:
            found = evidence.measured(self.quantity, subject, self.scenes)
            tried.lacking.extend(lacking(found, subject.label, self.scenes))
            for place, measured in found.items():
                value = measured.value
                what = quantities.quantity(self.quantity).words
                text = f"{number(value)} {what}"
                text += f" {SIGN}" if measured.disturbed else ""
                holds = self.bounds.admit(value)
                title, label = evidence.title(place), subject.label
                tried.cases.append(Case(title, label, value, text, holds, what))
        return tried


class _Pairs(Compared, frozen=True, kw_only=True):
    """Each method `of` against each method `to`, at the same place.

    `to_quantity` is the quantity of the other method. Default: the same.
    """

    relation: ClassVar[str] = "over"
    to: Subjects
    to_quantity: str = ""

    @property
    def subjects(self) -> list[Subject]:
        return list(dict.fromkeys([*expand(self.of), *expand(self.to)]))

    @property
    def quantity_names(self) -> Sequence[str]:
        return [self.quantity, self.to_quantity or self.quantity]

    def pairs(self, evidence: Evidence, tried: Tried) -> Iterator[tuple[Place, str, Pair]]:
        """Yield the pairs of values that are known, and note in `tried` what is lacking."""
        for one in expand(self.of):
            first = evidence.measured(self.quantity, one, self.scenes)
            for other in expand(self.to):
                second = evidence.measured(self.quantity_names[1], other, self.scenes)
                both = {place: (first[place], second[place]) for place in first if place in second}
                label = f"{one.label} {self.relation} {other.label}"
                tried.lacking.extend(lacking(both, label, self.scenes))
                for place, pair in both.items():
                    yield place, label, pair

    def _sentence(self, what: str) -> str:
        first, second = map(quantities.words, self.quantity_names)
        other = "" if first == second else f"{second} of "
        left, right = names(expand(self.of)), names(expand(self.to))
        return (
            f"{what} of {first} of {left} to {other}{right} {self.bounds.words},"
            f" {places_text(self.scenes)}"
        )


Pair = tuple[Measured, Measured]


class Ratio(_Pairs, frozen=True, kw_only=True, tag="ratio"):
    """The quotient. Errors that tie have the quotient 1; times are divided round by round."""

    @property
    def sentence(self) -> str:
        """How the claim is tested, for readers."""
        return self._sentence("ratio")

    def tried(self, evidence: Evidence) -> Tried:
        """Return a case for each pair of methods at each place.

        Times are lacking where the interval of their quotient does not tell whether it is within
        bounds.
        """
        tried = Tried()
        quantity = quantities.quantity(self.quantity)
        for place, label, pair in self.pairs(evidence, tried):
            value, ends, note = _quotient(pair, quantity.least)
            title = evidence.title(place)
            both = f"{number(pair[0].value)} / {number(pair[1].value)}"
            text = f"{quantity.words} ×{number(value)}{note} ({both})"
            if any(measured.disturbed for measured in pair):
                text += f" {SIGN}"
            holds = self.bounds.admit(value)
            if any(self.bounds.admit(end) != holds for end in ends):
                tried.lacking.append(f"{label} on {title} is undecided: {text}")
            else:
                tried.cases.append(Case(title, label, value, text, holds, quantity.words))
        return tried


def _quotient(pair: Pair, least: float) -> tuple[float, Sequence[float], str]:
    """Return the quotient of two values, its interval if it has one, and a note on it."""
    one, other = pair
    if one.errors and other.errors and clear_difference(one.errors, other.errors) == 0:
        return 1.0, (), " tied"
    if one.rounds and len(one.rounds) == len(other.rounds) and min(other.rounds) > 0:
        found = interval([a / b for a, b in zip(one.rounds, other.rounds, strict=True)])
        ends = found.ends or ()
        return found.median, ends, f" [{', '.join(map(number, ends))}]" if ends else ""
    above, below = max(one.value, least), max(other.value, least)
    if below == 0:
        return (1.0 if above == 0 else math.inf), (), ""
    return above / below, (), ""


class Difference(_Pairs, frozen=True, kw_only=True, tag="difference"):
    """The first value less the second one."""

    relation: ClassVar[str] = "less"

    @property
    def sentence(self) -> str:
        """How the claim is tested, for readers."""
        return self._sentence("difference")

    def tried(self, evidence: Evidence) -> Tried:
        """Return a case for each pair of methods at each place."""
        tried = Tried()
        for place, label, (one, other) in self.pairs(evidence, tried):
            value = one.value - other.value
            what = quantities.quantity(self.quantity).words
            text = f"{what} {value:+.2g} ({number(one.value)} − {number(other.value)})"
            holds, title = self.bounds.admit(value), evidence.title(place)
            tried.cases.append(Case(title, label, value, text, holds, what))
        return tried


def lacking(found: Iterable[Place], label: str, scenes: Sequence[str]) -> list[str]:
    """Return what is not among the places that were found, in words."""
    known = {place[0] for place in found}
    if not scenes:
        return [] if known else [label]
    return [f"{label} on {scene}" for scene in scenes if scene not in known]
