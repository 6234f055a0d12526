"""Evenly spread random numbers for the first choices of a path.

The samples of a sub-pixel would choose independently and leave gaps. Those of one block choose by
Sobol's sequence instead, which fills the unit square evenly. Each choice shuffles the order of the
points and scrambles them (Burley 2020, "Practical Hash-based Owen Scrambling"). Every sample is
thus unbiased, choices are independent of each other, and so are pixels and blocks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

EVEN_BOUNCES = 2
"""Changes of direction after which a path uses other random numbers. Their few digits are spent."""
DIGITS = 32
_MIXING = 0x6C50B47C, 0xB82F1E52, 0xC7AFE638, 0x8D22F6E6
"""Even factors, so that a bit changes higher bits only (Laine & Karras 2011)."""


def seed_of(*key: int) -> int:
    """Return a seed of 32 bits that is independent of those of other keys."""
    return int(np.random.SeedSequence(key).generate_state(1)[0])


@dataclass(frozen=True)
class Turn:
    """Which samples an integrator takes of some rays, one of each.

    Parameters
    ----------
    seed : int
        Of the random numbers of these rays and this sample.
    block : int
        Seed of the scrambling, equal for all samples of a block and for all rays.
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
        points = []
        for choice in range(6):
            seeds = [
                seed
                for half in range(2)
                for seed in mitsuba.sample_tea_32(pixel, block + integer(2 * choice + half))
            ]
            points.append(_point(mitsuba, drjit, place, seeds))
        reach, start, side, source = (point.x for point in points[:4])
        return Choices(-drjit.log(1 - reach), start, side, points[4], source, points[5])


def _point(mitsuba: Any, drjit: Any, place: Any, seeds: list[Any]) -> Any:
    """Return a point of Sobol's sequence, Point2f in [0, 1)², shuffled and scrambled by `seeds`."""
    order = _scrambled(drjit, place, seeds[0])
    first, second = drjit.brev(order), type(place)(0)
    column = 1 << 31
    for digit in range(DIGITS):
        second = second ^ drjit.select((order >> digit) & 1 > 0, type(place)(column), 0)
        column ^= column >> 1
    parts = _scrambled(drjit, first, seeds[1]), _scrambled(drjit, second, seeds[2])
    # A float32 holds 24 bits: the upper ones of 32.
    return mitsuba.Point2f(*((part >> 8) * 2.0**-24 for part in parts))


def _scrambled(drjit: Any, value: Any, seed: Any) -> Any:
    """Return `value` with each binary digit flipped at random, as `seed` and higher digits say."""
    value = drjit.brev(value) + seed
    for factor in _MIXING:
        value = value ^ (value * type(value)(factor))
    return drjit.brev(value)


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
