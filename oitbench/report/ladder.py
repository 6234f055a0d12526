"""The ladder of truths: which part of a squared error each rung between two truths explains.

With the pictures m of a method, e of exact compositing, t of matched tracing and f of full path
tracing,

    m − f = (m − e) + (e − t) + (t − f),

so that the mean squared error to f is the sum of the mean squares of the three rungs and of twice
the means of their products. The noise of t and f adds its variance to squares and, with opposite
sign, to products of neighbors; it is subtracted from each.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from oitbench.image import metrics
from oitbench.report import plates
from oitbench.report.context import ReportContext
from oitbench.results.pictures import REDUCED, REDUCED_EXACT, compared
from oitbench.results.ranking import largest_noise_floor
from oitbench.results.records import Panel
from oitbench.results.schema import Record
from oitbench.truths import EXACT, FULL, MATCHED

COMPOSITING, EFFECTS, SHADING, CROSS = "compositing", "effects", "shading", "cross"
TERMS = {
    COMPOSITING: "compositing",
    EFFECTS: "approximation of effects",
    SHADING: "shading model",
    CROSS: "cross terms",
}
"""Keys of the parts of a squared error, and their names for readers."""
_RUNGS = (COMPOSITING, EFFECTS, SHADING)
_LEAST = 1 / 510
"""A smaller linear RMSE is not divided into shares: half a step of an 8-bit display."""

Picture = npt.NDArray[np.floating]


@dataclass(frozen=True)
class Split:
    """A mean squared error of linear radiance to the last truth of a ladder, and its parts.

    Parameters
    ----------
    total : float
        Without the noise of that truth.
    parts : dict of str to float
        By the keys of `TERMS`; they add up to `total`. Squares can be negative by what is left of
        the noise, and the cross terms are negative where errors cancel.
    noise : float
        Variance of the noise of all truths, which was subtracted.
    """

    total: float
    parts: dict[str, float]
    noise: float

    @property
    def shares(self) -> dict[str, float]:
        """The parts relative to the total; empty if no display or no truth resolves that."""
        if self.total <= max(self.noise, _LEAST**2):
            return {}
        return {name: value / self.total for name, value in self.parts.items()}


def split(pictures: Sequence[Picture], noise: Sequence[float]) -> Split:
    """Return the squared error between the first picture and the last one, and its parts.

    Parameters
    ----------
    pictures : sequence of array, shape (h, w, 3)
        Linear radiance of the method, of exact compositing, and of one or two traced truths.
    noise : sequence of float
        Variance of each picture's noise, averaged over pixels and channels.
    """
    exact = [np.asarray(picture, dtype=np.float64) for picture in pictures]
    rungs = [upper - lower for upper, lower in itertools.pairwise(exact)]
    parts = dict.fromkeys(TERMS, 0.0)
    for place, rung in enumerate(rungs):
        parts[_RUNGS[place]] = float((rung**2).mean()) - noise[place] - noise[place + 1]
        for other in range(place + 1, len(rungs)):
            shared = noise[other] if other == place + 1 else 0.0
            parts[CROSS] += 2 * (float((rung * rungs[other]).mean()) + shared)
    total = float(((exact[0] - exact[-1]) ** 2).mean()) - noise[0] - noise[-1]
    return Split(total, parts, sum(noise))


@dataclass(frozen=True)
class Ladder:
    """The truths of a panel, and the distances of its methods to them."""

    context: ReportContext
    panel: Panel

    def distance(self, cell: Record, truth: str) -> float | None:
        """Return the mean FLIP of a cell against a truth, or None."""
        return cell.metric(truth, self.context.flip)

    def floor(self, truth: str) -> float:
        """Return the FLIP that the noise of a truth alone causes."""
        return largest_noise_floor(self.panel.finished, truth, self.context.flip) or 0.0

    @cached_property
    def truths(self) -> tuple[str, ...]:
        """The truths that have a picture, in the order of the ladder."""
        kinds = (EXACT, MATCHED, FULL)
        return tuple(
            k for k in kinds if plates.first_image(self.context, self.panel, k) is not None
        )

    @cached_property
    def _below(self) -> tuple[list[Picture], list[float]] | None:
        """Pictures of all truths at the size of the traced ones, and the variances of their noise.

        None without exact compositing at that size, or without matched tracing.
        """
        traced = [truth for truth in (MATCHED, FULL) if truth in self.truths]
        exact = self._exact()
        if exact is None or traced[:1] != [MATCHED]:
            return None
        pictures: list[Picture] = [exact.astype(np.float64)]
        variances = [0.0]
        for truth in traced:
            image = plates.first_image(self.context, self.panel, truth)
            floor = largest_noise_floor(self.panel.finished, truth, metrics.RMSE)
            if image is None or image.shape != exact.shape:
                return None
            pictures.append(image.astype(np.float64))
            variances.append((floor or 0.0) ** 2)
        return pictures, variances

    def _exact(self) -> Picture | None:
        """Return exact compositing as traced truths see it."""
        for cell in self.panel.finished:
            if cell.outcome and REDUCED in cell.outcome.images:
                return self.context.results.image(cell, REDUCED_EXACT)
        return plates.first_image(self.context, self.panel, EXACT)

    @property
    def last(self) -> str:
        """The last truth of the ladder."""
        return FULL if FULL in self.truths else MATCHED

    @cached_property
    def splits(self) -> Mapping[str, Split]:
        """The squared errors to the last truth, by method; none where a picture is missing."""
        found = {cell.method: self._split(cell) for cell in self.panel.finished}
        return {method: split for method, split in found.items() if split is not None}

    def _split(self, cell: Record) -> Split | None:
        below = self._below
        if below is None or cell.outcome is None:
            return None
        pictures, variances = below
        image = self.context.results.image(cell, compared(cell.outcome, MATCHED))
        if image is None or image.shape != pictures[0].shape or not np.isfinite(image).all():
            return None
        return split([image, *pictures], [0.0, *variances])
