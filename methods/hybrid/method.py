"""Hybrid transparency: the k nearest fragments exactly, all others by their weighted average.

    core:  c = sum_{i<k} alpha_i L_i prod_{j<i} (1 - o_j),    T = prod_{i<k} (1 - o_i)
    tail:  S = sum_{i>=k} (alpha_i L_i, o_i),    m = number with o > 0,    T' = (1 - S.a / m)^m
    C = c + T (S.rgb / S.a (1 - T') + T' C0)

One geometry pass of programmable blending inserts fragments by depth; the farthest of k + 1 is
added to the tail. Only depths decide which fragments belong to the core, so the order of the draws
only affects the rounding of the tail's sums. Up to k layers are exact.

Memory 64 k + 80 bits/pixel, 96 k + 80 with `16f`: nodes (alpha L, net opacity and a float depth), a
sum in RGBA16F and a count in R16F; 32 bits more where the driver only offers a spin lock.

Source: Maule et al. 2013, "Hybrid Transparency", I3D; the tail is that of Bavoil & Myers 2008.

Known failures: the tail ignores order and transmits too much, since (1 - mean o)^m is never less
than the product. Transmission is gray.
"""

import oitbench as oit
from oitbench.method.kits.bounded_nodes import BoundedNodes, node_targets


class Hybrid(BoundedNodes):
    quick = False
    k = oit.Parameter(4, choices=(2, 4, 8), grid=(4, 8), help="nodes per pixel")
    node = oit.Parameter(
        "8-bit",
        choices=("8-bit", "16f"),
        help="node's color; 8 bits clip radiance above one and lose layers with o < 1/510",
    )

    @property
    def promises(self) -> frozenset[str]:
        kept = oit.promise(
            "single_layer_exact equal_layers_exact order_independent opaque_front_hides"
            " zero_coverage_ignored white_furnace two_layers_ordered"
        )
        return kept | oit.promise("" if self.node == "8-bit" else "scales_with_radiance")

    def plan(self, request: oit.Request) -> oit.Plan:
        tail = {"tail": oit.Target("rgba16f"), "count": oit.Target("r16f")}
        targets = {**node_targets(self.k, self.node), **tail}
        insert = oit.Gather("insert.glsl", writes=dict.fromkeys(targets, oit.PROGRAMMABLE))
        resolve = oit.Resolve("resolve.glsl", reads=tuple(targets), writes={"color": oit.OVER})
        return oit.Plan(targets, (insert, resolve))
