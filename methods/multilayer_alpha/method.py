"""Multi-layer alpha blending: k sorted nodes per pixel; the last two merge when it is full.

    c_a <- c_a + (1 - o_a) c_b,    o_a <- o_a + (1 - o_a) o_b    (b no longer fits behind a)
    C = sum_i c_i prod_{j<i} (1 - o_j) + C0 prod_j (1 - o_j)

with premultiplied c = alpha L. One geometry pass of programmable blending. Up to k layers are exact
in any order, and so is the total transmittance of any number of layers.

Memory 64 k bits/pixel, 96 k with `16f`, 160 k with `32f`: nodes with color, net opacity and a float
depth; 32 bits more where the driver only offers a spin lock. OpenGL guarantees eight targets per
pass: 16 nodes of 8 bits, 8 of `16f`, 4 of `32f`. With `msaa` 4 each sample has nodes of its own.

Source: Salvi & Vaidyanathan 2014 [SalviVaidyanathan2014], "Multi-Layer Alpha Blending", I3D. Their
nodes hold the transmittance 1 - o. Both agree except for rounding: half floats resolve thin layers
by opacity, but lose transmittances below 2^-12.

Known failures: beyond k layers the image depends on the order of the draws, and an opaque layer
need not hide the layers behind it: a far fragment that came early can be merged into a nearer node.
Merged 8-bit nodes stall: each merge rounds, so many thin layers attenuate too much or not at all
(layers with o < 1/510 vanish). Transmission is gray.
"""

import oitbench as oit
from oitbench.method.kits.bounded_nodes import NODES, BoundedNodes


class MultilayerAlpha(BoundedNodes):
    family = "lists"
    quick = False
    k = oit.Parameter(
        4, choices=(2, 4, 8, 16), grid=(2, 4, 8, 16), sweep=True, help="nodes per pixel"
    )
    node = oit.Parameter(
        "8-bit",
        choices=tuple(NODES),
        help="node's color; 8 bits, as published, clip radiance above one",
    )

    @property
    def promises(self) -> frozenset[str]:
        kept = oit.promise(
            "single_layer_exact equal_layers_exact total_transmittance_exact zero_coverage_ignored"
            " white_furnace two_layers_ordered"
        )
        return kept | oit.promise("" if self.node == "8-bit" else "scales_with_radiance")

    @property
    def record_step(self) -> float:
        return 2 * super().record_step  # every merge rounds again
