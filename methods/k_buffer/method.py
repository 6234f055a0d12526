"""k-buffer: the k nearest fragments of each pixel, sorted; all others are dropped.

    C = sum_{i<k} alpha_i L_i prod_{j<i} (1 - o_j) + C0 prod_{j<k} (1 - o_j)

One geometry pass of programmable blending inserts fragments by depth; the farthest of k + 1 is
dropped. The result is that of the first k layers for any order of the draws; equal depths are
ordered by the content of the nodes.

Memory 64 k bits/pixel, 96 k with `16f`, 160 k with `32f`: nodes with alpha L, net opacity and a
float depth; 32 bits more where the driver only offers a spin lock. Published figures of 64 k + 64
include a count of nodes; here empty nodes have the largest depth instead. OpenGL guarantees eight
targets per pass: 16 nodes of 8 bits, 8 of `16f`, 4 of `32f`. With `msaa` 4 each sample has nodes of
its own.

Sources: Bavoil et al. 2007 [Bavoil2007], "Multi-Fragment Effects on the GPU using the k-Buffer";
Vasilakis & Fudos 2014 [VasilakisFudos2014], "k+-buffer", which is order independent like this one.

Known failures: layers beyond the first k do not even attenuate the background. Transmission is
gray.
"""

import oitbench as oit
from oitbench.method.kits.bounded_nodes import NODES, BoundedNodes


class KBuffer(BoundedNodes):
    family = "lists"
    quick = False
    k = oit.Parameter(
        8, choices=(1, 2, 4, 8, 16), grid=(2, 4, 8, 16), sweep=True, help="nodes per pixel"
    )
    node = oit.Parameter(
        "8-bit",
        choices=tuple(NODES),
        help="node's color; 8 bits clip radiance above one and lose layers with o < 1/510",
    )

    @property
    def promises(self) -> frozenset[str]:
        kept = oit.promise(
            "single_layer_exact order_independent opaque_front_hides zero_coverage_ignored"
            " white_furnace"
        )
        kept |= oit.promise("two_layers_ordered" if self.k > 1 else "")
        return kept | oit.promise("" if self.node == "8-bit" else "scales_with_radiance")
