"""Trials of promises, and of pictures that should be alike."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final, Literal

import numpy as np

from oitbench.claims.comparisons import lacking
from oitbench.claims.evidence import Evidence, Subject
from oitbench.claims.trial import (
    Bounds,
    Case,
    Trial,
    Tried,
    expand,
    line,
    names,
    number,
    option,
    places_text,
)
from oitbench.image import files, metrics
from oitbench.image.files import Image
from oitbench.results.schema import Record
from oitbench.stability.result import DOES_NOT_APPLY, HOLDS

FLIP: Final = "flip"


class Identity(Trial, frozen=True, kw_only=True, tag="identity"):
    """Checks of `oitbench stability` that the methods `of` pass, or fail."""

    of: list[str]
    checks: list[str]
    expected: Literal["holds", "breaks"] = HOLDS

    @property
    def subjects(self) -> list[Subject]:
        """All methods that are needed, with their settings."""
        return expand(self.of)

    @property
    def sentence(self) -> str:
        """How the claim is tested, for readers."""
        verb = "passes" if self.expected == HOLDS else "fails"
        return f"each of {names(self.subjects)} {verb}: {'; '.join(self.checks)}"

    def tried(self, evidence: Evidence) -> Tried:
        """Return a case for each check of each method."""
        tried = Tried()
        known = {(result.method, result.check): result for result in evidence.checks}
        for method in self.of:
            for check in self.checks:
                result = known.get((method, check))
                if result is None or result.status == DOES_NOT_APPLY:
                    tried.lacking.append(f"{method}: {check}")
                    continue
                error = float("inf") if result.error is None else result.error
                allowed = "" if result.allowed is None else f", allowed {result.allowed:.2g}"
                text = f"{result.status}: error {error:.2g}{allowed}"
                holds = result.status == self.expected
                tried.cases.append(Case(check, method, error, text, holds))
        return tried

    def commands(self, folder: Path, size: str) -> list[str]:
        """Return the command that produces the evidence; these checks have their own size."""
        return [line("oitbench stability", option("--method", self.of), folder / "stability")]


class Alike(Trial, frozen=True, kw_only=True, tag="alike"):
    """Stored pictures of the method `of` against those of `to`.

    `metric` is their mean FLIP, or the largest difference of displayed values in steps of 8 bits.
    """

    of: str | Subject
    to: str | Subject
    bounds: Bounds
    metric: Literal["flip", "steps"] = FLIP

    @property
    def subjects(self) -> list[Subject]:
        """All methods that are needed, with their settings."""
        return expand([self.of, self.to])

    @property
    def sentence(self) -> str:
        """How the claim is tested, for readers."""
        one, other = self.subjects
        what = "FLIP" if self.metric == FLIP else "largest difference, in steps of 8 bits,"
        return (
            f"{what} between the pictures of {one.label} and {other.label} {self.bounds.words},"
            f" {places_text(self.scenes)}"
        )

    def tried(self, evidence: Evidence) -> Tried:
        """Return a case for each place that has both pictures."""
        tried = Tried()
        one, other = self.subjects
        first, second = (evidence.cells(item, self.scenes) for item in (one, other))
        found: dict[tuple[str, tuple[int, int], int], float] = {}
        for place in first:
            if place in second:
                value = self._apart(evidence, first[place], second[place])
                if value is not None:
                    found[place] = value
        label = f"{one.label} and {other.label}"
        tried.lacking.extend(lacking(found, label, self.scenes))
        for place, value in found.items():
            holds = self.bounds.admit(value)
            tried.cases.append(Case(evidence.title(place), label, value, number(value), holds))
        return tried

    def _apart(self, evidence: Evidence, one: Record, other: Record) -> float | None:
        """Return how far two pictures are apart, or None if one cannot be read."""
        pictures = [evidence.results.image(cell, "color") for cell in (one, other)]
        if one.outcome is None or any(picture is None for picture in pictures):
            return None
        return apart(pictures, one.outcome.exposure, self.metric)


def apart(pictures: Sequence[Image | None], exposure: float, metric: str) -> float | None:
    """Return the distance of two linear pictures; None if a pixel is not finite."""
    first, second = (np.asarray(picture) for picture in pictures)
    if metric == FLIP:
        return metrics.flip_ldr(first, second, exposure)
    shown = [files.to_srgb(picture, exposure).astype(np.float64) for picture in (first, second)]
    largest = float(255 * np.abs(shown[0] - shown[1]).max())
    return largest if np.isfinite(largest) else None


class Untestable(Trial, frozen=True, kw_only=True, tag="untestable"):
    """No trial: nothing that results hold can test the claim.

    Parameters
    ----------
    reason : str
    absent : tuple of str
        Names of methods or scenes that do not exist, for lack of which there is no trial.
    command : str
        That shows something of the claim, although no results hold it.
    """

    reason: str
    absent: tuple[str, ...] = ()
    command: str = ""

    @property
    def subjects(self) -> list[Subject]:
        """No methods."""
        return []

    @property
    def sentence(self) -> str:
        """How the claim is tested, for readers."""
        return ""

    def tried(self, evidence: Evidence) -> Tried:
        """Return nothing."""
        return Tried()

    def commands(self, folder: Path, size: str) -> list[str]:
        """Return the command of the data file, if it has one."""
        return [self.command] if self.command else []
