"""Flicker and popping of a method along a path.

Both compare displayed pictures (one exposure, clipped, sRGB), as a viewer sees them. The error of a
method in frame k is e_k = D_k(method) − D_k(exact). Its *excess change* from frame k to k + 1 is
e_{k+1} − e_k, the change of the method less that of exact compositing. Transparent layers have no
common motion, so pixels are compared where they are.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from oitbench.image.files import Image

BLOCK = 8
"""Side of the blocks of pixels in which popping is measured."""
SIGMAS = 4.0
"""Standard errors of a block's mean that are taken for noise."""
WORST = 99.9
"""Percentile of excess changes that counts as the worst one; single pixels may be anything."""
CANDIDATES = 3
"""Transitions of a path that are searched for a pop."""
VISIBLE = 1 / 255
"""A step of an 8-bit display."""
Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Flicker:
    """The excess change of one transition, over pixels with a transparent fragment.

    `mean` and `worst` (a percentile) are of the mean over the channels of a pixel's absolute
    excess change; `largest` is the largest of any pixel.
    """

    mean: float
    worst: float
    largest: float


def flicker(excess: Image, pixels: npt.NDArray[np.bool_]) -> Flicker:
    """Return the flicker of one transition.

    Parameters
    ----------
    excess : array, shape (h, w, 3)
        Excess change of the method.
    pixels : array, shape (h, w)
        Pixels with a transparent fragment before or after.
    """
    if not pixels.any():
        return Flicker(0.0, 0.0, 0.0)
    changes = np.abs(excess[pixels]).mean(axis=-1, dtype=np.float64)
    worst = float(np.percentile(changes, WORST))
    return Flicker(float(changes.mean()), worst, float(changes.max()))


def blocks(change: Image) -> tuple[Floats, Floats]:
    """Return the mean of each block of pixels, and its standard error, (rows, columns, 3).

    Blocks at the right and lower edges may be smaller.
    """
    rows, columns = (np.arange(0, side, BLOCK) for side in change.shape[:2])
    values = change.astype(np.float64)

    def total(array: Floats) -> Floats:
        summed: Floats = np.add.reduceat(np.add.reduceat(array, rows, axis=0), columns, axis=1)
        return summed

    count = total(np.ones_like(values))
    mean = total(values) / count
    variance = np.maximum(total(values**2) / count - mean**2, 0.0)
    return mean, np.sqrt(variance / count)


def jumps(change: Image) -> Floats:
    """Return how far each block jumps as a whole, in its most affected channel, (rows, columns).

    It is the mean change of the block beyond `SIGMAS` standard errors: changes of single pixels, as
    of noise and of edges, count for nothing.
    """
    mean, error = blocks(change)
    return np.asarray(np.maximum(np.abs(mean) - SIGMAS * error, 0.0).max(axis=-1))


def jump(change: Image) -> float:
    """Return how far one block jumps as a whole; `change` is that of its pixels."""
    return float(jumps(change).max())


def isolated(found: Sequence[Floats]) -> Iterator[tuple[int, tuple[int, int]]]:
    """Yield up to `CANDIDATES` transitions where a pop is most likely, each with its block.

    There, a block jumps visibly, and most beyond the jumps of the transitions before and after:
    what moves smoothly changes equally in all of them.

    Parameters
    ----------
    found : sequence of array
        `jumps` of all transitions.
    """
    scores = []
    for place, jump in enumerate(found):
        if jump.max() <= VISIBLE:
            continue
        beside = [found[k] for k in (place - 1, place + 1) if 0 <= k < len(found)]
        alone = jump - np.max(beside, axis=0) if beside else jump
        row, column = divmod(int(alone.argmax()), alone.shape[1])
        scores.append((float(alone[row, column]), place, (row, column)))
    for score, place, block in sorted(scores, reverse=True)[:CANDIDATES]:
        if score > 0 and found[place][block] > VISIBLE:
            yield place, block


def in_block(change: Image, block: tuple[int, int]) -> Image:
    """Return the part of a change that lies in a block."""
    row, column = (BLOCK * place for place in block)
    return change[row : row + BLOCK, column : column + BLOCK]


def mean(values: Sequence[float]) -> float:
    """Return the mean of some values; 0 of none."""
    return math.fsum(values) / len(values) if values else 0.0
