"""Unsorted alpha blending: the over operator in submission order.

    color <- alpha L + (1 - o) color,    o = alpha (1 - mean t)

The fastest picture there is, and the unit of every cost ratio: one pass, one blended target, no
sort. Right for one layer, or where submission happens to run from far to near.

Parameters: `precision` of the color, `half` or `float`.

Source: Porter & Duff 1984, "Compositing Digital Images", SIGGRAPH.

Known failures: the image changes with the order of the draws; colored transmission turns grey; a
half float stops changing where what a layer adds is below 1/2048 of it.
"""

from collections.abc import Mapping

from oitbench import OVER, Draws, Effect, Method, Parameter, Pass, Target


class AlphaBlend(Method):
    expresses = Effect.COVERAGE
    parameters = {"precision": Parameter("half", choices=("half", "float"), help="of every target")}
    holds = frozenset({"U1", "U2", "U3", "U6", "U7", "U8", "U10"})
    passes = (Pass("over.glsl", Draws.FRAGMENTS, writes={"color": OVER}),)

    @property
    def targets(self) -> Mapping[str, Target]:
        return {"color": Target({"half": "rgba16f", "float": "rgba32f"}[self.text("precision")])}
