"""Frames of a cell without sub-pixels: what one costs, and what the order of draws changes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from oitbench.effects import Effect
from oitbench.errors import DeclarationError
from oitbench.gl.frame import Frame, Image
from oitbench.gl.plan import FramePlan
from oitbench.image import metrics
from oitbench.matrix.cell import Cell
from oitbench.matrix.stage import Stage
from oitbench.measure import accounting
from oitbench.method.declaration import Method
from oitbench.results.schema import Memory, PassRuns, SharedShading, Traffic

_EQUAL = 8
"""Permuted pictures after which no more are drawn if all are equal: two draws whose order matters
keep it in all of them with a probability of 1 : 128."""


@dataclass(frozen=True, eq=False)
class Counted:
    """The picture of one frame without sub-pixels, and its accounts.

    `transmittance` is the picture of it alone, None unless the cell compares it without sub-pixels.
    """

    image: Image
    transmittance: Image | None
    passes: list[PassRuns]
    memory: Memory
    traffic: Traffic
    shading: SharedShading


@dataclass(frozen=True)
class PlainFrames:
    """Frames of one cell without sub-pixels.

    Parameters
    ----------
    stage : Stage
    cell : Cell
    method : Method
    effects : Effect
        Effects that run.
    scored : FramePlan
        Of the frame that is scored: all others must draw the same.
    """

    stage: Stage
    cell: Cell
    method: Method
    effects: Effect
    scored: FramePlan

    def count(self) -> Counted:
        """Return the pictures of a frame, and count its memory and traffic."""
        uploaded, size = self.stage.coarse, self.cell.size
        with Frame(uploaded, self.method, size, self.effects, counted=True) as frame:
            self._require_same(frame.plan, "it is counted")
            measured = frame.measure()
            image = frame.image()
            accounts = (
                [PassRuns(record.name, record.runs) for record in measured.passes],
                accounting.memory(frame),
                accounting.traffic(frame, measured),
                accounting.shading(frame, measured),
            )
            transmittance = None
            if self.cell.reduced:
                frame.render(transmittance=True)
                transmittance = frame.image()
            return Counted(image, transmittance, *accounts)

    def order_spread(self) -> dict[str, float | None]:
        """Return how far pictures of permuted draws differ, which small ones show as well."""
        size = self.cell.order_size
        with Frame(self.stage.at(size[1]), self.method, size, self.effects) as frame:
            self._require_same(frame.plan, "its draws are permuted")

            return metrics.order_spread(permuted(frame, self.cell.permutations))

    def _require_same(self, plan: FramePlan, when: str) -> None:
        """Raise `DeclarationError` if a frame does not draw what the scored frame draws."""
        if plan.digest != self.scored.digest:
            raise DeclarationError(
                f"{plan.label}: plan returns other passes when {when}; it must depend on parameters"
                " and its request alone"
            )


def permuted(frame: Frame, count: int) -> Iterator[Image]:
    """Yield pictures of permuted draws: `count`, or fewer if the first ones are equal."""
    first: Image | None = None
    equal = True
    for number in range(1, count + 1):
        if equal and number > _EQUAL:
            return
        frame.render(permutation=number)
        image = frame.image()
        first = image if first is None else first
        equal = equal and np.array_equal(first, image)
        yield image
