"""Weighted average: the mean color of all layers, seen through as many layers of mean opacity.

    S = sum (alpha L, o),  n = number of layers,  r = (1 - S.a/n)^n
    C = (S.rgb / S.a) (1 - r) + C0 r

with o = alpha (1 - mean t). One unordered geometry pass and one resolve; nothing depends on depth.
Exact where all layers share color and opacity. By the inequality of arithmetic and geometric means
r >= prod (1 - o), so the background is never too dark. 80 bits per pixel (96 with a 32-bit count)
and 20 (24) bytes of blending per fragment. With `msaa` 4 each sample has sums of its own, four
times the memory, and is resolved separately.

Only layers that absorb are counted: a layer with o = 0 hides nothing and must not lower the mean.
Where S.a is below 1e-4 the factor (1 - r) / S.a is replaced by its limit, one, so that highlights
on clear glass stay.

Source: Bavoil & Myers 2008 [BavoilMyers2008], "Order Independent Transparency with Dual Depth
Peeling", NVIDIA.

Known failures: depth is ignored. Swapping two layers changes nothing, and an opaque front layer
hides neither the layers behind it nor, beside thin layers, the background. Half-float sums stall
after about 2048 equal layers, and so does a count in `r16f`.
"""

import oitbench as oit


class WeightedAverage(oit.Method):
    family = "blending"
    quick = False
    expresses = oit.Effect.COVERAGE
    count = oit.Parameter("r16f", choices=("r16f", "r32f"), help="format of n")
    precision = oit.Parameter("half", choices=("half", "float"), help="of all other targets")
    msaa = oit.MSAA
    promises = oit.promise(
        "single_layer_exact equal_layers_exact order_independent zero_coverage_ignored"
        " white_furnace scales_with_radiance"
    )

    def plan(self, request: oit.Request) -> oit.Plan:
        color = oit.Target(oit.float_format("rgba", self.precision))
        sums = ("sum", "number")
        gather = oit.Gather("gather.glsl", writes=dict.fromkeys(sums, oit.ADD))
        resolve = oit.Resolve("resolve.glsl", reads=sums, writes={"color": oit.OVER})
        targets = {"sum": color, "number": oit.Target(self.count), "color": color}
        return oit.Plan(targets, (gather, resolve))
