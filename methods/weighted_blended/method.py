"""Weighted blended transparency: one unordered geometry pass, one resolve.

    A = sum w (alpha L, o),    r = prod (1 - o),    C = (A.rgb / max(A.a, 1e-5)) (1 - r) + C0 r

with o = alpha (1 - mean t) and one of four weights, z in metres (tuned for 0.1 to 500 m), d the
window depth:

    7:  w = o clamp(10 / (1e-5 + (z/5)^2 + (z/200)^6), 1e-2, 3e3)
    8:  w = o clamp(10 / (1e-5 + (z/10)^3 + (z/200)^6), 1e-2, 3e3)
    9:  w = o clamp(0.03 / (1e-5 + (z/200)^4), 1e-2, 3e3)
    10: w = o max(1e-2, 3e3 (1 - d)^3)

72 bits a pixel and 18 bytes of blending a fragment.

Source: McGuire & Bavoil 2013, JCGT 2(2), equations 7 to 10. Ports that print 5 instead of 10 in
equation 8, 10 instead of 0.03 in equation 9, or 1 - d^3 in equation 10 disagree with the paper and
with each other; the constants here are those on which at least two ports and the paper agree.

Known failures: a front layer with alpha = 1 hides the background but not the color of transparent
layers behind it; at w = 3000 the half-float sum saturates after 21 white layers; weights that reach
their clamp lose the order (equation 10 beyond 67 near-plane distances).
"""

from oitbench import ADD, ATTENUATE, OVER, Draws, Effect, Method, Parameter, Pass, Target


class WeightedBlended(Method):
    expresses = Effect.COVERAGE
    parameters = {
        "weight": Parameter(10, choices=(7, 8, 9, 10), grid=(7, 8, 9, 10), help="equation")
    }
    holds = frozenset({"U1", "U2", "U3", "U4", "U6", "U7", "U8", "U10"})
    targets = {"accum": Target("rgba16f", clear=(0.0,)), "reveal": Target("r8", clear=(1.0,))}
    passes = (
        Pass("gather.glsl", Draws.FRAGMENTS, writes={"accum": ADD, "reveal": ATTENUATE}),
        Pass("resolve.glsl", Draws.PIXELS, reads=("accum", "reveal"), writes={"color": OVER}),
    )
