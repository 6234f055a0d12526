"""Evenly spread random numbers for the first choices of a path.

The samples of a sub-pixel would choose independently and leave gaps. Those of one block choose by a
sequence instead, which fills the unit interval evenly: R_d (Roberts 2018, "The Unreasonable
Effectiveness of Quasirandom Sequences"). Each ray and each block shifts it by random amounts, so
that every sample is unbiased, and blocks are independent.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

CHOICES = 8
EVEN_BOUNCES = 2
"""Changes of direction after which a path uses other random numbers. Their few digits are spent."""


def _steps(dimensions: int) -> list[float]:
    """Return the powers of 1/φ, where φ is the root above 1 of φ^(d + 1) = φ + 1."""
    root = 1.5
    for _ in range(64):
        root = (1 + root) ** (1 / (dimensions + 1))
    return [root**-power for power in range(1, dimensions + 1)]


@dataclass(frozen=True)
class Turn:
    """Which one of many samples an integrator takes.

    Parameters
    ----------
    seed : int
        Of the random numbers of this sample.
    block : int
        Seed of the shifts; equal for all samples of a block.
    number : int
        Number of the sample in its block.
    """

    seed: int
    block: int = 0
    number: int = 0

    def choices(self, mitsuba: Any, drjit: Any, count: int) -> Choices:
        """Return the evenly spread numbers of `count` rays."""
        index = drjit.arange(mitsuba.UInt32, count)
        found = []
        for dimension, step in enumerate(_steps(CHOICES)):
            key = (self.block + 0x9E3779B9 * dimension) & 0xFFFFFFFF
            shift = mitsuba.sample_tea_float32(index, drjit.opaque(mitsuba.UInt32, key))
            offset = drjit.opaque(mitsuba.Float, self.number * step % 1)
            place = shift + offset
            found.append(drjit.minimum(place - drjit.floor(place), 1 - 2**-24))
        reach, place, side, source, *pairs = found
        facet, sky = mitsuba.Point2f(*pairs[:2]), mitsuba.Point2f(*pairs[2:])
        return Choices(-drjit.log(1 - reach), place, side, facet, source, sky)


@dataclass
class Choices:
    """The evenly spread numbers of paths, each in [0, 1) but the first.

    Parameters
    ----------
    reach : Float
        Optical depth that a path passes before a medium scatters or absorbs it.
    place : Float
        Where on a line of sight a medium may scatter a beam.
    side : Float
        How the path goes on at a surface.
    facet : Point2f
        In which direction.
    source, sky : Float, Point2f
        In which direction a surface looks for the environment.
    """

    reach: Any
    place: Any
    side: Any
    facet: Any
    source: Any
    sky: Any
