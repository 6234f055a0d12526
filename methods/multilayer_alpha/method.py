"""Multi-layer alpha blending: k sorted nodes a pixel, of which the last two merge when it is full.

    c_a <- c_a + (1 - o_a) c_b,    o_a <- o_a + (1 - o_a) o_b    (b fell out behind a)
    C = sum_i c_i prod_{j<i} (1 - o_j) + C0 prod_j (1 - o_j)

with premultiplied c = alpha L. One geometry pass of programmable blending. Up to k layers are exact
in any order, and so is the total transmittance of any number of layers.

Parameters
----------
k : nodes a pixel.
node : format of a node's color and net opacity: `8-bit` (RGBA8, as published), `16f` or `32f`; its
    depth is a float.

Memory 64 k bits/pixel, 96 k with `16f`, 160 k with `32f`; 32 bits more where the driver offers a
spin lock alone. OpenGL promises eight targets a pass: 16 nodes of 8 bits, 8 of `16f`, 4 of `32f`.

Source: Salvi & Vaidyanathan 2014, "Multi-Layer Alpha Blending", I3D. Nodes there hold the
transmittance 1 - o. The two agree but for rounding: half floats tell thin layers apart by opacity,
at the price of transmittances below 2^-12, which become none.

Known failures: beyond k layers the image changes with the order of the draws, and an opaque layer
need not hide what is behind it: a far fragment that came early can be merged into a node in front.
Merged 8-bit nodes stall: each merge rounds, so that many thin layers attenuate too much or not at
all (o < 1/510 vanishes), and radiance clips at one. Transmission is seen in grey.
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


class MultilayerAlpha(Method):
    quick = False
    expresses = Effect.COVERAGE
    parameters = {
        "k": Parameter(4, choices=(2, 4, 8, 16), grid=(4, 8, 16), help="nodes a pixel"),
        "node": Parameter("8-bit", choices=tuple(NODES), help="format of a node's color"),
    }

    @property
    def holds(self) -> frozenset[str]:
        held = {"U1", "U2", "U3", "U6", "U7", "U8", "U9"}
        # Nodes of 8 bits clip.
        return frozenset(held if self.text("node") == "8-bit" else held | {"U10"})

    @property
    def record_step(self) -> float:
        # Every merge rounds again.
        return 2 * STEPS[self.text("node")]

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
