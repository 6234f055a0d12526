"""k-buffer: the k nearest fragments of each pixel, sorted; what lies beyond them is dropped.

    C = sum_{i<k} alpha_i L_i prod_{j<i} (1 - o_j) + C0 prod_{j<k} (1 - o_j)

One geometry pass of programmable blending: a fragment is inserted by depth, and the farthest of
k + 1 falls out. The result is that of the first k layers whatever the order of the draws; equal
depths are ordered by what the nodes hold.

Parameters
----------
k : nodes a pixel.
node : format of a node's alpha L and net opacity: `8-bit` (RGBA8), `16f` or `32f`; its depth is a
    float. 8-bit nodes clip radiance above one, and layers with o < 1/510 vanish.

Memory 64 k bits/pixel, 96 k with `16f`, 160 k with `32f`; 32 bits more where the driver offers a
spin lock alone. Published figures of 64 k + 64 hold a count of nodes too: here empty nodes have the
largest depth instead. OpenGL promises eight targets a pass: 16 nodes of 8 bits, 8 of `16f`, 4 of
`32f`.

Sources: Bavoil et al. 2007, "Multi-Fragment Effects on the GPU using the k-Buffer"; Vasilakis &
Fudos 2014, "k+-buffer", whose order-independence this one has.

Known failures: layers beyond k do not even attenuate the background. Transmission is seen in grey.
"""

from collections.abc import Mapping

from oitbench import (
    OVER,
    PROGRAMMABLE,
    Draws,
    Effect,
    Method,
    Parameter,
    Pass,
    Step,
    Target,
)
from oitbench.method.kits.bounded_nodes import NODES, STEPS, node_targets


class KBuffer(Method):
    quick = False
    expresses = Effect.COVERAGE
    parameters = {
        "k": Parameter(8, choices=(1, 2, 4, 8, 16), grid=(4, 8, 16), help="nodes a pixel"),
        "node": Parameter("8-bit", choices=tuple(NODES), help="format of a node's color"),
    }

    @property
    def holds(self) -> frozenset[str]:
        held = {"U1", "U2", "U4", "U5", "U7", "U8"}
        held |= {"U9"} if int(self.values["k"]) > 1 else set()
        # Nodes of 8 bits clip.
        return frozenset(held if self.text("node") == "8-bit" else held | {"U10"})

    @property
    def record_step(self) -> float:
        return STEPS[self.text("node")]

    @property
    def targets(self) -> Mapping[str, Target]:
        wide = {"color": Target("rgba32f")} if self.text("node") == "32f" else {}
        return {**node_targets(int(self.values["k"]), self.text("node")), **wide}

    @property
    def passes(self) -> tuple[Step, ...]:
        nodes = tuple(node_targets(int(self.values["k"]), self.text("node")))
        return (
            Pass("insert.glsl", Draws.FRAGMENTS, writes=dict.fromkeys(nodes, PROGRAMMABLE)),
            Pass("resolve.glsl", Draws.PIXELS, reads=nodes, writes={"color": OVER}),
        )
