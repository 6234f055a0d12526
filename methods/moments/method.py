"""Moment-based transparency: absorbance over depth in a pixel by its first n moments.

    a = -ln(1 - o),    x in [-1, 1] by `depth`,    b_0 = sum_i a_i,    T = exp(-b_0)
    power:          b_j = sum_i a_i x_i^j,                   j = 1 ... n
    trigonometric:  b_k = sum_i a_i exp(i k phi_i),          k = 1 ... n / 2
                    phi = (x + 1) (pi - w / 2),              w = pi / 10, a gap
    b' = (1 - e) b / b_0 + e b*,    e and b* by basis, n and storage
    vis = exp(-b_0 A),    A = sum of w_k with x_k < x, + kappa w(x)
    C = (1 - T) sum_i alpha_i L_i vis_i / sum_i o_i vis_i + C0 T

Of all distributions with the moments b', the one with a layer at x and n/2 others has the least
absorbance before x: places x_k and weights w_k. `overestimation` kappa adds a part of the weight at
x; 0 is the sharp lower bound, and exact for at most n/2 places, up to the bias e. `depth` is `log`
of distances over those of all transparent geometry, `linear` over the pixel's own range (a further
geometry pass), or the `window` depth.

Ruling: the published solution by LDL^T and closed roots divides by zero, or by rounding, where
layers lie at fewer than n/2 places: for a single layer or coplanar ones. Here polynomials come from
recurrences (Chebyshev, Szego) whose pivots are at least 1e-7 and whose centers are within [-1, 1],
so that weights are positive and finite. Those but w(x) share 1 - w(x) in proportion. Layers at one
place have equal visibility, which cancels out; any value is exact. Solved are s = 1 / (x_k - x),
which no coefficient sends to infinity.

All operations are sums, so the order of the draws only changes rounding; `unorm16` keeps the mean
of moments in 16 bits by programmable blending.

Memory: b_0 and n floats (20, 28, 36 B) or 16-bit numbers (12, 16, 20 B), 16 B of sums, and 8 B of
bounds with `linear`; 4 B more for `unorm16` where the driver only offers a spin lock. With `msaa` 4
each sample has all of these, and layers are shaded for each sample, at its depth.

Source: Muenstermann et al. 2018 [Muenstermann2018], "Moment-Based Order-Independent Transparency",
I3D. There, n/2 complex moments are called n/2; their ramp over the gap is nearly linear in angle,
here exactly.

Known failures: layers at more than n/2 places show through each other. `log` depends on transparent
geometry anywhere, even if it is clear or out of view. In `window` depth layers are so close that
rounding matters, and with it their order. An opaque layer counts as one that transmits 1e-5.
Transmission is gray.
"""

import oitbench as oit
from oitbench.method.kits.absorbance import BOUNDS, FIND_BOUNDS


class Moments(oit.Method):
    family = "curves"
    quick = False
    expresses = oit.Effect.COVERAGE
    basis = oit.Parameter(
        "power",
        choices=("power", "trigonometric"),
        grid=("power", "trigonometric"),
        help="functions of depth; n / 2 complex trigonometric ones",
    )
    count = oit.Parameter(
        6, choices=(4, 6, 8), grid=(4, 6, 8), sweep=True, help="n, numbers beside b_0"
    )
    storage = oit.Parameter("float", choices=("float", "unorm16"), help="of moments")
    overestimation = oit.Parameter(0.25, low=0.0, high=1.0, help="kappa: 0, 0.1 and 0.25 are usual")
    depth = oit.Parameter(
        "log", choices=("log", "linear", "window"), help="what moments are taken of"
    )
    msaa = oit.MSAA

    @property
    def promises(self) -> frozenset[str]:
        kept = oit.promise(
            "single_layer_exact equal_layers_exact total_transmittance_exact white_furnace"
            " scales_with_radiance"
        )
        kept |= oit.promise("" if self.depth == "log" else "zero_coverage_ignored")
        exact = self.storage == "float" and self.depth != "window"
        return kept | oit.promise("order_independent" if exact else "")

    def plan(self, request: oit.Request) -> oit.Plan:
        packed, width = self.storage == "unorm16", 2 if self.count == 6 else 4
        curve = {"total": oit.Target("r32f")}
        if packed:
            curve |= {f"words{i}": oit.Target("r32ui") for i in range(self.count // 2)}
        else:
            kind = oit.Target("rg32f" if width == 2 else "rgba32f")
            curve |= {f"moments{i}": kind for i in range(self.count // width)}
        bounds = {"bounds": BOUNDS} if self.depth == "linear" else {}
        size = {} if packed else {"WIDTH": width}
        blend = oit.PROGRAMMABLE if packed else oit.ADD
        generate = oit.Gather(
            "generate.glsl", tuple(bounds), dict.fromkeys(curve, blend), defines=size
        )
        composite = oit.Gather("composite.glsl", (*bounds, *curve), {"sum": oit.ADD}, defines=size)
        resolve = oit.Resolve("resolve.glsl", reads=("total", "sum"), writes={"color": oit.OVER})
        wide = {"sum": oit.Target("rgba32f"), "color": oit.Target("rgba32f")}
        find = (FIND_BOUNDS,) if bounds else ()
        return oit.Plan({**bounds, **curve, **wide}, (*find, generate, composite, resolve))
