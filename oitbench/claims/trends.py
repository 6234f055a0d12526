"""Trials of how a quantity grows: with a parameter, with a scene, or with a count of fragments."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, Literal

import numpy as np

from oitbench.claims import quantities
from oitbench.claims.comparisons import Compared, lacking
from oitbench.claims.evidence import Evidence, Subject
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

METHODS: Final = "methods"
_LEAST_POINTS = 3


class Slope(Compared, frozen=True, kw_only=True, tag="slope"):
    """The slope of the line of regression of a quantity over numbers, on logarithmic axes.

    The numbers `x` belong to the methods `of` in each scene, or to the `scenes` for each method.
    """

    x: list[float]
    over: Literal["methods", "scenes"] = METHODS

    def __post_init__(self) -> None:
        super().__post_init__()
        steps = self.of if self.over == METHODS else self.scenes
        if len(self.x) != len(steps) or min(self.x, default=0) <= 0:
            raise ValueError(f"x needs a positive number for each of the {self.over}")

    @property
    def sentence(self) -> str:
        """How the claim is tested, for readers."""
        values = ", ".join(f"{x:g}" for x in self.x)
        return (
            f"slope {self.bounds.words} of {quantities.words(self.quantity)} of"
            f" {names(self.subjects)} over {values}, logarithmic axes, {places_text(self.scenes)}"
        )

    def tried(self, evidence: Evidence) -> Tried:
        """Return a case for each scene or each method."""
        tried = Tried()
        curves: dict[tuple[str, str], dict[float, float]] = {}
        for step, subject in enumerate(self.subjects):
            found = evidence.measured(self.quantity, subject, self.scenes)
            tried.lacking.extend(lacking(found, subject.label, self.scenes))
            for place, measured in found.items():
                title = evidence.title(place)
                if self.over == METHODS:
                    key, x = (title, self.subjects[0].method.partition("[")[0]), self.x[step]
                else:
                    setting = title.removeprefix(place[0])
                    key, x = (f"all scenes{setting}", subject.label), self.x[self._at(place[0])]
                curves.setdefault(key, {})[x] = measured.value
        least = max(quantities.quantity(self.quantity).least, 1e-12)
        for (title, label), curve in curves.items():
            if len(curve) >= min(_LEAST_POINTS, len(self.x)):
                tried.cases.append(self._case(title, label, curve, least))
        return tried

    def _at(self, scene: str) -> int:
        return self.scenes.index(scene)

    def _case(self, title: str, label: str, curve: dict[float, float], least: float) -> Case:
        x = sorted(curve)
        y = [max(curve[place], least) for place in x]
        slope = float(np.polyfit(np.log(x), np.log(y), 1)[0]) if len(x) > 1 else math.nan
        points = ", ".join(f"{place:g}: {number(curve[place])}" for place in x)
        what = quantities.words(self.quantity)
        text = f"slope {slope:+.2f} of {what} ({points})"
        return Case(title, label, slope, text, self.bounds.admit(slope), what)


class Storage(Trial, frozen=True, kw_only=True, tag="storage"):
    """Bytes of memory against those of a formula: a part for pixels, and one for fragments."""

    of: Subjects
    per_pixel: float = 0.0
    per_fragment: float = 0.0
    tolerance: float = 0.0

    @property
    def subjects(self) -> list[Subject]:
        """All methods that are needed, with their settings."""
        return expand(self.of)

    @property
    def sentence(self) -> str:
        """How the claim is tested, for readers."""
        return (
            f"memory of {names(self.subjects)} is {self.per_pixel:g} bytes a pixel and"
            f" {self.per_fragment:g} bytes a fragment (tolerance {self.tolerance:.1%}),"
            f" {places_text(self.scenes)}"
        )

    def tried(self, evidence: Evidence) -> Tried:
        """Return a case for each method at each place."""
        tried = Tried()
        bounds = Bounds(equal=1.0, tolerance=self.tolerance)
        for subject in self.subjects:
            cells = evidence.cells(subject, self.scenes)
            tried.lacking.extend(lacking(cells, subject.label, self.scenes))
            for place, cell in cells.items():
                assert cell.outcome is not None
                pixels, fragments = math.prod(cell.size), cell.outcome.statistics.fragments
                formula = self.per_pixel * pixels + self.per_fragment * fragments
                found = cell.outcome.memory.bytes
                value = found / formula if formula else math.inf
                text = f"{found:,} bytes, formula {formula:,.0f}"
                title, label = evidence.title(place), subject.label
                tried.cases.append(Case(title, label, value, text, bounds.admit(value)))
        return tried


class Disagreement(Trial, frozen=True, kw_only=True, tag="disagreement"):
    """The part of the pairs of methods that two quantities order differently."""

    of: Subjects
    first: str
    second: str
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
        return [self.first, self.second]

    @property
    def sentence(self) -> str:
        """How the claim is tested, for readers."""
        first, second = map(quantities.words, self.quantity_names)
        return (
            f"part {self.bounds.words} of the pairs of {names(self.subjects)} that {first} and"
            f" {second} order differently, {places_text(self.scenes)}"
        )

    def tried(self, evidence: Evidence) -> Tried:
        """Return a case for each place that has at least two of the methods."""
        tried = Tried()
        known: dict[str, list[tuple[float, float]]] = {}
        for subject in self.subjects:
            first = evidence.measured(self.first, subject, self.scenes)
            second = evidence.measured(self.second, subject, self.scenes)
            both = {
                place: (first[place].value, second[place].value)
                for place in first
                if place in second
            }
            tried.lacking.extend(lacking(both, subject.label, self.scenes))
            for place, values in both.items():
                known.setdefault(evidence.title(place), []).append(values)
        for title, points in known.items():
            pairs = [(a, b) for place, a in enumerate(points) for b in points[:place]]
            if pairs:
                apart = sum((a[0] - b[0]) * (a[1] - b[1]) < 0 for a, b in pairs)
                value = apart / len(pairs)
                text = f"{apart} of {len(pairs)} pairs"
                label = f"{len(points)} methods"
                tried.cases.append(Case(title, label, value, text, self.bounds.admit(value)))
        return tried
