"""Weighted blended transparency: one unordered geometry pass, one resolve.

    A = sum w (alpha L, o),    r = prod (1 - o),    C = (A.rgb / max(A.a, 1e-5)) (1 - r) + C0 r

with o = alpha (1 - mean t) and one of four weights, z in metres (tuned for 0.1 to 500 m), d the
window depth:

    7:  w = o clamp(10 / (1e-5 + (z/5)^2 + (z/200)^6), 1e-2, 3e3)
    8:  w = o clamp(10 / (1e-5 + (z/10)^3 + (z/200)^6), 1e-2, 3e3)
    9:  w = o clamp(0.03 / (1e-5 + (z/200)^4), 1e-2, 3e3)
    10: w = o max(1e-2, 3e3 (1 - d)^3)

72 bits a pixel and 18 bytes of blending a fragment, as published.

Parameters
----------
weight : equation of w.
precision : of A and r. `paper` has half floats and 8 bits; `half` and `float` have that for both,
    and `float` also for the final color.
msaa : samples a pixel, 1 or 4; every target then has as many.

Source: McGuire & Bavoil 2013, JCGT 2(2), equations 7 to 10. Ports that print 5 instead of 10 in
equation 8, 10 instead of 0.03 in equation 9, or 1 - d^3 in equation 10 disagree with the paper and
with each other; the constants here are those on which at least two ports and the paper agree.

Known failures: a front layer with alpha = 1 hides the background but not the color of transparent
layers behind it; at w = 3000 the half-float sum saturates after 21 white layers; weights that reach
their clamp lose the order (equation 10 beyond 67 near-plane distances). In 8 bits r stalls: layers
of o < 1/510 never change it, and thicker ones stop to at about r = 1/(510 o).
"""

from collections.abc import Mapping

from oitbench import ADD, ATTENUATE, OVER, Draws, Effect, Method, Parameter, Pass, Target


class WeightedBlended(Method):
    expresses = Effect.COVERAGE
    parameters = {
        "weight": Parameter(10, choices=(7, 8, 9, 10), grid=(7, 8, 9, 10), help="equation"),
        "precision": Parameter("paper", choices=("paper", "half", "float"), help="of all targets"),
        "msaa": Parameter(1, choices=(1, 4), help="samples a pixel"),
    }
    holds = frozenset({"U1", "U2", "U3", "U4", "U6", "U7", "U8", "U10"})
    passes = (
        Pass("gather.glsl", Draws.FRAGMENTS, writes={"accum": ADD, "reveal": ATTENUATE}),
        Pass("resolve.glsl", Draws.PIXELS, reads=("accum", "reveal"), writes={"color": OVER}),
    )

    @property
    def samples(self) -> int:
        return int(self.values["msaa"])

    @property
    def targets(self) -> Mapping[str, Target]:
        accum, reveal = {
            "paper": ("rgba16f", "r8"),
            "half": ("rgba16f", "r16f"),
            "float": ("rgba32f", "r32f"),
        }[self.text("precision")]
        return {
            "accum": Target(accum),
            "reveal": Target(reveal, clear=(1.0,)),
            "color": Target(accum),
        }
