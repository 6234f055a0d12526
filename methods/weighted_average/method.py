"""Weighted average: the mean color of all layers, seen through as many layers of mean opacity.

    S = sum (alpha L, o),  n = number of layers,  r = (1 - S.a/n)^n
    C = (S.rgb / S.a) (1 - r) + C0 r

with o = alpha (1 - mean t). One unordered geometry pass, one resolve, nothing that depends on
depth; exact where all layers share color and opacity. By the inequality of the means r >= prod
(1 - o): the background is never too dark. 80 bits a pixel (96 with a 32-bit count), and 20 (24)
bytes of blending a fragment.

Only layers that absorb are counted: one of o = 0 hides nothing, so it must not thin out the mean.
Where S.a is below 1e-4 the factor (1 - r) / S.a is taken as one, its limit, so that highlights on
clear glass stay.

Parameters
----------
count : format of n. `r16f` is exact up to 2048 layers, and stalls there; `r32f` goes on.
precision : of all other targets, `half` or `float`.

Source: Bavoil & Myers 2008, "Order Independent Transparency with Dual Depth Peeling", NVIDIA.

Known failures: no notion of depth: swapping two layers changes nothing, and an opaque front layer
hides neither what is behind it nor, beside thin layers, the background. Half floats stall after
about 2048 equal layers.
"""

from collections.abc import Mapping

from oitbench import ADD, OVER, Draws, Effect, Method, Parameter, Pass, Target


class WeightedAverage(Method):
    quick = False
    expresses = Effect.COVERAGE
    parameters = {
        "count": Parameter("r16f", choices=("r16f", "r32f"), help="format of the count"),
        "precision": Parameter("half", choices=("half", "float"), help="of other targets"),
    }
    holds = frozenset({"U1", "U2", "U3", "U4", "U7", "U8", "U10"})
    passes = (
        Pass("gather.glsl", Draws.FRAGMENTS, writes={"sum": ADD, "number": ADD}),
        Pass("resolve.glsl", Draws.PIXELS, reads=("sum", "number"), writes={"color": OVER}),
    )

    @property
    def targets(self) -> Mapping[str, Target]:
        texel = {"half": "rgba16f", "float": "rgba32f"}[self.text("precision")]
        return {
            "sum": Target(texel),
            "number": Target(self.text("count")),
            "color": Target(texel),
        }
