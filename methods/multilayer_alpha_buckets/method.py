"""Multi-layer alpha blending with a depth bucket: one node collects all faint front layers.

    front = least z with o > lower,    hidden = least z with o >= opaque
    z > hidden: dropped;    z < front: merged into node 0, the nearer in front
    else: inserted into nodes 1 to k - 1 by depth; the last two merge when they are full
    C = sum_i c_i prod_{j<i} (1 - o_j) + C0 prod_j (1 - o_j)

with premultiplied c = alpha L, merged as c_a + (1 - o_a) c_b. A geometry pass finds both depths by
blending with a minimum, which needs no order, and one of programmable blending fills the nodes.
Layers before the first strong one leave k - 1 nodes to those that matter, whatever their number.

Memory 64 k + 64 bits/pixel: nodes as in multi-layer alpha blending, and two float depths; 96 k + 64
with `16f`, 160 k + 64 with `32f`; 32 bits more where the driver only offers a spin lock. With
`msaa` 4 each sample has nodes and depths of its own.

Source: Kern, Neuhauser, Maack, Han, Usher & Westermann 2020 [Kern2020], "A Comparison of Rendering
Techniques for 3D Line Sets with Transparency", TVCG, MLABDB; constants of their code. Here, depths
are view distances, which are equal bit for bit in both passes: so no tolerance is added to
`hidden`. Layers with o < 0.001 are kept, because they may shine.

Known failures: where no layer is stronger than `lower`, as in smoke and hair, all layers merge into
node 0 in the order of the draws. Behind k - 1 strong layers the image depends on that order, too.
Layers behind one with o >= 0.98 vanish: up to 2 % of their light, and their attenuation. Merged
8-bit nodes stall, and layers with o < 1/510 are lost. Transmission is gray.
"""

from dataclasses import replace

import oitbench as oit
from oitbench.method.kits.bounded_nodes import NODES, BoundedNodes

_FAR = (3e38, 3e38)


class MultilayerAlphaBuckets(BoundedNodes):
    family = "lists"
    quick = False
    k = oit.Parameter(4, choices=(2, 4, 8, 16), grid=(4, 8), help="nodes per pixel, with node 0")
    node = oit.Parameter(
        "8-bit",
        choices=tuple(NODES),
        help="node's color; 8 bits, as published, clip radiance above one",
    )
    lower = oit.Parameter(0.2, low=0.0, high=1.0, help="net opacity that ends the bucket")
    opaque = oit.Parameter(0.98, low=0.0, high=1.0, help="net opacity that hides all behind it")

    @property
    def promises(self) -> frozenset[str]:
        kept = oit.promise(
            "single_layer_exact equal_layers_exact opaque_front_hides zero_coverage_ignored"
            " white_furnace two_layers_ordered"
        )
        return kept | oit.promise("" if self.node == "8-bit" else "scales_with_radiance")

    @property
    def record_step(self) -> float:
        return 2 * super().record_step  # every merge rounds again

    def plan(self, request: oit.Request) -> oit.Plan:
        nodes = super().plan(request)
        insert, resolve = nodes.passes
        assert isinstance(insert, oit.Gather)
        return oit.Plan(
            {"strong": oit.Target("rg32f", clear=_FAR), **nodes.targets},
            (
                oit.Gather("strong.glsl", writes={"strong": oit.MINIMUM}),
                replace(insert, reads=("strong",)),
                resolve,
            ),
        )
