"""Evenly spread random numbers for the first choices of a path.

The samples of a sub-pixel would choose independently and leave gaps. Those of one block choose by a
sequence instead, which fills the unit interval evenly: R_d (Roberts 2018, "The Unreasonable
Effectiveness of Quasirandom Sequences"). Each pixel and each block shifts it by random amounts, so
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
    """Which samples an integrator takes of some rays, one of each.

    Parameters
    ----------
    seed : int
        Of the random numbers of these rays and this sample.
    block : int
        Seed of the shifts, equal for all samples of a block and for all rays.
    number : int
        Number of the sample in its block.
    first : int
        Number of the first ray; rays are sub-pixels, row by row.
    width, ssaa : int
        Sub-pixels in a row, and in a row of one pixel. The sub-pixels of a pixel share a sequence.
    """

    seed: int
    block: int = 0
    number: int = 0
    first: int = 0
    width: int = 1
    ssaa: int = 1

    def choices(self, mitsuba: Any, drjit: Any, count: int) -> Choices:
        """Return the evenly spread numbers of `count` rays."""
        integer = mitsuba.UInt32
        first, width, ssaa, block, number = (
            drjit.opaque(integer, value)
            for value in (self.first, self.width, self.ssaa, self.block, self.number)
        )
        index = drjit.arange(integer, count) + first
        y = index // width
        x = index - y * width
        row, column = y // ssaa, x // ssaa
        pixel = row * width + column
        place = number * ssaa * ssaa + (y - row * ssaa) * ssaa + (x - column * ssaa)
        found = []
        for dimension, step in enumerate(_steps(CHOICES)):
            shift = mitsuba.sample_tea_32(pixel, block + dimension)[0]
            # In whole parts of 2³², whose sum wraps. A float32 holds 24 bits: the upper ones.
            bits = shift + place * integer(round(step * 2**32))
            found.append((bits >> 8) * 2.0**-24)
        reach, side, source, start, *pairs = found
        facet, sky = mitsuba.Point2f(*pairs[:2]), mitsuba.Point2f(*pairs[2:])
        return Choices(-drjit.log(1 - reach), start, side, facet, source, sky)


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
