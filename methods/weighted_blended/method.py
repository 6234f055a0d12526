"""Weighted blended transparency: one unordered geometry pass, one resolve.

    A = sum w (alpha L, o),    r = prod (1 - o),    C = (A.rgb / max(A.a, 1e-5)) (1 - r) + C0 r

with o = alpha (1 - mean t) and one of five weights, z in meters (the first four are tuned for 0.1
to 500 m), d the window depth:

    7:  w = o clamp(10 / (1e-5 + (z/5)^2 + (z/200)^6), 1e-2, 3e3)
    8:  w = o clamp(10 / (1e-5 + (z/10)^3 + (z/200)^6), 1e-2, 3e3)
    9:  w = o clamp(0.03 / (1e-5 + (z/200)^4), 1e-2, 3e3)
    10: w = o max(1e-2, 3e3 (1 - d)^3)
    fitted: w = o clamp(10 / (1e-5 + (z/b)^p + (z/c)^q), 1e-2, 3e3)

A fitted weight has the form of equations 7 and 8; b and c are `near_range` and `far_range`, p and q
are `near_power` and `far_power`. Their defaults are one fit to five scenes; `oitbench fit` finds
those of other scenes.

72 bits per pixel and 18 bytes of blending per fragment, as published: A in half floats, r in 8
bits. `half` and `float` store both in that format, and `float` also the final color. With `msaa` 4
each sample has sums of its own, four times the memory, and weights are those of pixel centers.

Source: McGuire & Bavoil 2013 [McGuireBavoil2013], JCGT 2(2), equations 7 to 10. Ports that print 5
instead of 10 in equation 8, 10 instead of 0.03 in equation 9, or 1 - d^3 in equation 10 disagree
with the paper and with each other; these are the constants on which at least two ports and the
paper agree.

Known failures: a front layer with alpha = 1 hides the background but not the color of transparent
layers behind it. At w = 3000 the half-float sum saturates after 21 white layers. Weights that reach
their clamp lose the order (equation 10 beyond 67 near-plane distances). In 8 bits r stalls: layers
with o < 1/510 never change it, and thicker ones stop at about r = 1/(510 o). A fitted weight holds
for scenes and distances like those of its fit: with its defaults it is constant beyond 10.4 m.
"""

import oitbench as oit

_WEIGHTS = ("7", "8", "9", "10", "fitted")


class WeightedBlended(oit.Method):
    family = "blending"
    expresses = oit.Effect.COVERAGE
    weight = oit.Parameter("10", choices=_WEIGHTS, grid=_WEIGHTS, help="equation of w, or fitted")
    precision = oit.Parameter("paper", choices=("paper", "half", "float"), help="of all targets")
    # oitbench fit 'weighted_blended[weight=fitted]' layer_stack foliage clouds
    # 'smoke_ball[detail=0.3]' bottles --size 64x64 --views 4 --degrees 15 --evaluations 50
    # found these values, from 10, 3, 200 and 6 as in equation 8.
    near_range = oit.Parameter(1.7, low=0.01, high=1000.0, help="of a fitted weight, m")
    near_power = oit.Parameter(3.81, low=0.25, high=16.0, help="of a fitted weight")
    far_range = oit.Parameter(705.0, low=0.01, high=1000.0, help="of a fitted weight, m")
    far_power = oit.Parameter(3.18, low=0.25, high=16.0, help="of a fitted weight")
    msaa = oit.MSAA
    promises = oit.promise(
        "single_layer_exact equal_layers_exact order_independent total_transmittance_exact"
        " zero_coverage_ignored white_furnace scales_with_radiance"
    )

    def plan(self, request: oit.Request) -> oit.Plan:
        paper, bits = self.precision == "paper", self.precision.replace("paper", "half")
        accum = oit.Target(oit.float_format("rgba", bits))
        reveal = oit.Target("r8" if paper else oit.float_format("r", bits), clear=(1.0,))
        writes = {"accum": oit.ADD, "reveal": oit.ATTENUATE}
        gather = oit.Gather("gather.glsl", writes=writes)
        resolve = oit.Resolve("resolve.glsl", reads=tuple(writes), writes={"color": oit.OVER})
        return oit.Plan({"accum": accum, "reveal": reveal, "color": accum}, (gather, resolve))
