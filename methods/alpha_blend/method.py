"""Unsorted alpha blending: the over operator in submission order.

    color <- alpha L + (1 - o) color,    o = alpha (1 - mean t)

The fastest picture there is, and the unit of every cost ratio: one pass, one blended target, no
sort. Right for one layer, or where submission happens to run from far to near.

Source: Porter & Duff 1984, "Compositing Digital Images", SIGGRAPH.

Known failures: the image changes with the order of the draws; colored transmission turns grey.
"""

from oitbench import OVER, Draws, Effect, Method, Pass


class AlphaBlend(Method):
    expresses = Effect.COVERAGE
    holds = frozenset({"U1", "U2", "U3", "U6", "U7", "U8", "U10"})
    passes = (Pass("over.glsl", Draws.FRAGMENTS, writes={"color": OVER}),)
