"""Depth-layered weighted blending: K averages in a row of depth slabs, each over the next.

    t = ln(z / nearest) / ln(farthest / nearest),    u = clamp(K t - 1/2, 0, K - 1)
    s_k = max(1 - |u - k|, 0),    a_k = -s_k ln(1 - o),    o_k = 1 - exp(-a_k)
    S_k = sum (alpha L o_k / o, o_k),    T_k = exp(-sum a_k)
    C = sum_k S_k.rgb / S_k.a (1 - T_k) prod_{j<k} T_j + C0 prod_k T_k

A fragment lies between two slabs, which share its absorbance: the product of both transmittances
is that of the fragment, so the total is exact for every K. Within a slab, layers are averaged by
their opacity. K = 1 is the weighted average over an exact total. The bounds of a pixel are those of
its layers that absorb. Slabs are of equal ratios of distance.

One geometry pass finds the bounds and one fills the slabs; eight slabs take two, since a pass can
write eight targets. All targets are blended by fixed functions, by sums and one maximum.

Memory 10 K + 8 B/pixel: color and opacity in RGBA16F, absorbance in a half float, two float bounds;
20 K + 8 B with `float`. With `msaa` 4 each sample has bounds and slabs of its own, and layers are
shaded for each sample, at its depth.

Source: our own. It is not the layered weighted blending (LWBOIT) of Friederichs, Eisemann &
Eisemann 2021 [Friederichs2021], of which only the abstract could be read, though it also spreads
the fragments over layers of depth.

Known failures: layers of one slab are averaged without regard to their order, and a far layer
stretches all slabs. An opaque layer shows layers of its slab that lie behind it. Half-float sums
stall after about 2048 equal layers. An opaque layer counts as one that transmits 2^-24.
Transmission is gray.
"""

import oitbench as oit
from oitbench.method.kits.absorbance import BOUNDS, FIND_BOUNDS

_PER_PASS = 4
"""Slabs that one pass fills; with their absorbances in one target they are five targets."""
_BLOCKS = ("near", "far")


class DepthLayered(oit.Method):
    family = "blending"
    quick = False
    expresses = oit.Effect.COVERAGE
    layers = oit.Parameter(4, choices=(1, 2, 4, 8), grid=(4, 8), help="K, number of slabs")
    precision = oit.Parameter("half", choices=("half", "float"), help="of slabs and final color")
    msaa = oit.MSAA

    @property
    def promises(self) -> frozenset[str]:
        kept = oit.promise(
            "single_layer_exact equal_layers_exact order_independent total_transmittance_exact"
            " zero_coverage_ignored white_furnace scales_with_radiance"
        )
        return kept | oit.promise("two_layers_ordered" if self.layers > 1 else "")

    def plan(self, request: oit.Request) -> oit.Plan:
        held = min(self.layers, _PER_PASS)
        color = oit.Target(oit.float_format("rgba", self.precision))
        absorbance = oit.Target(oit.float_format("rgba"[:held], self.precision))
        targets = {"bounds": BOUNDS, "color": color}
        passes: list[oit.Step] = [FIND_BOUNDS]
        slabs: list[str] = []
        for block in range(self.layers // held):
            base = _BLOCKS[block]
            own = {**{f"{base}{i}": color for i in range(held)}, f"{base}_absorbance": absorbance}
            targets |= own
            slabs += own
            passes.append(
                oit.Gather(
                    "fill.glsl",
                    reads=("bounds",),
                    writes=dict.fromkeys(own, oit.ADD),
                    defines={"BLOCK": block, "HELD": held},
                )
            )
        resolve = oit.Resolve(
            "resolve.glsl", reads=tuple(slabs), writes={"color": oit.OVER}, defines={"HELD": held}
        )
        return oit.Plan(targets, (*passes, resolve))
