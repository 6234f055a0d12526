"""Hybrid transparency: the k nearest fragments exactly, all others by their weighted average.

    core:  c = sum_{i<k} alpha_i L_i prod_{j<i} (1 - o_j),    T = prod_{i<k} (1 - o_i)
    tail:  S = sum_{i>=k} (alpha_i L_i, o_i),    m = number with o > 0,    T' = (1 - S.a / m)^m
    C = c + T (S.rgb / S.a (1 - T') + T' C0)

One geometry pass of programmable blending inserts fragments by depth; the farthest of k + 1 is
added to the tail. Only depths decide which fragments belong to the core, so the order of the draws
only affects the rounding of the tail's sums. Up to k layers are exact. `k=1` is an exact front
layer plus a weighted tail.

With `transmittance=exact`, T' is the product of 1 - o over the tail. Then `admission=0.05` is the
rule of hybrid splats: only fragments with o >= 0.05 enter the core, and fainter ones join the tail
wherever they are.

Memory 64 k + 80 bits/pixel, 96 k + 80 with `16f`: nodes (alpha L, net opacity and a float depth), a
sum in RGBA16F and a count in R16F; 16 bits more for an exact T' in R32F, 32 bits more where the
driver only offers a spin lock. With `msaa` 4 each sample has a core and a tail of its own.

Sources: Maule et al. 2013 [Maule2013], "Hybrid Transparency", I3D; the tail is that of Bavoil &
Myers 2008 [BavoilMyers2008]. Exact T' and the admission: Hahlbohm et al. 2025 [Hahlbohm2025],
"Efficient Perspective-Correct 3D Gaussian Splatting Using Hybrid Transparency", Eurographics.

Known failures: the tail ignores order and transmits too much, since (1 - mean o)^m is never less
than the product. Faint layers that are not admitted lie behind the core. Transmission is gray.
"""

import oitbench as oit
from oitbench.method.kits.bounded_nodes import BoundedNodes, node_targets


class Hybrid(BoundedNodes):
    family = "lists"
    quick = False
    k = oit.Parameter(4, choices=(1, 2, 4, 8), grid=(4, 8), help="nodes per pixel")
    node = oit.Parameter(
        "8-bit",
        choices=("8-bit", "16f"),
        help="node's color; 8 bits clip radiance above one and lose layers with o < 1/510",
    )

    transmittance = oit.Parameter(
        "mean",
        choices=("mean", "exact"),
        help="T' of the tail: by its mean opacity, or the product",
    )
    admission = oit.Parameter(
        0.0, low=0.0, high=1.0, help="least net opacity in the core; hybrid splats have 0.05"
    )

    @property
    def promises(self) -> frozenset[str]:
        kept = oit.promise(
            "single_layer_exact equal_layers_exact order_independent opaque_front_hides"
            " zero_coverage_ignored white_furnace"
        )
        kept |= oit.promise("two_layers_ordered" if self.admission == 0 else "")
        kept |= oit.promise("total_transmittance_exact" if self._exact else "")
        return kept | oit.promise("" if self.node == "8-bit" else "scales_with_radiance")

    @property
    def _exact(self) -> bool:
        return self.transmittance == "exact"

    def plan(self, request: oit.Request) -> oit.Plan:
        passed = {"passed": oit.Target("r32f", clear=(1.0,))}
        total = passed if self._exact else {"count": oit.Target("r16f")}
        targets = {**node_targets(self.k, self.node), "tail": oit.Target("rgba16f"), **total}
        insert = oit.Gather("insert.glsl", writes=dict.fromkeys(targets, oit.PROGRAMMABLE))
        resolve = oit.Resolve("resolve.glsl", reads=tuple(targets), writes={"color": oit.OVER})
        return oit.Plan(targets, (insert, resolve))
