"""Sections of a path-traced image: independent shares of its samples, and their statistics."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from oitbench.image.files import Image

SECTIONS = 8
"""Largest number of shares into which the samples of every image are split, however many workers
trace them, so that its rounding is always the same."""

Doubles = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Estimate:
    """A path-traced image.

    Parameters
    ----------
    mean : array, shape (h, w, 3), float32
        Linear Rec.709 radiance, top row first.
    variance : array, shape (h, w, 3), float32
        Variance of that mean, or more: samples of one half are spread evenly (see `sequence`), so
        that their mean varies less than that of independent ones.
    halves : pair of array, shape (h, w, 3), float32
        Means of the even and of the odd samples; with caustics, of the samples of the even and of
        the odd caustic maps. They are independent.
    spp : int
        Samples that were taken for each sub-pixel.
    """

    mean: Image
    variance: Image
    halves: tuple[Image, Image]
    spp: int


@dataclass(eq=False)
class Section:
    """Statistics of some groups of samples (Welford 1962; Chan, Golub and LeVeque 1983).

    Parameters
    ----------
    counts : array, shape (2,), int64
        Groups of the even and of the odd half.
    samples : int
        Samples of all groups, for each sub-pixel.
    sums : array, shape (2, h, w, 3)
        Sums of the groups of each half.
    mean : array, shape (h, w, 3)
        Of all groups.
    squares : array, shape (h, w, 3)
        Sum of squared differences from the mean.
    """

    counts: npt.NDArray[np.int64]
    samples: int
    sums: Doubles
    mean: Doubles
    squares: Doubles

    @classmethod
    def empty(cls, size: tuple[int, int]) -> Section:
        """Return the statistics of no samples; `size` is width and height in pixels."""
        shape = (size[1], size[0], 3)
        nothing = np.zeros(2, dtype=np.int64)
        return cls(nothing, 0, np.zeros((2, *shape)), np.zeros(shape), np.zeros(shape))

    def add(self, group: Image, half: int, samples: int) -> None:
        """Add the mean of a group of samples, which belongs to half 0 or 1."""
        value = group.astype(np.float64)
        self.counts[half] += 1
        self.samples += samples
        self.sums[half] += value
        offset = value - self.mean
        self.mean = self.mean + offset / self.counts.sum()
        self.squares = self.squares + offset * (value - self.mean)

    def merge(self, other: Section) -> None:
        """Add the groups of another section."""
        own, more = int(self.counts.sum()), int(other.counts.sum())
        if not more:
            return
        offset = other.mean - self.mean
        self.mean = self.mean + offset * (more / (own + more))
        self.squares = self.squares + other.squares + offset**2 * (own * more / (own + more))
        self.counts = self.counts + other.counts
        self.samples += other.samples
        self.sums = self.sums + other.sums


def estimate(sections: Sequence[Section]) -> Estimate:
    """Return the image of all sections, which are in order."""
    height, width, _ = sections[0].mean.shape
    total = Section.empty((width, height))
    for section in sections:
        total.merge(section)
    count = int(total.counts.sum())
    mean = total.mean.astype(np.float32)
    if count == 1:
        return Estimate(mean, np.zeros_like(mean), (mean, mean), total.samples)
    first, second = (
        (half / number).astype(np.float32)
        for half, number in zip(total.sums, total.counts, strict=True)
    )
    variance = total.squares / (count - 1) / count
    return Estimate(mean, variance.astype(np.float32), (first, second), total.samples)
