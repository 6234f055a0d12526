"""How far the noise of a reference moves errors, and whether two methods tie in spite of it.

A reference that is not free of noise is a set of independent pictures, its parts. All methods share
them, so that a method can be better than another one by less than the noise of the reference.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from oitbench.image.files import Image

Metric = Callable[[Image, Image], float]
"""Maps an image and the truth to an error."""

PARTS = 8
"""Parts of a reference with noise."""
LEAST_T = 2.36
"""|t| above which a difference is clear: 95 % of Student's distribution with `PARTS` − 1 degrees of
freedom lie within."""


@dataclass(frozen=True)
class Errors:
    """The error of an image, and what the parts of the reference tell of its uncertainty.

    Parameters
    ----------
    error : float
        Against the mean of all parts.
    without : sequence of float
        Against the mean of all parts but one, for each part; empty if the reference has no noise.
    """

    error: float
    without: Sequence[float] = ()


def means_without(parts: Sequence[Image]) -> list[Image]:
    """Return, for each part, the mean of all others; nothing for a single part."""
    if len(parts) == 1:
        return []
    total = np.stack(parts).sum(axis=0, dtype=np.float64)
    return [((total - part) / (len(parts) - 1)).astype(np.float32) for part in parts]


def noise_floor(parts: Sequence[Image], metric: Metric) -> float:
    """Return the error that the noise of a reference alone causes.

    It is the metric between M and M + (A − B)/2, where M is the mean of all parts, and A and B are
    the means of either half of them: (A − B)/2 varies as M does. A single part has no noise.

    Parameters
    ----------
    parts : sequence of array, shape (h, w, 3)
        One, or an even number.
    metric : Metric
    """
    if len(parts) == 1:
        return 0.0
    stacked = np.stack(parts).astype(np.float64)
    first, second = stacked[0::2].mean(axis=0), stacked[1::2].mean(axis=0)
    mean = stacked.mean(axis=0)
    moved = mean + (first - second) / 2
    return metric(moved.astype(np.float32), mean.astype(np.float32))


def clear_difference(one: Errors, other: Errors) -> float:
    """Return by how much `one` clearly exceeds `other`; 0 for a tie.

    The standard error of the paired difference is estimated by the jackknife: of the differences
    against the means of all parts but one (Efron & Stein 1981). They tie unless |t| > `LEAST_T`.
    Against a reference that has no noise, any difference is clear.

    Parameters
    ----------
    one, other : Errors
        Against the same reference.
    """
    return clear_mean_difference([one], [other])


def clear_mean_difference(ones: Sequence[Errors], others: Sequence[Errors]) -> float:
    """Return by how much the mean of `ones` clearly exceeds that of `others`; 0 for a tie.

    The noise of different references is independent, so that the variances of their paired
    differences add up.

    Parameters
    ----------
    ones, others : sequence of Errors
        Each pair is against the same reference, and pairs are against different ones.
    """
    pairs = list(zip(ones, others, strict=True))
    found = sum(one.error - other.error for one, other in pairs) / len(pairs)
    error = math.sqrt(sum(_variance(one, other) for one, other in pairs)) / len(pairs)
    return found if abs(found) > LEAST_T * error else 0.0


def _variance(one: Errors, other: Errors) -> float:
    """Return the squared standard error of a paired difference; 0 without noise."""
    count = len(one.without)
    if count != len(other.without) or count < 2:
        return 0.0
    left = np.subtract(one.without, other.without)
    return (count - 1) / count * float(((left - left.mean()) ** 2).sum())
