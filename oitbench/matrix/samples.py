"""What cells cost at their full size, extrapolated from drawings at two small ones.

Every part of a cell that depends on its size grows with the number of pixels, so that two sizes
determine it. Permuted draws are the exception, as their pictures are small in every cell.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import msgspec

from oitbench.image.metrics import RMSE
from oitbench.matrix.cell import Cell
from oitbench.matrix.probe import ProbedTruth
from oitbench.results.schema import COMPLEXITY, TRANSMITTANCE, Outcome, flip_image
from oitbench.truths import EXACT

Size = tuple[int, int]
_OWN_BYTES = 20
"""Of the picture and the depth of a frame, for each pixel, which no method accounts for."""


@dataclass(frozen=True)
class Drawn:
    """A cell that was drawn at some size, and scored against exact compositing.

    Parameters
    ----------
    seconds : float
        Seconds of drawing it but for permuted draws, and of what all cells of its scene share if it
        is the first one.
    permutations : float
        Seconds of its permuted draws.
    building, metrics : float
        Seconds of building its scene, and of scoring it.
    line : int
        Bytes of its record.
    outcome : Outcome
    """

    seconds: float
    permutations: float
    building: float
    metrics: float
    line: int
    outcome: Outcome

    @property
    def perfect(self) -> bool:
        """Whether its picture equals exact compositing, so that FLIP had no pixel to evaluate."""
        scores = self.outcome.scores.get(EXACT)
        return scores is not None and scores.metrics.get(RMSE) == 0.0


@dataclass(frozen=True)
class Sample:
    """Costs of a cell at its full size.

    Parameters
    ----------
    cell : Cell
    first : float
        Seconds that only the first drawing takes, as it compiles shaders.
    drawing, permutations : float
        Seconds of each further one: without permuted draws, and of these.
    metrics : float, optional
        Seconds of scoring it against a truth; unknown if it equals exact compositing.
    round : float
        Seconds of it in one round of timing; 0 without timing.
    picture, flip, shared : float
        Bytes of its picture and its record, of one map of FLIP, and of exact compositing with all
        maps that the cells of a scene share.
    memory : float
        Bytes of the frame that is timed.
    """

    cell: Cell
    first: float
    drawing: float
    permutations: float
    metrics: float | None
    round: float
    picture: float
    flip: float
    shared: float
    memory: float

    @property
    def again(self) -> float:
        """Seconds of each drawing but the first one."""
        return self.drawing + self.permutations


@dataclass
class SceneSamples:
    """Samples of the cells of one scene, and the seconds of what its cells share.

    Parameters
    ----------
    cells : list of Cell
        All cells to run.
    samples : list of Sample
        Empty if none could be drawn.
    building : float
        Seconds of building the scene.
    sharing : float
        Seconds of uploading it, and of exact compositing at the full size.
    truths : list of ProbedTruth
    """

    cells: list[Cell]
    samples: list[Sample] = field(default_factory=list)
    building: float = 0.0
    sharing: float = 0.0
    truths: list[ProbedTruth] = field(default_factory=list)


def separate_shared(
    found: SceneSamples, again: Drawn, shared: float | None, pixels: Sequence[int]
) -> None:
    """Count what all samples share for their scene, and not for the first one of them.

    Parameters
    ----------
    found : SceneSamples
    again : Drawn
        The first cell at the small size, after all else was drawn there.
    shared : float, optional
        Seconds of what is shared at the middle size, if cells were drawn there.
    pixels : sequence of int
        Of the small, the middle and the full size.
    """
    first, *others = found.samples
    usual = min(first.first, sum(sample.first for sample in others) / max(1, len(others)))
    found.samples[0] = replace(first, first=usual)
    excess = first.first - usual
    if shared is None:
        found.sharing = excess * first.drawing / again.seconds
    else:
        found.sharing = extrapolate(pixels, min(excess, shared), shared)


def permuted_growth(cell: Cell, small: Size) -> float:
    """Return the pixels of a cell's permuted pictures, relative to those of a small cell."""
    smaller = msgspec.structs.replace(cell, size=small)
    return math.prod(cell.order_size) / math.prod(smaller.order_size)


def extrapolated(
    cell: Cell,
    pixels: Sequence[int],
    smaller: Drawn | None,
    larger: Drawn,
    *,
    first: float,
    permutations: float,
    round: float,
) -> Sample:
    """Return the costs of a cell at its full size, from two small ones.

    Parameters
    ----------
    cell : Cell
    pixels : sequence of int
        Of the smaller, the larger and the full size.
    smaller : Drawn, optional
        Default: costs are proportional to the pixels.
    larger : Drawn
    first : float
        Seconds that only the first drawing took.
    permutations : float
        Seconds of its permuted draws.
    round : float
        Seconds in one round of timing at the larger size.
    """

    def full(cost: Callable[[Drawn], float]) -> float:
        if smaller is None:
            return cost(larger) * pixels[2] / pixels[1]
        return extrapolate(pixels, cost(smaller), cost(larger))

    drawing = full(lambda drawn: drawn.seconds)
    return Sample(
        cell,
        first=first,
        drawing=drawing,
        permutations=permutations,
        metrics=None if larger.perfect else full(lambda drawn: drawn.metrics),
        round=round * drawing / larger.seconds,
        picture=full(lambda drawn: _bytes(drawn, "color")) + larger.line,
        flip=full(lambda drawn: _bytes(drawn, flip_image(EXACT))),
        shared=full(lambda drawn: _bytes(drawn, EXACT, COMPLEXITY, TRANSMITTANCE)),
        memory=_OWN_BYTES * pixels[-1] + full(lambda drawn: drawn.outcome.memory.bytes),
    )


def extrapolate(pixels: Sequence[int], small: float, middle: float) -> float:
    """Return a cost at the last of three numbers of pixels; it never falls with more of them."""
    if pixels[1] == pixels[0]:
        return middle
    slope = max(0.0, middle - small) / (pixels[1] - pixels[0])
    return middle + slope * (pixels[2] - pixels[1])


def _bytes(drawn: Drawn, *kinds: str) -> int:
    images = drawn.outcome.images
    return sum(images[kind].bytes for kind in kinds if kind in images)
