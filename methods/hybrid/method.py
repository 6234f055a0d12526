"""Hybrid transparency: the k nearest fragments exactly, all others by their weighted average.

    core:  c = sum_{i<k} alpha_i L_i prod_{j<i} (1 - o_j),    T = prod_{i<k} (1 - o_i)
    tail:  S = sum_{i>=k} (alpha_i L_i, o_i),    m = number with o > 0,    T' = (1 - S.a / m)^m
    C = c + T (S.rgb / S.a (1 - T') + T' C0)

One geometry pass of programmable blending: a fragment is inserted by depth, and the farthest of
k + 1 falls out into the tail. Which fragments are core depends on their depths alone, so the order
of the draws does not matter but for the rounding of the tail's sums; up to k layers are exact.

Parameters
----------
k : nodes a pixel.
node : format of a node's alpha L and net opacity: `8-bit` (RGBA8) or `16f`; its depth is a float.
    8-bit nodes clip radiance above one, and layers with o < 1/510 vanish, in the tail as well.

Memory 64 k + 80 bits/pixel, 96 k + 80 with `16f`: nodes, a sum in RGBA16F and a count in R16F; 32
bits more where the driver offers a spin lock alone.

Source: Maule et al. 2013, "Hybrid Transparency", I3D; the tail is Bavoil & Myers 2008.

Known failures: within the tail order is lost, and it transmits too much, as (1 - mean o)^m is never
less than the product. Transmission is seen in grey.
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
from oitbench.method.kits.bounded_nodes import STEPS, node_targets


class Hybrid(Method):
    quick = False
    expresses = Effect.COVERAGE
    parameters = {
        "k": Parameter(4, choices=(2, 4, 8), grid=(4, 8), help="nodes a pixel"),
        "node": Parameter("8-bit", choices=("8-bit", "16f"), help="format of a node's color"),
    }

    @property
    def holds(self) -> frozenset[str]:
        held = {"U1", "U2", "U3", "U4", "U5", "U7", "U8", "U9"}
        # Nodes of 8 bits clip.
        return frozenset(held if self.text("node") == "8-bit" else held | {"U10"})

    @property
    def record_step(self) -> float:
        return STEPS[self.text("node")]

    @property
    def targets(self) -> Mapping[str, Target]:
        nodes = node_targets(int(self.values["k"]), self.text("node"))
        return {**nodes, "tail": Target("rgba16f"), "count": Target("r16f")}

    @property
    def passes(self) -> tuple[Step, ...]:
        names = tuple(self.targets)
        return (
            Pass("insert.glsl", Draws.FRAGMENTS, writes=dict.fromkeys(names, PROGRAMMABLE)),
            Pass("resolve.glsl", Draws.PIXELS, reads=names, writes={"color": OVER}),
        )
